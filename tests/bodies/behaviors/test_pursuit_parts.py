"""Commands, predicted stops and courses of pursuit, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_pursuit import DISC, SEEN, begun, options, wall

from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.pursuit.commands import ackermann_command, braking_command, command_to
from irsim_gym.bodies.behaviors.pursuit.follow import BACK_STEPS, Course, bearing_to, careful_command, follow
from irsim_gym.bodies.behaviors.pursuit.motion import Moving, can_stop, moving_of
from irsim_gym.bodies.behaviors.pursuit.pursuit import Pursuit
from irsim_gym.bodies.behaviors.pursuit.seen import way_is_blocked
from irsim_gym.bodies.behaviors.pursuit.tables import PATIENCE, find_way, place_beside
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.points import PointMap, add_point
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD

QUARTER = 0.5 * np.pi
NO_LIMIT = (np.inf, np.inf, np.inf)


def moving(drive: int, pose: tuple[float, float, float] = (0, 0, 0), **more: Any) -> Moving:
    """Return a body at rest of at most 1 m/s and 1 rad/s, with steps of 1 s and a wheelbase of 1 m."""
    given = {"velocity": (0, 0, 0), "low": (-1, -1, -1), "high": (1, 1, 1), "change": NO_LIMIT, **more}
    arrays = {name: np.array(given.pop(name), np.float64) for name in ("velocity", "low", "high", "change")}
    usual = {"by_rate": False, "wheelbase": 1.0, "step": 1.0, "steering": 0.0, **given}
    return Moving(drive=drive, pose=np.array(pose, np.float64), **usual, **arrays)


def plain(**given: Any) -> Any:
    """Return options with which nothing but the share of the speed regulates it."""
    return options(**{"speed": 9.0, "min_radius": 0.0, "proximity": 0.0, "approach": 0.0, **given})


def among(*walls: list[list[float]]) -> Obstacles:
    """Return walls as obstacles; body 0 is the robot."""
    simulation = begun({"kinematics": {"name": "omni"}, "state": [9, 9, 0], "goal": [9, 8]}, [wall(*w) for w in walls])
    blocks = np.ones(len(walls) + 1, np.bool_)
    blocks[0] = False
    return Obstacles(simulation.model, simulation.state, 0, blocks, simulation.model.cells, None)


def test_an_omnidirectional_body_goes_straight_to_a_point_in_the_frame_of_its_command() -> None:
    """It faces up, and so does the way: along y in the world, along x in its own frame. The limit of y is half."""
    ahead, limits = (1.0, 9.0), {"high": (1, 0.5, 1)}
    place = (1.0, 1.0, QUARTER)
    for drive, expected in ((OMNI_WORLD, [0, 0.5, 0]), (OMNI_BODY, [1, 0, 0]), (OMNI_ANGULAR, [1, 0, 0])):
        assert command_to(plain(), moving(drive, place, **limits), ahead, 9.0, 9.0, 1.0) == pytest.approx(expected)
    # To the left, at 0.4 m: no farther than that in a step of 1 s; and it turns there by a quarter in more than one.
    aside = (0.6, 1.0)
    for drive, expected in ((OMNI_WORLD, [-0.4, 0, 0]), (OMNI_BODY, [0, 0.4, 0]), (OMNI_ANGULAR, [0, 0.4, 1])):
        assert command_to(plain(), moving(drive, place, **limits), aside, 9.0, 9.0, 1.0) == pytest.approx(expected)


def test_a_body_that_turns_towards_a_point_goes_by_where_it_will_face() -> None:
    """At 1 rad/s and 1 rad/s2 it turns through another 0.5 rad: of 0.6 rad to the left that leaves 0.1, or 1.1."""
    target = (5.0 * np.cos(0.6), 5.0 * np.sin(0.6))
    for rate, on_the_spot in ((1.0, False), (-1.0, True)):
        body = moving(DIFFERENTIAL, velocity=(0, rate, 0), change=(np.inf, 1, 1))
        speed, turn, _ = command_to(plain(), body, target, 9.0, 9.0, 1.0)
        assert (speed == 0.0) == on_the_spot
        if not on_the_spot:
            assert speed == pytest.approx(1.0)
            assert turn == pytest.approx(2.0 * np.sin(0.1) / 5.0)


def test_a_curve_to_a_side_to_which_a_body_cannot_turn_is_not_driven() -> None:
    body = moving(DIFFERENTIAL, low=(-1, -1, -1), high=(1, -0.1, 1))
    assert command_to(plain(), body, (4.0, 1.0), 9.0, 9.0, 1.0) == (0, 0, 0)
    assert command_to(plain(), body, (4.0, -1.0), 9.0, 9.0, 1.0) == pytest.approx((1, -2 / 17, 0))


@pytest.mark.parametrize(
    ("drive", "by_rate", "velocity", "command"),
    [
        (DIFFERENTIAL, False, (1.0, 0.5, 0.0), (0, 0.4, 0)),  # 0.8 m/s after a step
        (DIFFERENTIAL, False, (0.0, 0.5, 0.0), (0, 0, 0)),
        (ACKERMANN, True, (1.0, 0.5, 0.0), (0, 0.4, 0)),
        (ACKERMANN, False, (1.0, 0.5, 0.0), (0, 0.5, 0)),  # its wheels stay as they are
        (OMNI_WORLD, False, (1.0, 0.5, 0.2), (0, 0, 0)),
    ],
)
def test_braking_keeps_the_curve(drive: int, by_rate: bool, velocity: Any, command: Any) -> None:
    body = moving(drive, by_rate=by_rate, velocity=velocity, change=(0.2, 9, 9))
    assert braking_command(body) == pytest.approx(command)


@pytest.mark.parametrize(
    ("by_rate", "second", "ahead", "aside", "command"),
    [
        (True, 0.0, -2.0, 0.1, (-0.5, -0.8)),  # straight behind: it turns left only if it does so already
        (True, 0.1, -2.0, 0.1, (-0.5, 0.9)),
        (True, -0.1, -2.0, 0.1, (-0.5, -0.8)),
        (False, -0.1, -2.0, 0.1, (-0.5, -0.8)),  # wheels to the right turn it to the left
        (False, 0.1, -2.0, 0.1, (-0.5, 0.9)),
        (True, 0.1, -2.0, -3.0, (-0.5, -0.8)),  # beside it: by the side of the point
        (False, 0.1, -2.0, 3.0, (-0.5, -0.8)),
    ],
)
def test_a_car_that_drives_back(by_rate: bool, second: float, ahead: float, aside: float, command: Any) -> None:
    limits = {"low": (-1, -0.8, 0), "high": (2, 0.9, 0)}
    body = moving(ACKERMANN, by_rate=by_rate, velocity=(-0.5, second, 0), **limits)
    assert ackermann_command(plain(), body, ahead, aside, 9.0, 9.0, -0.5) == pytest.approx((*command, 0))


@kernel
def velocity_of(model: Any, state: Any) -> tuple[float, float, float]:
    velocity = moving_of(model, state, 0, 0, False).velocity
    return velocity[0], velocity[1], velocity[2]


@pytest.mark.parametrize(("drive", "expected"), [("diff", [0.1, 0.2, 0.3]), ("omni", [0.4, 0.5, 0.6])])
def test_the_velocity_is_in_the_coordinates_of_the_command(drive: str, expected: list[float]) -> None:
    simulation = begun({"kinematics": {"name": drive}, "state": [1, 1, 0], "goal": [9, 9]}, [])
    simulation.state.velocity[0, 0], simulation.state.twist[0, 0] = [0.1, 0.2, 0.3], [0.4, 0.5, 0.6]
    assert list(velocity_of(simulation.model, simulation.state)) == expected


def test_a_step_that_ends_beyond_a_wall_is_seen() -> None:
    """From 1 m below the walls at y = 0 and left of that at x = 0 it goes 2 m, to as far on their other side."""
    up, aside = among([[-3, 0], [4, 0]]), among([[0, -4], [0, 4]])
    for obstacles, place, command in ((up, (2, -1, 0), (0.0, 2.0, 0.0)), (aside, (-1, 2, 0), (2.0, 0.0, 0.0))):
        body = moving(OMNI_WORLD, place, low=(-2, -2, 0), high=(2, 2, 0))
        assert not can_stop(obstacles, 0.2, 0.8, body, command)
        assert can_stop(obstacles, 0.2, 0.8, body, (0.3 * command[0], 0.3 * command[1], 0.0))
        assert can_stop(obstacles, 0.2, 0.8, body, (-command[0], -command[1], 0.0))


def test_bearings_have_no_sign() -> None:
    body = moving(DIFFERENTIAL, (1, 2, 0.1))
    bearings = [bearing_to(body, (1 + x, 2 + y)) for x, y in ((1, 1), (1, -1), (-1, 1), (0, 3))]
    assert bearings == pytest.approx([QUARTER / 2 - 0.1, QUARTER / 2 + 0.1, 1.5 * QUARTER - 0.1, QUARTER - 0.1])


def test_who_cannot_go_on_at_full_speed_goes_slower() -> None:
    """A wall at x = 0.7 leaves 0.4 m to a disc of 0.3 m: a quarter of 1 m/s for 1 s, not half."""
    obstacles, body = among([[0.7, -3], [0.7, 3]]), moving(OMNI_WORLD)
    backs, command = careful_command(obstacles, plain(), 0.3, 0.05, body, (2.0, 0.0), 0.4, 9.0)
    assert not backs
    assert command == pytest.approx((0.25, 0, 0))
    near = among([[0.31, -3], [0.31, 3]])  # not even the twentieth part
    assert careful_command(near, plain(), 0.3, 0.0, body, (2.0, 0.0), 0.01, 9.0) == (False, (0, 0, 0))
    facing = moving(DIFFERENTIAL, (0, 0, 0.2))  # it turns there, by -0.2 rad in a step of 1 s
    backs, command = careful_command(near, plain(), 0.3, 0.0, facing, (2.0, 0.0), 0.01, 9.0)
    assert (backs, *command) == pytest.approx((False, 0, -0.2, 0))


def test_a_car_that_cannot_go_on_drives_back_at_half_of_its_speed() -> None:
    car = moving(ACKERMANN, low=(-1, -0.8, 0), high=(1, 0.8, 0))
    backs, command = careful_command(among([[0.5, -3], [0.5, 3]]), plain(), 0.3, 0.1, car, (2.0, 0.5), 0.2, 9.0)
    assert backs
    assert command == pytest.approx((-0.5, -0.8, 0))


def course(*points: tuple[float, float]) -> Course:
    return Course(np.array(points, np.float64), len(points), 0, 0.1, False)


def test_a_course_is_followed_from_where_the_body_is_on_it() -> None:
    free, far = among(), among([[0.7, -3], [0.7, 3]])
    way = course((-1, 0), (0, 0), (3, 0))
    body = moving(OMNI_WORLD, (0.0, 0.1, 0))
    good, side, back, command = follow(free, free, plain(lookahead_min=1.0), 0.3, body, way, 0)
    assert (good, side, back) == (True, 0, 0)
    assert command == pytest.approx((np.sqrt(0.99), -0.1, 0))
    # 3 m beside the way it gives up.
    astray = moving(OMNI_WORLD, (0.0, 3.1, 0), velocity=(1, 0, 0))
    assert follow(free, free, plain(), 0.3, astray, way, 7) == (False, 0, 0, (0, 0, 0))
    # What moves is in the way of the next step alone: slower, and still on the way.
    good, _, back, command = follow(free, far, plain(lookahead_min=8.0), 0.3, moving(OMNI_WORLD), way, 0)
    assert (good, back) == (True, 0)
    assert command == pytest.approx((0.25, 0, 0))


def test_a_car_counts_the_steps_for_which_it_drives_back() -> None:
    """Its way leads behind it."""
    free, way = among(), course((0, 0), (-3, 0.5))
    car = moving(ACKERMANN, low=(-1, -0.8, 0), high=(1, 0.8, 0))
    found = [follow(free, free, plain(), 0.3, car, way, back) for back in (0, 15, 3)]
    assert [(good, back) for good, _, back, _ in found] == [(True, BACK_STEPS), (True, 14), (True, 2)]
    assert [command[0] for *_, command in found] == pytest.approx([-0.5] * 3)


def tables_of(simulation: Simulation) -> Any:
    return simulation.parts.behaviors[0].tables


def test_what_a_step_keeps_of_a_way() -> None:
    """A way around a corner that is not there; it is kept until the goal changes, along either axis."""
    simulation = begun({"kinematics": {"name": "omni"}, "state": [1, 1, 0], "goal": [8, 8]}, [])
    tables, state = tables_of(simulation), simulation.state
    simulation.step()
    assert tables.points[0, 0, :2].tolist() == [[1, 1], [8, 8]]
    assert (tables.count[0, 0], tables.retry[0, 0]) == (2, PATIENCE)
    tables.points[0, 0, :3], tables.count[0, 0] = [[1, 1], [1, 8], [8, 8]], 3
    state.pose[0, 0] = [2, 8.1, 0]
    tables.side[0, 0] = 0
    tables.points[0, 0, 0] = [1, 7]
    simulation.step()
    assert (tables.side[0, 0], tables.count[0, 0]) == (1, 3)
    for goal in ([8, 3, 0], [3, 3, 0]):
        state.goal[0, 0] = goal
        simulation.step()
        assert tables.count[0, 0] == 2
        assert tables.points[0, 0, 1].tolist() == goal[:2]
        assert tables.side[0, 0] == 0


def test_a_car_remembers_that_it_drives_back() -> None:
    car = {"kinematics": {"name": "acker", "wheelbase": 0.5}, "vel_min": [-1, -0.8], "vel_max": [1, 0.8]}
    simulation = begun({**car, "state": [5, 5, 0, 0], "goal": [1, 5.5]}, [])
    kept = []
    for _ in range(3):
        simulation.step()
        kept.append(int(tables_of(simulation).back[0, 0]))
    assert kept == [BACK_STEPS, BACK_STEPS - 1, BACK_STEPS - 2]


@pytest.mark.parametrize(("drive", "axis"), [("diff", 1), ("omni_angular", 2)])
def test_a_body_that_is_there_turns_to_its_heading(drive: str, axis: int) -> None:
    limits = {"vel_max": [1] * (axis + 1), "vel_min": [-1] * (axis + 1)}
    robot = {"kinematics": {"name": drive}, "state": [5, 5, 0], "goal": [5, 5, -2], "arrive_mode": "state", **limits}
    simulation = begun(robot, [])
    simulation.step()
    assert simulation.state.pose[0, 0].tolist() == pytest.approx([5, 5, -0.1])
    assert simulation.state.velocity[0, 0].tolist() == pytest.approx([0, -1, 0] if axis == 1 else [0, 0, -1])


def test_who_found_no_way_to_its_goal() -> None:
    simulation = begun({"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [8, 8]}, [], n_worlds=4)
    tables = tables_of(simulation)
    tables.count[:, 0] = [0, 0, 2, 0]
    tables.goal[:, 0] = [[8, 8], [np.nan, 8], [8, 8], [np.nan, np.nan]]
    assert Pursuit.wayless(simulation.parts.behaviors[0])[:, 0].tolist() == [True, False, False, False]


@pytest.mark.parametrize(
    ("pose", "point", "blocked"),
    [
        ((2, 5), (4, 5.1), True),  # ahead on this side
        ((2, 5), (1.2, 5.1), False),  # behind
        ((2, 5), (2, 5.22), False),  # as near as now, and no nearer
        ((2, 5), (5.1, 7), True),  # on the next side
        ((2, 5), (5.22, 7), True),  # nearer there than 0.2 m and half of 0.1 m
        ((2, 5), (5.26, 7), False),
        ((2, 5), (5.22, 8), False),  # the goal may be so near
        ((2, 5), (5.1, 8), True),
        ((5, 7), (5.1, 6), False),  # behind on the last side
        ((5, 7), (5.1, 7.5), True),
    ],
)
def test_what_was_seen_blocks_the_rest_of_a_way(pose: Any, point: Any, blocked: bool) -> None:
    """A disc of 0.2 m goes from (1, 5) to (5, 5), and up to (5, 8), at 0.1 m from what it knew."""
    simulation = begun({"kinematics": {"name": "omni"}, "state": [1, 5, 0], "goal": [5, 8], **SEEN}, [])
    tables = tables_of(simulation)
    tables.points[0, 0, :3], tables.count[0, 0], tables.margin[0, 0] = [[1, 5], [5, 5], [5, 8]], 3, 0.1
    tables.side[0, 0] = 1 if pose[0] == 5 else 0
    simulation.state.pose[0, 0, :2] = pose
    seen = tables.seen
    points = PointMap(seen.x, seen.y, seen.side, seen.places[0, 0], seen.filled[0, 0])
    add_point(points, (float(point[0]), float(point[1])), (0.0, 0.0))
    obstacles = Obstacles(simulation.model, simulation.state, 0, tables.standing[0], None, points)
    assert way_is_blocked(obstacles, 0.2, tables, 0, 0, 0) == blocked


def test_a_place_beside_an_end_that_is_too_near_to_a_wall() -> None:
    """Of 16 directions, counted to the left from x on, the first that leads away far enough, in steps of 0.05 m.

    0.31 m above a wall a disc of 0.4 m fits 0.1 m farther, at 67.5 degrees: 0.31 + 0.0924 = 0.402. In a corner it needs
    0.3 m along both axes, that is 0.42 m, more than its radius.
    """
    floor = among([[0, 1], [9, 1]])
    expected = (5.0 + 0.1 * np.cos(0.75 * QUARTER), 1.31 + 0.1 * np.sin(0.75 * QUARTER))
    assert place_beside(floor, 0.4, (5.0, 1.31)) == pytest.approx(expected)
    assert place_beside(floor, 0.4, (5.0, 1.41)) == (5.0, 1.41)
    assert place_beside(among([[1, 9], [1, 1], [9, 1]]), 0.4, (1.1, 1.1)) == (1.1, 1.1)


def test_a_way_begins_and_ends_where_it_was_asked_for() -> None:
    """Both ends are 0.31 m above a wall from which the way keeps 0.4 m."""
    robot = {"kinematics": {"name": "omni"}, "state": [2, 1.31, 0], "goal": [6, 1.31]}
    simulation = begun({**robot, "behavior": {"name": "pursuit", "clearance": 0.2}}, [wall([0, 1], [9, 1])])
    simulation.step()
    tables = tables_of(simulation)
    aside, up = 0.1 * np.cos(0.75 * QUARTER), 0.1 * np.sin(0.75 * QUARTER)
    expected = [[2, 1.31], [2 + aside, 1.31 + up], [6 + aside, 1.31 + up], [6, 1.31]]
    assert tables.points[0, 0, : tables.count[0, 0]] == pytest.approx(np.array(expected))


def test_the_clearance_is_halved_as_often_as_a_gap_needs() -> None:
    """A gap of 0.424 m for a disc of 0.2 m: 0.0125 m on both sides are too much, 0.00625 m are not."""
    gate = [wall([2, -1], [2, 1.025 - 0.212]), wall([2, 1.025 + 0.212], [2, 3])]
    behavior = {"name": "pursuit", "cell": 0.1, "clearance": 0.1}
    robot = {"kinematics": {"name": "omni"}, "shape": DISC, "state": [1, 1.025, 0], "goal": [3, 1.025]}
    simulation = begun({**robot, "behavior": behavior}, gate, width=4, height=2.05)
    tables = tables_of(simulation)
    assert (tables.coarse.grid.cell, tables.fine.grid.cell) == (0.1, 0.05)
    blocks = np.array([False, True, True])
    obstacles = Obstacles(simulation.model, simulation.state, 0, blocks, None, None)
    for clearance, kept in ((0.1, 0.00625), (0.011, 0.011), (0.2, 0.0)):
        find_way(obstacles, 0.2, clearance, ((1.0, 1.025), (3.0, 1.025)), tables, 0, 0)
        assert tables.count[0, 0] == 2
        assert tables.margin[0, 0] == pytest.approx(kept)
