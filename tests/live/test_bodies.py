"""What bodies tell, and what can be set on them."""

from __future__ import annotations

import numpy as np
import pytest
from small_world import DIFF, SCENARIO, world

from irsim_gym.errors import UnknownNameError


def test_who_is_there() -> None:
    here = world()
    assert here.names == ["robot_0", "robot_1", "obstacle_2", "obstacle_3"]
    assert [body.id for body in here] == [0, 1, 2, 3]
    assert len(here) == 4
    assert here.robot == here[0] == here["robot_0"] == here.robots[0] == here.robot_list[0]
    assert len({here.robot, here[0]}) == 1
    assert [body.name for body in here.obstacles] == ["obstacle_2", "obstacle_3"]
    assert here.obstacle_list == here.objects[2:]
    assert here.get_object_by_id(3) == here.get_object_by_name("obstacle_3")
    assert here.get_group_by_name("robot_1") == [here[1]]
    assert (here[2].role, here[2].static, here[2].group, here[2].group_name) == ("obstacle", True, 2, "obstacle_2")
    assert repr(here.robot) == "Body('robot_0')"
    assert here.robot.spec.goal_threshold == 0.1
    with pytest.raises(UnknownNameError, match="did you mean 'robot_"):
        here["robot_"]
    with pytest.raises(UnknownNameError, match="no body number 4"):
        here[4]


def test_absent_bodies_are_not_there() -> None:
    here = world(obstacle={**DIFF, "number_range": [0, 1], "distribution": {"name": "random"}})
    counts = set()
    for _ in range(12):
        counts.add(len(here.obstacles))
        here.reset(random=True)
    assert counts == {0, 1}


def test_what_a_body_tells() -> None:
    here = world()
    wall, robot = here[2], here.robot
    assert (wall.length, wall.width) == pytest.approx((1.0, 0.5))
    assert wall.radius == pytest.approx(np.hypot(0.5, 0.25))
    assert sorted(map(tuple, wall.vertices.tolist())) == [(4.5, 4.75), (4.5, 5.25), (5.5, 4.75), (5.5, 5.25)]
    assert (robot.length, robot.width, robot.radius) == pytest.approx((0.4, 0.4, 0.2))
    assert robot.vertices.shape == (0, 2)
    assert robot.lidar_offset == (0.1, 0.0, 0.0)
    assert wall.lidar_offset is None
    assert (robot.arrived, robot.collided, robot.stopped, robot.hit) == (False, False, False, None)
    here.step([0.5, 0.4])
    assert robot.velocity.tolist() == [0.5, 0.4]
    assert robot.twist.tolist() == pytest.approx([0.5 * np.cos(0.04), 0.5 * np.sin(0.04), 0.4])
    held = robot.state
    here.step([0.5, 0.4])
    assert not np.array_equal(held, robot.state)  # what was read is a copy


def test_scans_have_ir_sims_keys() -> None:
    here = world(robot={**SCENARIO["robot"][0], "state": [3, 5, 0], "behavior": None})
    scan = here.robot.scan()
    assert (scan["angle_min"], scan["angle_max"]) == pytest.approx((-np.pi / 2, np.pi / 2))
    assert (scan["range_min"], scan["range_max"], len(scan["ranges"])) == (0.0, 6.0, 5)
    assert scan["ranges"][2] == pytest.approx(4.5 - 3.1, abs=1e-6)
    points = here.robot.scan_points()
    assert points is not None
    assert points[:, 0].tolist() == pytest.approx([1.4, 0.0], abs=1e-6)
    with pytest.raises(UnknownNameError, match="no range sensor"):
        here[1].scan()


def test_who_is_seen() -> None:
    looker = {**DIFF, "state": [1, 5, 0], "fov": 1.0, "fov_radius": 5.0}
    here = world(robot=[looker, {**DIFF, "state": [1, 8, 0]}])
    assert [body.name for body in here.robot.detected()] == ["obstacle_2"]  # 4 m ahead; the others lie to the left
    with pytest.raises(UnknownNameError, match="no field of view"):
        here[1].detected()


def test_steering_belongs_to_the_state() -> None:
    car = {"kinematics": {"name": "acker"}, "shape": {"name": "rectangle", "length": 1, "width": 0.5, "wheelbase": 0.8}}
    here = world(robot={**car, "state": [1, 1, 0, 0.3]})
    assert here.robot.state.tolist() == [1, 1, 0, 0.3]
    here.robot.set_state([2, 2, 1, 0.1])
    assert here.robot.state.tolist() == [2, 2, 1, 0.1]
    assert here.robot.info.wheelbase == 0.8


def test_half_planes() -> None:
    here = world(
        obstacle=[
            {"shape": {"name": "rectangle", "length": 2, "width": 1}, "state": [5, 5, 1]},
            {"shape": {"name": "polygon", "vertices": [[0, 0], [0, 2], [1, 1], [2, 2], [2, 0]]}, "state": [8, 8, 0]},
        ]
    )
    box, dent = here.get_obstacle_info_list()
    assert box.G is not None
    assert box.h is not None
    inside, outside = np.array([0.9, 0.4]), np.array([0.9, 0.6])  # in the frame of the box
    assert (box.G @ inside <= box.h).all()
    assert not (box.G @ outside <= box.h).all()
    assert (box.cone_type, box.convex_flag) == ("Rpositive", True)
    assert box.center.tolist() == [5, 5]
    assert (box.vertex.shape, box.velocity.tolist()) == ((4, 2), [0, 0])
    assert (dent.G, dent.h, dent.cone_type, dent.convex_flag) == (None, None, None, False)
    disc = here.robot.info
    assert disc.G is not None
    assert disc.h is not None
    assert disc.G.tolist() == [[1, 0], [0, 1], [0, 0]]
    assert disc.h.tolist() == [0, 0, -0.2]


def test_ir_sims_names() -> None:
    here = world()
    assert here.get_robot_state().tolist() == [1, 1, 0]
    assert here.get_lidar_scan()["range_max"] == 6.0
    assert here.get_lidar_offset() == (0.1, 0.0, 0.0)
    info = here.get_robot_info(1)
    assert (info.id, info.name, info.kinematics, info.shape, info.static) == (1, "robot_1", "diff", "circle", False)
    assert info.goal is not None
    assert info.goal.tolist() == [9, 5, 0]
    assert [info.name for info in here.get_robot_info_list()] == ["robot_0", "robot_1"]


def test_set_state_lasts_until_the_reset() -> None:
    here = world()
    robot = here.robot
    robot.set_state([3, 3, 1])
    assert robot.state.tolist() == [3, 3, 1]
    here.step([0.0, 0.0])
    assert robot.state.tolist() == [3, 3, 1]
    here.reset()
    assert robot.state.tolist() == [1, 1, 0]
    robot.set_state([4, 4], init=True)
    here.reset()
    assert robot.state.tolist() == [4, 4, 0]
    with pytest.raises(ValueError, match="2 to 3 finite numbers"):
        robot.set_state([1, 1, 0, 0.1])


def test_refresh_looks_again_without_a_step() -> None:
    here = world()
    here.robot.set_state([5, 4.6, 0])
    assert not here.robot.collided
    here.refresh()
    assert (here.robot.collided, here.status, here.count) == (True, "Collision", 0)


def test_set_velocity() -> None:
    here = world(robot={**DIFF, "state": [1, 1, np.pi / 2], "acce": [1, 1]})
    here.robot.set_velocity([0.5, 0.0])
    assert here.robot.twist.tolist() == pytest.approx([0, 0.5, 0], abs=1e-12)
    here.step([1.0, 0.0])
    assert here.robot.velocity.tolist() == pytest.approx([0.6, 0.0])  # 1 m/s2 for 0.1 s, from 0.5 m/s
    here.reset()
    assert here.robot.velocity.tolist() == [0, 0]
    here.robot.set_velocity([0.3, 0.1], init=True)
    here.reset()
    assert here.robot.velocity.tolist() == [0.3, 0.1]
    with pytest.raises(ValueError, match="never moves"):
        here["obstacle_1"].set_velocity([1, 0])


def test_set_goal() -> None:
    here = world()
    robot = here.robot
    assert robot.goal is not None
    assert robot.goal.tolist() == [9, 9, 0]
    robot.set_goal([[1.05, 1], [5, 1, 0.5], [1, 1], [2, 2]])
    assert robot.goals[1].tolist() == [5, 1, 0.5]
    here.step([0.0, 0.0])
    assert robot.goal.tolist() == [5, 1, 0.5]  # the first one was reached
    assert len(robot.goals) == 3
    robot.append_goal([7, 7])
    assert robot.goals[:, 0].tolist() == [5, 1, 2, 7]
    robot.set_goal(None)
    assert robot.goal is None
    here.step()
    assert robot.velocity.tolist() == [0, 0]  # dash has nowhere to go
    assert not robot.arrived
    here.reset()
    assert robot.goals.tolist() == [[9, 9, 0]]
    robot.set_goal([[3, 3, 0], [4, 4, 0]], init=True)
    here.reset()
    assert robot.goals.tolist() == [[3, 3, 0], [4, 4, 0]]
    for bad in ([1], [1, 2, 3, 4], [[1, 2], [3]], [np.inf, 0]):
        with pytest.raises(ValueError, match="a goal is"):
            robot.set_goal(bad)


def test_a_looping_body_returns_from_a_goal_that_was_set() -> None:
    loop = {**DIFF, "state": [1, 1, 0], "behavior": {"name": "dash", "loop": True}}
    here = world(robot=[{**loop, "goal": [9, 1, 0]}, {**loop, "state": [1, 3, 0], "goal": [[[2, 3], [3, 3]]]}])
    back, round_trip = here.robots
    back.set_goal([1.3, 1])
    round_trip.set_goal([1.25, 3])
    here.add(state=[9, 9, 0])
    for _ in range(4):
        here.step()
    assert back.goals[0, :2].tolist() == [1, 1]
    assert round_trip.goals[0, :2].tolist() == [1, 3]
    here.reset()
    assert back.goals[:, 0].tolist() == [9]
    assert round_trip.goals[:, 0].tolist() == [2, 3]
