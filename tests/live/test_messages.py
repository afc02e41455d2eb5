"""Messages of a world, and odometry that moves bodies: names, fields and values of ``irsim.msg``."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import irsim
import irsim.msg
import numpy as np
import pytest

import irsim_gym
import irsim_gym.irsim
from irsim_gym.errors import UnknownNameError
from irsim_gym.simulator.readings import messages

FILE = """
world: {height: 10, width: 10, step_time: 0.1}
robot:
  - kinematics: {name: diff}
    shape: {name: circle, radius: 0.2}
    state: [1, 1, 0.5]
    goal: [9, 9, 0]
    sensors:
      - {name: lidar2d, range_min: 0.5, range_max: 5, angle_range: 3.14, number: 7, offset: [0.1, 0, 0.2]}
      - {name: lidar2d, range_min: 0, range_max: 3, angle_range: 6.28, number: 4}
  - kinematics: {name: acker}
    shape: {name: rectangle, length: 1.6, width: 0.8, wheelbase: 1.0}
    state: [5, 5, 1.0, 0.1]
    goal: [9, 1, 0]
  - kinematics: {name: omni_angular}
    shape: {name: circle, radius: 0.2}
    state: [3, 7, 0.7]
    goal: [3, 1, 0]
obstacle:
  - {shape: {name: circle, radius: 0.3}, state: [1.4, 1.6, 0]}
  - {shape: {name: rectangle, length: 1, width: 2}, state: [7, 3, 0.3]}
"""
ACTIONS = [[0.4, 0.3], [0.5, 0.2], [0.3, 0.1, 0.2]]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "hall.yaml").write_text(FILE)
    return tmp_path / "hall.yaml"


@pytest.fixture
def theirs(file: Path) -> Any:
    env = irsim.make(str(file), headless=True, log_level="ERROR")
    yield env
    env.end()


@pytest.fixture
def ours(file: Path) -> Any:
    return irsim_gym.irsim.make(str(file))


def step(world: Any) -> None:
    world.step([np.array(action)[:, None] for action in ACTIONS], [0, 1, 2])


def leaves(message: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    for field in dataclasses.fields(message):
        value, name = getattr(message, field.name), f"{place}.{field.name}"
        if dataclasses.is_dataclass(value):
            yield from leaves(value, name)
        elif isinstance(value, list) and value and dataclasses.is_dataclass(value[0]):
            for i, one in enumerate(value):
                yield from leaves(one, f"{name}[{i}]")
        else:
            yield name, value


@pytest.mark.parametrize("name", irsim.msg.__all__)
def test_classes_have_the_fields_of_ir_sim(name: str) -> None:
    own = getattr(irsim_gym.irsim, name)
    assert own is getattr(messages, name)
    assert own.__name__ == name
    if name != "Message":
        assert [one.name for one in dataclasses.fields(own)] == [
            one.name for one in dataclasses.fields(getattr(irsim.msg, name))
        ]


@pytest.mark.parametrize("use_inf", [False, True])
def test_a_world_reads_as_in_ir_sim(theirs: Any, ours: Any, use_inf: bool) -> None:
    """All fields, but for the goals that IR-SIM gives obstacles without one."""
    for _ in range(3):
        step(theirs)
        step(ours)
    expected, found = (dict(leaves(world.get_msg(use_inf=use_inf))) for world in (theirs, ours))
    assert found.keys() == expected.keys()
    assert len(found) > 200
    for name, value in expected.items():
        if isinstance(value, np.ndarray) and not (name.endswith("goal") and found[name] is None):
            assert (found[name].dtype, found[name].shape) == (value.dtype, value.shape), name
            np.testing.assert_allclose(found[name], value, atol=1e-5, err_msg=name)
        elif isinstance(value, float):
            assert found[name] == pytest.approx(value, abs=1e-9), name
        elif not name.endswith("goal"):
            assert (type(found[name]), found[name]) == (type(value), value), name


def test_a_message_is_plain_data_for_json(theirs: Any, ours: Any) -> None:
    """The same keys and numbers as IR-SIM's, but for the goals that IR-SIM gives obstacles without one."""
    step(theirs)
    step(ours)
    expected, found = (json.loads(json.dumps(world.get_msg().to_dict())) for world in (theirs, ours))
    for body in (*expected["objects"][3:], *found["objects"][3:]):
        del body["goal"]
    assert found.keys() == expected.keys()
    assert [body.keys() for body in found["objects"]] == [body.keys() for body in expected["objects"]]
    for own, body in zip(found["objects"], expected["objects"], strict=True):
        for name in ("odom", "scan", "goal"):
            numbers = [re.findall(r"-?\d+\.\d+(?:e-?\d+)?", json.dumps(one.get(name))) for one in (own, body)]
            np.testing.assert_allclose(*np.array(numbers, np.float64), rtol=0, atol=1e-5)


def test_ranges_without_a_return_are_infinite() -> None:
    """A wall 0.3 m to the left, nearer than range_min, one 2 m ahead, nothing to the right."""
    walls = [[[0, 0.3], [3, 0.3]], [[2, -1], [2, 0.3]]]
    scanner = {"name": "lidar2d", "number": 3, "angle_range": np.pi, "range_min": 0.5, "range_max": 4}
    robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.1}, "state": [0.5, 0, 0]}
    lines = [{"shape": {"name": "linestring", "vertices": wall}} for wall in walls]
    data = {"world": {"offset": [-5, -5]}, "robot": {**robot, "sensors": [scanner]}, "obstacle": lines}
    world = irsim_gym.load(data)
    assert world.get_msg(use_inf=True).robots[0].scan.ranges.tolist() == [np.inf, 1.5, -np.inf]
    assert world.get_msg().robots[0].scan.ranges.tolist() == [4.0, 1.5, 0.5]


def test_a_message_stays_as_it_is(ours: Any) -> None:
    before = ours.get_msg()
    names = [one.name for one in (*before.robots, *before.obstacles)]
    ranges, x = before.robots[0].scan.ranges.copy(), before.robots[0].odom.pose.pose.position.x
    for _ in range(5):
        step(ours)
    assert names == [body.name for body in ours]
    np.testing.assert_array_equal(before.robots[0].scan.ranges, ranges)
    assert before.robots[0].odom.pose.pose.position.x == x == 1.0
    assert ours.get_msg().robots[0].odom.pose.pose.position.x != x


def test_a_world_takes_the_messages_of_ir_sim(theirs: Any, ours: Any) -> None:
    """After the same messages, states and velocities are those of IR-SIM, and so are the next steps."""
    for _ in range(4):
        step(theirs)
    message = theirs.get_msg()
    message.objects[3].odom.pose.pose.position.x = 8.0
    assert theirs.receive_msg(message) == ours.receive_msg(message) == 5
    for _ in range(2):
        for one, other in zip(theirs.objects, ours.objects, strict=True):
            np.testing.assert_allclose(other.state, one.state, atol=1e-9, err_msg=one.name)
            np.testing.assert_allclose(
                np.ravel(other.velocity), np.ravel(one.velocity)[: other.velocity.size], atol=1e-9
            )
        step(theirs)
        step(ours)
    assert theirs.receive_msg(ours.get_msg().robots[2].odom, object_name="robot_2") == 1
    np.testing.assert_allclose(theirs.objects[2].state, ours.objects[2].state, atol=1e-9)


def test_a_car_that_stands_keeps_its_steering_angle(ours: Any) -> None:
    car = ours.get_msg().objects[1]
    assert ours.receive_msg(car) == 1
    assert ours["robot_1"].steering == 0.1
    car.odom.twist.twist.linear.x, car.odom.twist.twist.angular.z = 0.5, 0.25
    ours.receive_msg(car)
    assert ours["robot_1"].steering == pytest.approx(np.arctan(0.5))
    np.testing.assert_allclose(np.ravel(ours["robot_1"].velocity), [0.5, np.arctan(0.5)])


def odometry(x: float, y: float, yaw: float, **twist: float) -> Any:
    """Return an odometry of another kind of classes, as those of ROS are."""
    turn = SimpleNamespace(x=0.0, y=0.0, z=np.sin(0.5 * yaw), w=np.cos(0.5 * yaw))
    pose = SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=x, y=y, z=0.0), orientation=turn))
    linear = SimpleNamespace(x=twist.get("vx", 0.0), y=twist.get("vy", 0.0), z=0.0)
    angular = SimpleNamespace(x=0.0, y=0.0, z=twist.get("w", 0.0))
    return SimpleNamespace(pose=pose, twist=SimpleNamespace(twist=SimpleNamespace(linear=linear, angular=angular)))


def test_an_odometry_moves_the_first_robot_or_the_one_that_is_named(file: Path) -> None:
    world = irsim_gym.load(file)
    assert world.receive_msg(odometry(2.0, 3.0, 0.5, vx=0.6, w=0.2)) == 1
    np.testing.assert_allclose(world.robot.state, [2.0, 3.0, 0.5])
    np.testing.assert_allclose(world.robot.velocity, [0.6, 0.2])
    world.receive_msg(odometry(4.0, 8.0, -0.5, vx=0.1, vy=0.2, w=0.3), object_name="robot_2")
    np.testing.assert_allclose(world["robot_2"].state, [4.0, 8.0, -0.5])
    np.testing.assert_allclose(world["robot_2"].velocity, [0.1, 0.2, 0.3])
    world.receive_msg(odometry(9.0, 9.0, 0.0), object_id=4)
    np.testing.assert_allclose(world["obstacle_4"].state, [9.0, 9.0, 0.0])


@pytest.mark.parametrize(("frame", "expected"), [("body", [0.4, 0.0]), ("world", [0.0, 0.4])])
def test_an_omnidirectional_robot_takes_a_twist_of_its_body(frame: str, expected: list[float]) -> None:
    """It looks to the left of the world's x axis: ahead is y there."""
    robot = {"kinematics": {"name": "omni", "frame": frame}, "state": [1, 1, 0], "shape": {"name": "circle"}}
    world = irsim_gym.load({"world": {}, "robot": robot})
    world.receive_msg(odometry(2.0, 2.0, 0.5 * np.pi, vx=0.4))
    np.testing.assert_allclose(world.robot.velocity, expected, atol=1e-12)
    np.testing.assert_allclose(world.robot.twist, [0.0, 0.4, 0.0], atol=1e-12)
    found = world.get_msg().robots[0].odom.twist.twist
    np.testing.assert_allclose([found.linear.x, found.linear.y], [0.4, 0.0], atol=1e-12)


def test_flags_and_scans_follow_unless_refresh_is_false(file: Path) -> None:
    world = irsim_gym.load(file)
    world.receive_msg(odometry(1.4, 1.3, 0.0), refresh=False)
    assert not world.robot.collided
    world.receive_msg(odometry(1.4, 1.3, 0.0))
    assert world.robot.collided
    assert world.status == "Collision"
    assert world.get_msg().robots[0].collision_ids == [3]


def test_the_obstacle_map_stays_where_it_is() -> None:
    world = irsim_gym.load({"world": {"obstacle_map": [[False, True]]}, "robot": {"state": [1, 1, 0]}})
    message = world.get_msg()
    assert [one.shape for one in message.obstacles] == ["map"]
    assert world.receive_msg(message) == 1


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda world: 3, TypeError, "a message is a WorldState, an ObjectState or an Odometry, got int"),
        (lambda world: odometry(np.nan, 1.0, 0.0), ValueError, "the odometry of 'robot_0' must have finite numbers"),
        (lambda world: messages.Odometry(pose=zero_turn()), ValueError, "must have finite numbers and an orientation"),
        (lambda world: twice(world.get_msg()), ValueError, "the message has two states of 'robot_0'"),
        (lambda world: renamed(world.get_msg()), UnknownNameError, "no body number 77 in 'hall'"),
    ],
)
def test_nothing_moves_where_a_message_cannot_be_used(file: Path, change: Any, error: Any, words: str) -> None:
    world = irsim_gym.load(file)
    before = [body.state.copy() for body in world]
    with pytest.raises(error, match=words):
        world.receive_msg(change(world))
    assert all(np.array_equal(body.state, state) for body, state in zip(world, before, strict=True))


def zero_turn() -> Any:
    return messages.PoseWithCovariance(messages.Pose(orientation=messages.Quaternion(w=0.0)))


def twice(message: Any) -> Any:
    message.objects[0].odom.pose.pose.position.x = 7.0
    message.objects.append(message.objects[0])
    return message


def renamed(message: Any) -> Any:
    message.objects[0].odom.pose.pose.position.x = 7.0
    message.objects[-1].name, message.objects[-1].id = "nobody", 77
    return message
