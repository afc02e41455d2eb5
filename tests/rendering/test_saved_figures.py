"""``saved_figure``: size, margins, background and format of figures in files, read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from irsim_gym.errors import ScenarioError
from irsim_gym.live.world import load

PAPER, RED = (246, 247, 249), (255, 0, 0)


def saved(folder: Path, **options: Any) -> tuple[Image.Image, tuple[int, int], tuple[int, int]]:
    """Return the figure of a world with a red robot in its middle, a frame's size, and where the robot is on it."""
    plot = {"saved_figure": {"bbox_inches": "standard", **options}}
    robot = {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 1}, "state": [5, 5], "color": "red"}
    with load({"world": {"plot": plot}, "robot": robot}) as world:
        file = world.save_figure(folder / "figure")
        frame, layout = world.render(), world._camera._ready().layout
    column, row = layout.column_row(5.0, 5.0)
    with Image.open(file) as image:
        assert image.format == {"jpg": "JPEG"}.get(options.get("format", "png"), options.get("format", "png").upper())
        return image.convert("RGBA"), (frame.shape[1], frame.shape[0]), (int(column), int(row))


def test_a_figure_is_as_large_as_a_frame_and_looks_like_it(tmp_path: Path) -> None:
    image, size, middle = saved(tmp_path)
    assert image.size == size
    assert image.getpixel(middle) == (*RED, 255)
    assert image.getpixel((2, 2)) == (*PAPER, 255)


@pytest.mark.parametrize("dpi", [50, 200])
def test_dpi_is_the_resolution(tmp_path: Path, dpi: int) -> None:
    image, size, _ = saved(tmp_path, dpi=dpi)
    assert image.size == (size[0] * dpi // 100, size[1] * dpi // 100)


def test_tight_figures_are_cut_to_what_is_drawn_and_a_margin(tmp_path: Path) -> None:
    whole, *_ = saved(tmp_path)
    bare, *_ = saved(tmp_path, bbox_inches="tight", pad_inches=0.0)
    wide, *_ = saved(tmp_path, bbox_inches="tight", pad_inches=0.5)
    assert bare.width < whole.width
    assert bare.height < whole.height
    assert np.allclose(np.subtract(wide.size, bare.size), 100, atol=2), "half an inch on each side"


def test_null_cuts_nothing_off(tmp_path: Path) -> None:
    """As for matplotlib, where ``bbox_inches=None`` saves the whole figure."""
    image, size, _ = saved(tmp_path, bbox_inches=None)
    assert image.size == size


def test_the_background_is_as_asked_for(tmp_path: Path) -> None:
    image, _, middle = saved(tmp_path, facecolor="gold")
    assert image.getpixel((2, 2)) == (255, 215, 0, 255)
    assert image.getpixel((middle[0] + 80, middle[1])) == (255, 255, 255, 255), "the world itself stays white"
    image, _, middle = saved(tmp_path, transparent=True)
    assert image.getpixel((2, 2))[3] == image.getpixel((middle[0] + 80, middle[1]))[3] == 0
    assert image.getpixel(middle) == (*RED, 255)


@pytest.mark.parametrize("kind", ["jpg", "tiff", "webp"])
def test_the_format_is_that_of_files_without_a_suffix(tmp_path: Path, kind: str) -> None:
    image, _, middle = saved(tmp_path, format=kind)
    assert np.allclose(image.getpixel(middle), (*RED, 255), atol=12)


def test_saving_leaves_frames_as_they_are(tmp_path: Path) -> None:
    plot = {"saved_figure": {"transparent": True, "dpi": 60}}
    with load({"world": {"plot": plot}, "robot": {"kinematics": {"name": "diff"}, "state": [5, 5, 0]}}) as world:
        before = world.render()
        world.save_figure(tmp_path / "figure.png")
        assert np.array_equal(world.render(), before)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("facecolor: blurple", "2 world.plot.saved_figure.facecolor: no colour named 'blurple'"),
        ("pad_inches: -1", "2 world.plot.saved_figure.pad_inches: must be >= 0, got -1"),
        ("edgecolor: red", "2 world.plot.saved_figure.edgecolor: unknown key (did you mean 'facecolor'?)"),
    ],
)
def test_mistakes_are_told_with_their_lines(tmp_path: Path, option: str, message: str) -> None:
    file = tmp_path / "world.yaml"
    file.write_text(f"world:\n  plot: {{saved_figure: {{{option}}}}}\n")
    with pytest.raises(ScenarioError) as caught:
        load(file)
    problem = caught.value.problems[0]
    assert f"{problem.line} {problem.path}: {problem.message}".startswith(message)
