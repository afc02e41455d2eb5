"""Frames, figures and films of a world that is run by hand."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest
from small_world import world

SMALL = {
    "plot": {"figure_pixels": [240, 200], "saved_figure": {"dpi": 200, "format": "svg", "bbox_inches": "standard"}}
}


def test_frames_are_pictures_of_the_caller() -> None:
    with world(world=SMALL) as here:
        first = here.render(0.05)
        assert (first.dtype, first.shape) == (np.uint8, (200, 240, 3))
        kept = first.copy()
        here.step()
        second = here.render()
        assert not np.array_equal(first, second)
        assert np.array_equal(first, kept)
        here.reset()
        here.close()
        assert here.render().shape == first.shape


def test_figures(tmp_path: Path) -> None:
    here = world(world=SMALL)
    here.step()
    saved = here.save_figure(tmp_path / "new" / "one.png")
    assert iio.imread(saved).shape[:2] == (400, 480)  # twice the frame's pixels: 200 dots per inch
    assert here.save_figure(tmp_path / "two.pdf").read_bytes().startswith(b"%PDF")
    assert here.save_figure(tmp_path / "two.jpg").read_bytes().startswith(b"\xff\xd8")
    vector = here.save_figure(tmp_path / "three")
    assert vector == tmp_path / "three.svg"
    robot = "#009e73"
    assert 2 <= vector.read_text().lower().count(robot) <= 8  # two robots, drawn once each
    with pytest.raises(ValueError, match="must end in"):
        here.save_figure(tmp_path / "four.doc")


@pytest.mark.parametrize("name", [" ", "", "..", ".png", " .svg"])
def test_a_file_needs_a_name(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=r"a file needs a name before its suffix|is a folder: name a file"):
        world(world=SMALL).save_figure(name)
    with pytest.raises(ValueError, match=f"'{tmp_path}' is a folder: name a file, such as '{tmp_path}/"):
        world(world=SMALL).save_figure(tmp_path / ".")
    assert not list(tmp_path.iterdir())


def test_a_saved_figure_is_what_a_frame_shows(tmp_path: Path) -> None:
    here = world(world={"plot": {**SMALL["plot"], "saved_figure": {"bbox_inches": "standard"}}})
    for _ in range(3):
        here.step()
    shown = here.render()
    figure = iio.imread(here.save_figure(tmp_path / "one.png"))[..., :3]
    assert figure.shape == shown.shape
    assert np.abs(figure.astype(int) - shown).mean() < 1.5  # matplotlib draws edges and letters a little differently
    assert np.array_equal(here.render(), shown)


def test_a_tight_figure_has_no_empty_margins(tmp_path: Path) -> None:
    here = world(world={"plot": {"figure_pixels": [400, 200]}})  # a square world in a wide picture
    height, width = iio.imread(here.save_figure(tmp_path / "one.png")).shape[:2]
    assert width < 300
    assert height <= 204
    assert iio.imread(here.save_figure(tmp_path / "one.png"))[height // 2, width // 2, :3].min() > 200


def test_films_have_a_frame_for_each_sample(tmp_path: Path) -> None:
    here = world(world={**SMALL, "sample_time": 0.3}, record=True)
    samples = [here.sampling]
    for _ in range(7):
        here.step()
        samples.append(here.sampling)
    assert samples == [True, False, False, True, False, False, True, False]
    film = here.save_animation(tmp_path / "film.gif")
    assert len(iio.imread(film)) == 3
    with pytest.raises(ValueError, match="record=True"):
        here.save_animation(tmp_path / "film.gif")
    here.reset()
    here.step()
    assert here.save_animation(tmp_path / "one").suffix == ".mp4"
    with pytest.raises(ValueError, match="must end in"):
        here.save_animation(tmp_path / "film.avi")
