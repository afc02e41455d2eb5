"""The dynamic window approach: formulas of Fox et al. and hand-made cases."""

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.bodies.behaviors.local_planners.dwa_search import stop_time
from irsim_gym.bodies.behaviors.local_planners.rollouts import place_at, spread_over

DIFF = {"kinematics": {"name": "diff"}, "vel_min": [0, -1.5], "vel_max": [1, 1.5]}
OMNI = {"kinematics": {"name": "omni", "frame": "body"}, "vel_min": [-1, -1], "vel_max": [1, 1]}
CAR = {"kinematics": {"name": "acker", "wheelbase": 0.3}, "vel_min": [0, -0.6], "vel_max": [1, 0.6]}
DRIVES = {"diff": DIFF, "omni": OMNI, "car": CAR}
SEES = [{"name": "lidar2d", "number": 121, "angle_range": 2 * np.pi, "range_max": 5}]


def scene(posts: Any, turn: float = 0.0, mirror: float = 1.0, **more: Any) -> dict[str, Any]:
    """Return a robot at the origin, 4 m before its goal, among posts; turned about it, or mirrored."""

    def put(x: float, y: float) -> list[float]:
        y *= mirror
        return [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn)]

    options = {"name": "dwa", **more.pop("options", {})}
    goal = [*put(*more.pop("to", (4, 0))), 0]
    robot = {"shape": {"name": "circle", "radius": 0.2}, "sensors": SEES, "goal_threshold": 0.2, **more}
    robot |= {"state": [0, 0, turn], "goal": goal, "behavior": options}
    round_posts = [{"shape": {"name": "circle", "radius": r}, "state": [*put(x, y), 0]} for x, y, r in posts]
    world = {"height": 16, "width": 16, "offset": [-8, -8], "step_time": 0.1, "name": "local"}
    return {"world": world, "robot": robot, "obstacle": round_posts}


def command(data: dict[str, Any], steps: int = 1) -> np.ndarray:
    simulation = ig.compile(ig.load_scenario(data))
    simulation.reset(seed=0)
    for _ in range(steps):
        simulation.step()
    return np.array(simulation.state.command[0, 0, :2])


def test_formulas() -> None:
    # A quarter of a circle of radius 2 m to the left; and straight.
    np.testing.assert_allclose(place_at((1.0, 0.0, 0.5), np.pi), (2.0, 2.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(place_at((1.0, 0.5, 0.0), 2.0), (2.0, 1.0, 1.0, 0.0))
    # v <= sqrt(2 d a): from 1 m/s with 0.5 m/s2 it takes 1 m, which is there for 1 s at that speed.
    assert stop_time(1.0, 0.5) == 1.0
    assert stop_time(1.0, np.inf) == 0.0
    assert [spread_over(-1.0, 2.0, i, 4) for i in range(4)] == [-1.0, 0.0, 1.0, 2.0]


def test_free_ways_are_straight_and_fast() -> None:
    assert command(scene([], **DIFF)).tolist() == [1.0, 0.0]
    assert command(scene([], **OMNI)).tolist() == [1.0, 0.0]
    assert command(scene([], **CAR)).tolist() == [1.0, 0.0]
    # The window of a step: 0.1 s of 2 m/s2 from rest.
    np.testing.assert_allclose(command(scene([], **DIFF, acce=[2.0, 10.0])), [0.2, 0.0])


@pytest.mark.parametrize(("free", "expected"), [(0.3, 0.6), (0.2, 0.5), (0.15, 0.4), (0.1, 0.0)])
def test_speeds_are_admissible(free: float, expected: float) -> None:
    """The greatest of 0.4, 0.5 and 0.6 m/s, the window at 0.5 m/s, with v dt + v^2 / (2 a) below the free distance.

    With 0.1 s and 1 m/s2 these are 0.12, 0.175 and 0.24 m.
    """
    options = {"samples": [3, 1], "sim_granularity": 0.01, "sim_time": 0.01, "footprint_padding": 0.0}
    data = scene([(1.2 + free, 0.0, 1.0)], **DIFF, options={**options, "path": "straight", "obstacle_weight": 0.0})
    data["robot"] |= {"acce": [1.0, 100.0], "velocity": [0.5, 0.0]}
    np.testing.assert_allclose(command(data), [expected, 0.0], atol=1e-12)


def test_who_is_enclosed_stands_or_escapes() -> None:
    ring = [(0.75 * np.cos(a), 0.75 * np.sin(a), 0.2) for a in np.linspace(0, 2 * np.pi, 13)[:-1]]
    options = {"free_time": 1.5, "min_speed": 0.5, "samples": [7, 1]}
    assert command(scene(ring, **DIFF, options=options)).tolist() == [0.0, 0.0]
    assert command(scene(ring, **DIFF, options={**options, "escape_speed": -0.2})).tolist() == [-0.2, 0.0]


def test_a_turn_on_the_spot_begins_as_fast_as_a_step_allows() -> None:
    # 0.1 s of 1 rad/s2 reach 0.1 rad/s, less than min_turn_rate; the goal is to the left.
    data = scene([(0.62, 0.0, 0.4)], **DIFF, acce=[1.0, 1.0], to=(0, 3))
    np.testing.assert_allclose(command(data), [0.0, 0.1])
    slower = {"acce": [1.0, 10.0], "options": {"min_turn_rate": 0.8}}
    assert command(scene([(0.62, 0.0, 0.4)], **DIFF, to=(0, 3), **slower))[1] >= 0.8


@pytest.mark.parametrize("drive", DRIVES)
def test_a_post_is_passed(drive: str) -> None:
    simulation = ig.compile(ig.load_scenario(scene([(2.0, 0.15, 0.4)], **DRIVES[drive])))
    simulation.reset(seed=0)
    for _ in range(150):
        simulation.step()
        assert not simulation.state.collided[0, 0]
        if simulation.state.arrived[0, 0]:
            break
    assert simulation.state.arrived[0, 0]


POSTS = [(1.2, 0.1, 0.4), (1.0, -1.3, 0.3), (2.5, -0.6, 0.3)]


@pytest.mark.parametrize("drive", DRIVES)
def test_mirrored_and_turned_levels(drive: str) -> None:
    """Ranges are single precision, so that what costs the same within that may be told apart."""
    options = {"options": {"path": "straight"}, "to": (3.0, 1.5), **DRIVES[drive]}
    here = command(scene(POSTS, **options), 2)
    assert here[1] != 0.0
    np.testing.assert_allclose(command(scene(POSTS, mirror=-1.0, **options), 2), here * [1, -1], atol=1e-9)
    np.testing.assert_allclose(command(scene(POSTS, turn=np.pi / 2, **options), 2), here, atol=1e-9)


@pytest.mark.parametrize("path", ["map", "seen"])
def test_batches_and_shards_follow_the_same_paths(path: str) -> None:
    """A single world, a batch, one on threads, and one whose steps are not recorded; the posts are drawn."""
    data = scene([], **DIFF, options={"path": path})
    shape = {"name": "circle", "random_shape": True, "radius_range": [0.2, 0.4]}
    where = {"name": "random", "range_low": [0.7, -2, 0], "range_high": [3.3, 2, 0]}
    data["obstacle"] = [{"number": 5, "shape": shape, "distribution": where}]
    scenario = ig.load_scenario(data)
    poses = []
    for n_worlds, first, kwargs in ((3, 0, {}), (3, 0, {"num_threads": 2}), (3, 0, {"fused": False}), (1, 2, {})):
        simulation = ig.compile(scenario, n_worlds, **kwargs)
        for _ in range(2):  # what was seen is forgotten
            simulation.reset(seed=first)
            for _ in range(25):
                simulation.step()
        poses.append(simulation.state.pose[-1, 0].copy())
    assert (np.array(poses) == poses[0]).all()


@pytest.mark.parametrize("path", ["map", "seen"])
def test_paths_lead_out_of_a_trap(path: str) -> None:
    """Straight on is a dead end: three walls around the goal's side."""
    walls = {"name": "linestring", "vertices": [[-0.5, 1.0], [1.5, 1.0], [1.5, -1.0], [-0.5, -1.0]]}
    arrived = {}
    for chosen in ("straight", path):
        data = scene([], **DIFF, options={"path": chosen})
        data["obstacle"] = [{"shape": walls, "state": [0, 0, 0]}]
        simulation = ig.compile(ig.load_scenario(data))
        simulation.reset(seed=0)
        for _ in range(250):
            simulation.step()
        arrived[chosen] = bool(simulation.state.arrived[0, 0])
    assert arrived == {"straight": False, path: True}


def test_the_real_polygon_fits_where_its_disc_does_not() -> None:
    """A corridor of 0.5 m: the box is 0.3 m wide, its circle 0.67 m."""
    box = {"shape": {"name": "rectangle", "length": 0.6, "width": 0.3}}
    walls = [{"name": "linestring", "vertices": [[-1, y], [6, y]]} for y in (0.25, -0.25)]
    data = scene([], **DIFF, **box, options={"obstacle_weight": 0.0})
    data["obstacle"] = [{"shape": wall, "state": [0, 0, 0]} for wall in walls]
    assert command(data).tolist() == [1.0, 0.0]
    data["robot"]["shape"] = {"name": "circle", "radius": 0.24}
    assert command(data).tolist() == [1.0, 0.0]


@pytest.mark.parametrize(("slowest", "expected"), [(100.0, [0.5, 1.5]), (1.0, [0.0, 0.0])])
def test_a_turn_that_cannot_be_stopped_in_time_is_not_admissible(slowest: float, expected: list[float]) -> None:
    """With 1 rad/s2, 1.5 rad/s take the angle to stop that they turn in 0.75 s: after 0.1 s more, a post is touched.

    With 100 rad/s2, the speed of 0.5 m/s takes longer to stop than the turn: the way of 0.25 s, which is free.
    """
    options = {"samples": [1, 2], "sim_time": 0.01, "sim_granularity": 0.01, "footprint_padding": 0.0}
    limits = {"vel_min": [0.5, -1.5], "vel_max": [0.5, 1.5], "acce": [1.0, slowest], "velocity": [0.5, 1.5]}
    radius, angle = 0.5 / 1.5, 1.5 * 0.85
    post = radius * np.sin(angle), radius * (1.0 - np.cos(angle)) + 0.25, 0.2
    drive = {"kinematics": {"name": "diff"}, **limits, "to": (0, 3)}
    data = scene([post], **drive, options={**options, "path": "straight", "obstacle_weight": 0.0})
    assert command(data).tolist() == expected


@pytest.mark.parametrize("path", ["seen", "map"])
def test_nothing_is_remembered_in_another_level(path: str) -> None:
    """A world that has played another level does what a fresh one does: paths, seen cells and turns are new."""
    box = {"number": 4, "shape": {"name": "rectangle", "length": 1.2, "width": 0.3}}
    boxes = {**box, "distribution": {"name": "random", "range_low": [-1, -2, -3], "range_high": [1, 2, 3]}}
    data = {**scene([], **DIFF, options={"path": path, "samples": [3, 5]}), "obstacle": boxes}
    data["world"] |= {"height": 6, "width": 6, "offset": [-3, -3]}
    data["robot"]["state"], data["robot"]["goal"] = [-2.5, 0, 0], [2.5, 0, 0]
    used, fresh = (ig.compile(ig.load_scenario(data)) for _ in range(2))
    used.reset(seed=0)
    for _ in range(12):
        used.step()
    for simulation in (used, fresh):
        simulation.reset(seed=1)
        for _ in range(8):
            simulation.step()
    np.testing.assert_array_equal(used.state.pose, fresh.state.pose)
