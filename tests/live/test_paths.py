"""Paths and trails hold every step, however seldom a picture is made and whoever comes or goes."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import numpy as np

import irsim_gym
from irsim_gym.live.world import World

SHOWN = {"show_trajectory": True, "show_trail": True, "trail_freq": 5}
TURNING = {
    "world": {"plot": {"figure_pixels": [240, 200], "saved_figure": {"bbox_inches": "standard"}}},
    "robot": {"kinematics": {"name": "diff"}, "state": [5, 2, 0], "goal": [9, 9], "velocity": [0, 0], "plot": SHOWN},
}


def turn(world: World, steps: int) -> None:
    for _ in range(steps):
        world.step([1.0, 0.4])


def test_a_picture_does_not_depend_on_those_before(tmp_path: Path) -> None:
    seldom, often = irsim_gym.load(TURNING), irsim_gym.load(TURNING)
    for world, every in ((seldom, 60), (often, 1)):
        for step in range(60):
            turn(world, 1)
            if step % every == every - 1:
                world.render()
    assert np.array_equal(seldom.render(), often.render())
    bare = irsim_gym.load({**TURNING, "robot": {**TURNING["robot"], "plot": {}}})
    turn(bare, 60)
    assert not np.array_equal(seldom.render(), bare.render())
    saved = irsim_gym.load(TURNING)
    turn(saved, 60)
    figures = [iio.imread(world.save_figure(tmp_path / f"{k}.png")) for k, world in enumerate((saved, often, bare))]
    assert np.array_equal(figures[0], figures[1])
    assert not np.array_equal(figures[0], figures[2])


def test_paths_stay_when_bodies_come_and_go() -> None:
    """The robot's path is whole; that of a robot that came later begins where it did."""
    world = irsim_gym.load(TURNING)
    turn(world, 10)
    world.render()
    late = world.add("robot", kinematics={"name": "diff"}, state=[1, 8, 0], goal=[9, 8], plot=SHOWN)
    turn(world, 10)
    stone = world.add(state=[8, 8, 0], shape={"name": "circle", "radius": 0.3})
    turn(world, 10)
    world.remove(stone.name)
    trails = world._camera._ready().trails
    assert np.array_equal(trails.poses(0, 0), world.track.poses_of("robot_0"))
    assert len(trails.poses(0, 0)) == 31
    later = trails.poses(0, 1)
    assert np.array_equal(later, world.track.poses_of(late.name))
    assert later[0].tolist() == [1.0, 8.0, 0.0]
    assert len(later) == 21
    world.reset()
    assert len(world._camera._ready().trails.poses(0, 0)) == 1
