"""Drawing again and again takes no more memory, and a renderer that is gone leaves nothing behind."""

from __future__ import annotations

import gc
import tracemalloc
import weakref

import pytest
from hand_made import Body, World, box, disc, make_world

from irsim_gym.rendering import Renderer
from irsim_gym.scenario.specs.plot_spec import ObjectPlot

EVERYTHING = ObjectPlot(
    show_goal=True,
    show_text=True,
    show_goal_text=True,
    show_trajectory=True,
    keep_traj_length=20,
    show_trail=True,
    trail_freq=3,
    keep_trail_length=4,
    show_fov=True,
)


def moving_world() -> World:
    robot = Body(
        disc(0.4), (1.0, 1.0, 0.0), robot=True, movable=True, goal=(8.0, 8.0), plot=EVERYTHING, fov=1.0, fov_radius=2.0
    )
    return make_world([robot, Body(box(1.0, 0.5), (5.0, 5.0, 0.0), movable=True, plot=EVERYTHING), Body(disc(0.5))])


def draw(world: World, renderer: Renderer, begin: int, end: int) -> None:
    """Draw frames of bodies that go through the world again and again; every 500 steps an episode ends."""
    for k in range(begin, end):
        world.move(0, 1.0 + (0.0317 * k) % 8.0, 1.0 + (0.0231 * k) % 8.0, 0.01 * k)
        world.move(1, 9.0 - (0.0219 * k) % 8.0, 5.0, 0.02 * k)
        world.state.step[:] = k % 500
        world.state.time[:] = 0.1 * (k % 500)
        renderer.frame(status="running" if k % 50 else "collision")


def growth(n_warm: int, n_frames: int) -> int:
    """Return by how many bytes memory grows over some frames, after others."""
    world = moving_world()
    renderer = world.renderer(size=(120, 120))
    draw(world, renderer, 0, n_warm)
    gc.collect()
    tracemalloc.start()
    try:
        before = tracemalloc.take_snapshot()
        draw(world, renderer, n_warm, n_warm + n_frames)
        gc.collect()
        after = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
    return sum(change.size_diff for change in after.compare_to(before, "filename"))


def test_some_frames_take_no_more_memory() -> None:
    """Strips of texts are kept up to a number; a frame of 120 x 120 pixels alone has 43,200 bytes."""
    assert growth(400, 100) < 200_000


@pytest.mark.slow
def test_many_frames_take_no_more_memory() -> None:
    assert growth(4_000, 10_000) < 1_000_000


def test_renderers_leave_nothing_behind() -> None:
    world = moving_world()
    world.renderer(size=(60, 60)).frame()
    gone = []
    gc.collect()
    before = len(gc.get_objects())
    for k in range(100):
        renderer = world.renderer(size=(60, 60))
        renderer.frame()
        gone += [weakref.ref(renderer._painter), weakref.ref(renderer)]
        if k % 2:
            renderer.close()
    del renderer
    gc.collect()
    assert [ref for ref in gone if ref() is not None] == []
    assert len(gc.get_objects()) - before < 1000
