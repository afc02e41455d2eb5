"""What frames are drawn with beside Agg is drawn as Agg draws it: areas, lines, texts; and files show the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hand_made import World, standard_world
from PIL import Image

from irsim_gym.arraytypes import Bytes
from irsim_gym.render import stage
from irsim_gym.render.brush import Brush
from irsim_gym.scenario.plot_spec import ObjectPlot, SavedFigure, WorldPlot

SHOWN = ObjectPlot(show_goal=True, show_trajectory=True, show_text=True, show_goal_text=True, show_trail=True)


def driven(**saved: object) -> World:
    """Return a world in which the robot has come some way, and leaves outlines behind."""
    world = standard_world()
    world.scenario.world.plot = WorldPlot(saved_figure=SavedFigure(**saved))
    for body in world.scenario.bodies:
        body.plot = SHOWN
    return world


def last_of(world: World, renderer: object) -> Bytes:
    frame = np.zeros(0, np.uint8)
    for k in range(30):
        world.move(0, 2.0 + 0.1 * k, 3.0 + 0.05 * k, 0.03 * k)
        world.step()
        frame = renderer.frame(status="running")  # type: ignore[attr-defined]
    return frame


def read(file: Path) -> Bytes:
    with Image.open(file) as picture:
        return np.asarray(picture.convert("RGBA"))


def test_kernels_and_strips_draw_what_matplotlib_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = last_of(world := driven(), world.renderer()).astype(int)
    begin = Brush.__init__

    def plain(self: Brush, *arguments: object, **_: object) -> None:
        begin(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Brush, "__init__", plain)
    theirs = last_of(world := driven(), world.renderer()).astype(int)
    assert not np.array_equal(ours, theirs)
    apart = np.abs(ours - theirs).max(axis=2)
    assert apart.mean() < 0.5
    assert (apart > 64).mean() < 0.002


def test_a_frame_does_not_depend_on_what_is_kept() -> None:
    world = driven()
    frame = last_of(world, renderer := world.renderer())
    renderer.close()
    assert np.array_equal(renderer.frame(status="running"), frame)


def test_a_picture_without_background_shows_the_same_on_paper(tmp_path: Path) -> None:
    world = driven(transparent=True, bbox_inches="standard")
    frame = last_of(world, renderer := world.renderer()).astype(float)
    renderer.save(tmp_path / "clear.png", status="running")
    clear = read(tmp_path / "clear.png").astype(float)
    assert (clear[..., 3] == 0).mean() > 0.4
    share = clear[..., 3:] / 255.0
    inside = np.s_[100:500, 100:500]
    assert np.abs(share * clear[..., :3] + (1.0 - share) * 255.0 - frame)[inside].mean() < 1.0


def test_a_picture_without_margins_keeps_its_heading(tmp_path: Path) -> None:
    world = driven(bbox_inches="tight")
    frame = last_of(world, renderer := world.renderer()).astype(int)
    renderer.save(tmp_path / "cut.png", status="running")
    cut = read(tmp_path / "cut.png")[..., :3].astype(int)
    heading, paper = frame[:40], frame[2, 2]
    ink = (np.abs(heading - paper).max(axis=2) > 60).sum()
    assert (np.abs(cut[:40] - paper).max(axis=2) > 60).sum() == pytest.approx(ink, rel=0.1)


def test_opacity_is_left_out() -> None:
    rgba = np.random.default_rng(0).integers(0, 256, (7, 5, 4), np.uint8)
    assert np.array_equal(stage._without_alpha(rgba), rgba[..., :3])
