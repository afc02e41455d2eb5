"""Frames: any size and view, odd states, threads, plain Python, and no matplotlib; figures show the same."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hand_made import Body, World, box, disc, make_world, wall
from pixels import of_renderer
from skimage.metrics import structural_similarity

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering import Renderer
from irsim_gym.rendering.frames.frame_painter import Share
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, SavedFigure, WorldPlot
from irsim_gym.simulator.running.shards import Shards

WHOLE = SavedFigure(bbox_inches="standard")
EVERYTHING = ObjectPlot(show_text=True, show_goal_text=True, show_trail=True, trail_freq=1, show_fov=True)


def crowd(world: WorldPlot | None = None, n_worlds: int = 1) -> World:
    """A robot with a lidar and everything that can be drawn, a car, a moving box, a fixed one and a wall."""
    robot = Body(
        disc(0.5), (3.0, 4.0, 0.6), robot=True, movable=True, goal=(8.0, 8.0), color="#009E73", plot=EVERYTHING
    )
    robot.fov, robot.fov_radius = 1.5, 2.0
    bodies = [
        robot,
        Body(box(1.2, 0.6), (7.0, 3.0, 1.0), movable=True, color="teal", plot=ObjectPlot(obj_linestyle="--")),
        Body(box(1.0, 1.0), (5.0, 7.0, 0.4), plot=ObjectPlot(obj_alpha=0.5)),
        Body(wall((1.0, 1.0), (9.0, 1.0)), plot=ObjectPlot(obj_zorder=5)),
    ]
    return make_world(bodies, plot=world, n_worlds=n_worlds)


def raster(world: World, **options: Any) -> Renderer:
    return Renderer(world.scenario, world.model, world.state, world.sensors, learners=[0], **options)


def similarity(one: Bytes, other: Bytes) -> float:
    pair = (frame.mean(axis=2) for frame in (one, other))
    return float(structural_similarity(*pair, data_range=255.0))


@pytest.mark.parametrize("size", [(16, 16), (17, 41), (90, 400), (700, 60), (333, 222)])
def test_every_size_is_drawn_as_matplotlib_draws_it(size: tuple[int, int]) -> None:
    renderer = raster(crowd(WorldPlot(saved_figure=WHOLE)), size=size)
    drawn = renderer.frame()
    assert similarity(of_renderer(renderer), drawn) > 0.9
    assert drawn.flags.c_contiguous
    assert drawn.flags.owndata or drawn.base is not None


@pytest.mark.parametrize(
    "plot",
    [
        WorldPlot(saved_figure=WHOLE, viewpoint=(2.0, 9.5)),
        WorldPlot(saved_figure=WHOLE, no_axis=True),
        WorldPlot(saved_figure=WHOLE, title="A title that is too long for a picture of this size", tight=False),
        WorldPlot(saved_figure=WHOLE, show_title=False),
    ],
    ids=["viewpoint", "no axis", "title", "no title"],
)
def test_options_of_the_world_are_those_of_matplotlib(plot: WorldPlot) -> None:
    renderer = raster(crowd(plot), size=(400, 400))
    for status in ("running", "collision", "left_world", "three of four"):
        assert similarity(of_renderer(renderer, status), renderer.frame(0, status)) > 0.96


def test_looking_closer_and_farther() -> None:
    renderer = raster(crowd(WorldPlot(saved_figure=WHOLE)))
    whole = renderer.frame()
    for limits in ((2.0, 3.0, 5.0, 6.0), (-20.0, -20.0, 30.0, 30.0), (40.0, 40.0, 41.0, 41.0), None):
        renderer.look_at(limits)
        assert similarity(of_renderer(renderer), renderer.frame()) > 0.96
    np.testing.assert_array_equal(renderer.frame(), whole)


@pytest.mark.parametrize("place", [(np.nan, 3.0), (np.inf, 3.0), (1e12, 3.0), (40.0, 3.0)])
def test_a_body_that_is_nowhere_is_not_drawn(place: tuple[float, float]) -> None:
    world, other = crowd(), crowd()
    world.move(1, *place)
    other.model.present[:, 1] = False
    np.testing.assert_array_equal(raster(world).frame(), raster(other).frame())


def test_a_robot_that_is_nowhere_does_no_harm() -> None:
    world = crowd()
    renderer = raster(world)
    renderer.frame()
    world.move(0, np.nan, np.nan)
    world.state.step += 1
    world.sensors[0].arrays["ranges"][:] = np.nan
    world.state.goal[:] = np.nan
    frame = renderer.frame(0, "collision")
    assert frame.std() > 1.0
    assert (frame[:4] == frame[0, 0]).all()


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_threads_draw_the_same_pixels(threads: int) -> None:
    world = crowd(n_worlds=7)
    for w in range(7):
        world.state.pose[w, 0, 2] = 0.3 * w
        world.state.segments[w, world.model.segment_start[2]] += 0.01 * (w % 3)
    share: Share = Shards(7, threads).run
    one_by_one, together = raster(world, size=(160, 160)), raster(world, size=(160, 160), share=share)
    worlds, statuses = [6, 0, 3, 3, 5, 1, 2], ["running", "collision", "", "success", "", "x", "running"]
    expected = np.stack([one_by_one.frame(w, status) for w, status in zip(worlds, statuses, strict=True)])
    for _ in range(2):
        np.testing.assert_array_equal(together.frames(worlds, statuses), expected)
    assert together.frames([]).shape == (0, 160, 160, 3)
    with pytest.raises(ValueError, match="as many statuses as worlds: 2, got 1"):
        together.frames([0, 1], ["running"])


def test_rendering_only_reads_and_frames_are_their_owners() -> None:
    world = crowd()
    before = {
        name: value.copy() for name, value in ((name, getattr(world.state, name)) for name in world.state.columns())
    }
    renderer = raster(world)
    first = renderer.frame()
    kept = first.copy()
    world.move(0, 6.0, 6.0)
    assert (renderer.frame() != first).any()
    world.move(0, 3.0, 4.0, 0.6)
    np.testing.assert_array_equal(first, kept)
    for name, value in before.items():
        assert getattr(world.state, name).tobytes() == value.tobytes(), name
    renderer.close()
    renderer.clear()
    np.testing.assert_array_equal(renderer.frame(), kept)


def test_a_fixed_body_that_is_moved_is_drawn_at_its_new_place() -> None:
    world = crowd()
    renderer = raster(world)
    before = renderer.frame()
    world.move(2, 8.0, 8.0)
    moved = renderer.frame()
    assert (moved != before).any()
    np.testing.assert_array_equal(moved, raster(world).frame())
    world.move(2, 5.0, 7.0, 0.4)
    np.testing.assert_array_equal(renderer.frame(), before)


def test_plain_python_draws_the_same_pixels() -> None:
    tiny = "import test_frames as t; print(t.digest())"
    folder = Path(__file__).parent
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join([str(folder), *sys.path])}
    result = subprocess.run([sys.executable, "-c", tiny], env=environment, capture_output=True, text=True, check=False)
    assert result.stdout.strip() == digest(), result.stderr


def digest() -> str:
    """Return a sum over the pixels of a small picture."""
    return hashlib.sha256(raster(crowd(), size=(48, 48)).frame(0, "collision").tobytes()).hexdigest()


def test_matplotlib_is_not_loaded() -> None:
    script = """
import sys
from irsim_gym.simulator.engine import compile
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario

simulation = compile(load_scenario("empty_goal"), 1)
simulation.reset(seed=0)
renderer = Renderer(simulation.scenario, simulation.model, simulation.state, simulation.sensors)
print(renderer.frame().shape, sorted(name for name in sys.modules if name.startswith("matplotlib")))
"""
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert result.stdout.strip() == "(600, 600, 3) []", result.stderr


def test_colours_are_matplotlibs() -> None:
    from matplotlib.colors import CSS4_COLORS, to_rgba

    others = ["b", "g", "r", "c", "m", "y", "k", "w", "C0", "C7", "tab:olive", "tab:grey", "0.25", "1", "0"]
    hexadecimal = ["#abc", "#abcd", "#A1B2C3", "#a1b2c3d4", "none", "None"]
    for name in (*CSS4_COLORS, *others, *hexadecimal):
        expected = np.array(to_rgba(name, 0.5)) * [255.0, 255.0, 255.0, 1.0]
        np.testing.assert_allclose(colour(name, 0.5), expected, atol=0.51, err_msg=name)
