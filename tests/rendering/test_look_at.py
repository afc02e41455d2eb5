"""Another part of the world can be looked at, and several worlds drawn in one call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hand_made import Body, World, box, disc, make_world, standard_world

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.errors import OptionError
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.scene.frame_layout import Limits
from irsim_gym.scenario.specs.plot_spec import SavedFigure, WorldPlot

OBSTACLE, CARD = (0x47, 0x55, 0x69), (255, 255, 255)


@pytest.fixture
def world() -> World:
    return make_world([Body(box(2.0, 2.0), (3.0, 3.0, 0.0)), Body(disc(0.5), (7.0, 7.0, 0.0))], lidar=False)


def colour_at(renderer: Renderer, frame: Bytes, x: float, y: float) -> tuple[int, ...]:
    column, row = renderer.layout.column_row(x, y)
    return tuple(int(level) for level in frame[int(row), int(column)])


@pytest.mark.parametrize("limits", [(2.0, 2.0, 6.0, 6.0), (-5.0, -5.0, 15.0, 15.0), (1.0, 3.5, 3.0, 4.5)])
def test_bodies_stand_where_the_layout_says(world: World, limits: Limits) -> None:
    renderer = world.renderer()
    renderer.frame()
    renderer.look_at(limits)
    frame = renderer.frame()
    assert colour_at(renderer, frame, 2.57, 3.9) == OBSTACLE
    assert colour_at(renderer, frame, 2.57, 4.13) == CARD
    x_min, y_min, x_max, y_max = renderer.layout.limits
    assert x_min <= limits[0] < limits[2] <= x_max
    assert y_min <= limits[1] < limits[3] <= y_max
    assert (x_max - x_min) / (limits[2] - limits[0]) == pytest.approx(1.0) or (y_max - y_min) / (
        limits[3] - limits[1]
    ) == pytest.approx(1.0)


def test_nothing_is_drawn_beside_the_drawing_area(world: World) -> None:
    renderer = world.renderer()
    renderer.look_at((2.9, 2.9, 3.1, 3.1))
    frame, layout = renderer.frame(), renderer.layout
    assert colour_at(renderer, frame, 3.0, 3.0) == OBSTACLE
    outside = np.ones(frame.shape[:2], bool)
    top = layout.height - layout.bottom - layout.plot_height
    outside[top - 1 : top + layout.plot_height + 1, layout.left - 1 : layout.left + layout.plot_width + 1] = False
    assert not (frame[outside] == OBSTACLE).all(axis=1).any()


def test_back_to_what_the_scenario_says() -> None:
    world = standard_world()
    for plot in (WorldPlot(), WorldPlot(viewpoint="robot_0")):
        world.scenario.world.plot = plot
        renderer = world.renderer()
        before, layout = renderer.frame(), renderer.layout
        renderer.look_at((4.0, 4.0, 6.0, 6.0))
        near = renderer.frame()
        assert not np.array_equal(near, before)
        renderer.close()
        assert np.array_equal(renderer.frame(), near), "a new figure looks there too"
        renderer.look_at(None)
        assert renderer.layout == layout
        assert np.array_equal(renderer.frame(), before)


def test_a_saved_picture_shows_the_same_part(world: World, tmp_path: Path) -> None:
    from PIL import Image

    world.scenario.world.plot = WorldPlot(saved_figure=SavedFigure(bbox_inches="standard"))
    renderer = world.renderer()
    renderer.look_at((2.0, 2.0, 6.0, 6.0))
    renderer.save(tmp_path / "near.png")
    with Image.open(tmp_path / "near.png") as picture:
        saved = np.asarray(picture.convert("RGB"))
    assert np.abs(saved.astype(int) - renderer.frame()).mean() < 0.5
    assert np.array_equal(renderer.frame(), renderer.frame())


@pytest.mark.parametrize("limits", [(1.0, 1.0, 1.0, 2.0), (0.0, 3.0, 1.0, 2.0), (0.0, 0.0, float("nan"), 1.0)])
def test_limits_that_bound_nothing(world: World, limits: Limits) -> None:
    renderer = world.renderer()
    with pytest.raises(OptionError, match="x_min < x_max and y_min < y_max, got"):
        renderer.look_at(limits)
    assert renderer.layout.limits == world.renderer().layout.limits


def test_several_worlds_in_one_call() -> None:
    world = make_world([Body(box(2.0, 2.0), (5.0, 5.0, 0.0))], n_worlds=3, lidar=False)
    world.model.present[1, 0] = False
    renderer = world.renderer(size=(120, 100))
    pictures = renderer.frames([2, 1], ["running", "collision"])
    assert pictures.shape == (2, 100, 120, 3)
    assert np.array_equal(pictures[0], renderer.frame(2, "running"))
    assert np.array_equal(pictures[1], renderer.frame(1, "collision"))
    assert np.array_equal(renderer.frames([0, 1])[1], renderer.frame(1))
    assert renderer.frames([]).shape == (0, 100, 120, 3)
