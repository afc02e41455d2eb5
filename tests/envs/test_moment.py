"""What can be read of the present moment: the names and values of a world by hand, and nothing can be written."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.bodies.behaviors.python.views import BodyView
from irsim_gym.envs.described.moment import BodyMoment, WorldMoment
from irsim_gym.errors import UnknownNameError
from irsim_gym.live.population.body import Body

ROBOT: dict[str, Any] = {
    "kinematics": {"name": "acker", "wheelbase": 0.4},
    "shape": {"name": "rectangle", "length": 0.8, "width": 0.4},
    "state": [2, 2, 0.3],
    "goal": [8, 8, 1.0],
    "vel_max": [1, 0.5],
    "sensors": [{"name": "lidar2d", "number": 21, "angle_range": 3, "range_max": 6}],
}
WORLD: dict[str, Any] = {"robot": ROBOT, "obstacle": {"shape": {"name": "circle", "radius": 0.5}, "state": [4, 2.6]}}


def names(cls: type[Any]) -> set[str]:
    """Return the public names of a class."""
    return {name for name in dir(cls) if not name.startswith("_")}


def test_there_is_one_vocabulary() -> None:
    """Names and values are those of a world by hand, and behaviours have the names too."""
    assert names(BodyMoment) <= names(Body)
    assert names(BodyMoment) <= names(BodyView) | {"spec", "id", "name"}
    world = irsim_gym.load(WORLD, seed=0)
    assert names(WorldMoment) - {"bodies"} <= set(dir(world))
    for _ in range(20):
        world.step([1.0, 0.0])
    for body in world.objects:
        here = BodyMoment(world.simulation, body.id)
        for name in names(BodyMoment) - {"scan", "scan_points", "sensors", "hit", "done", "detected"}:
            theirs, ours = getattr(body, name), getattr(here, name)
            np.testing.assert_equal(np.asarray(ours), np.asarray(theirs), err_msg=name) if name != "spec" else None
    assert [sensor.options for sensor in world.robot.sensors] == list(BodyMoment(world.simulation, 0).sensors)
    assert world.robot.hit is not None
    assert BodyMoment(world.simulation, 0).hit == BodyMoment(world.simulation, 1)
    np.testing.assert_array_equal(BodyMoment(world.simulation, 0).scan()["ranges"], world.robot.scan()["ranges"])


def test_environments_show_it_and_it_cannot_be_written() -> None:
    env: Any = irsim_gym.make(WORLD).unwrapped
    env.reset(seed=0)
    before = env.robot.pose
    env.step(np.array([1.0, 0.0]))
    assert before.tolist() == [2.0, 2.0, 0.3]  # a copy
    assert env.time == pytest.approx(0.1)
    assert env.robot.pose[:2] == pytest.approx([2 + 0.1 * np.cos(0.3), 2 + 0.1 * np.sin(0.3)])
    assert [body.name for body in env.bodies] == env.bodies.names == ["robot_0", "obstacle_1"]
    assert env.bodies["obstacle_1"].radius == pytest.approx(0.5)
    assert env.bodies[1:][0] == env.bodies[-1]
    with pytest.raises(UnknownNameError, match="did you mean 'obstacle_1'"):
        env.bodies["obstacle1"]
    count = len(env.bodies)
    assert env.bodies[-count].name == env.bodies[0].name
    for wrong in (count, -count - 1):
        with pytest.raises(IndexError, match=f"body {wrong}: there are {count}"):
            env.bodies[wrong]
    for array in (before, env.robot.goal, env.robot.velocity, env.robot.twist, env.robot.scan()["ranges"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(AttributeError):
        env.robot.pose = before
    with pytest.raises(AttributeError):
        env.time = 3.0


def test_teams_batches_and_slots_show_it_too() -> None:
    from irsim_gym import sb3

    team = irsim_gym.parallel_env({"robot": [ROBOT, {**ROBOT, "state": [8, 2, 0]}]})
    team.reset(seed=0)
    assert team.robots["robot_1"].pose.tolist() == [8.0, 2.0, 0.0]
    venv: Any = irsim_gym.make_vec("cluttered_room", num_envs=3)
    slots = sb3.make_vec_env("cluttered_room", 3, seed=7)
    venv.reset(seed=7)
    slots.reset()
    assert venv.time.shape == (3,)
    for w in range(3):
        env: Any = irsim_gym.make("cluttered_room").unwrapped
        env.reset(seed=7 + w)
        for other in (venv.moment(w).robot, slots.get_attr("robot", [w])[0]):
            np.testing.assert_array_equal(other.pose, env.robot.pose)
            np.testing.assert_array_equal(other.scan()["ranges"], env.robot.scan()["ranges"])
    with pytest.raises(IndexError, match="there are 3"):
        venv.moment(3)
