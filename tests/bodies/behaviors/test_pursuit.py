"""Pursuit: its formulas, its way against an independent search, and whether it arrives, with every drive."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

import irsim_gym as ig
from irsim_gym.base.options import defaults
from irsim_gym.bodies.behaviors.pursuit.formulas import arc_curvature, lookahead_distance, regulated_speed
from irsim_gym.bodies.behaviors.pursuit.pursuit import Pursuit
from irsim_gym.bodies.behaviors.pursuit.way import place_on_way, point_at_distance, remaining_length
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import ScenarioError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.simulator.engine import Shard, Simulation
from irsim_gym.simulator.world.group import Group
from tests.simulator.paths.scenes import Scene, visibility_length

DISC = {"name": "circle", "radius": 0.2}
START, GOAL = [3.5, 5.0], [8.0, 5.0]
L_WALL = [[5.0, 0.0], [5.0, 6.0], [2.0, 6.0]]
"""The short side is over the start: the way leads around its end and then around the corner."""


def options(**given: Any) -> Any:
    """Return one record of options as kernels read it."""
    group = Group(Pursuit, [Pursuit(**given)], np.zeros(1, np.int64))
    return group.params[0]


def begun(drive: dict[str, Any], obstacles: list[dict[str, Any]], n_worlds: int = 1, **world: Any) -> Simulation:
    robot = {"shape": DISC, "goal_threshold": 0.2, "behavior": {"name": "pursuit"}, **drive}
    scenario = {"world": {"step_time": 0.1, **world}, "robot": robot, "obstacle": obstacles}
    simulation = ig.compile(ig.load_scenario(scenario), n_worlds)
    simulation.reset(seed=0)
    return simulation


def wall(*vertices: list[float]) -> dict[str, Any]:
    return {"shape": {"name": "linestring", "vertices": [list(vertex) for vertex in vertices]}}


def way_of(simulation: Simulation, world: int = 0) -> NDArray[np.float64]:
    tables = simulation.parts.behaviors[0].tables
    return tables.points[world, 0, : tables.count[world, 0]].copy()


def length_of(way: NDArray[np.float64]) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())


@pytest.mark.parametrize(
    ("ahead", "aside", "curvature"),
    # On the circle of radius r to the left, a quarter turn leads to (r, r), a half turn to (0, 2 r).
    [(2.0, 2.0, 0.5), (0.0, 2.0, 1.0), (0.0, -2.0, -1.0), (3.0, 0.0, 0.0), (0.0, 0.0, 0.0)],
)
def test_the_arc_to_a_point(ahead: float, aside: float, curvature: float) -> None:
    assert arc_curvature(ahead, aside) == pytest.approx(curvature)


def test_the_lookahead_grows_with_the_speed() -> None:
    given = options(lookahead_time=1.5, lookahead_min=0.3, lookahead_max=0.9)
    assert [lookahead_distance(given, speed) for speed in (0.1, 0.4, 2.0)] == pytest.approx([0.3, 0.6, 0.9])
    assert lookahead_distance(options(lookahead_time=1.5), 2.0) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("curvature", "room", "remaining", "speed"),
    [
        (0.0, 9.0, 9.0, 1.0),
        (2.0, 9.0, 9.0, 1.0),  # a radius of 0.5 m is not below the least one
        (-4.0, 9.0, 9.0, 0.5),  # half of it
        (0.0, 0.3, 9.0, 0.5),  # 0.3 m of 0.6 m
        (-2.5, 0.3, 9.0, 0.5),  # the slower of 0.8 and 0.5
        (4.0, 0.45, 9.0, 0.5),  # the slower of 0.5 and 0.75
        (50.0, 9.0, 9.0, 0.25),  # not below the least speed
        (0.0, 9.0, 0.4, 0.4),  # at the end of the way: 0.4 m of 1 m
        (0.0, 9.0, 0.01, 0.05),
    ],
)
def test_speed_is_regulated(curvature: float, room: float, remaining: float, speed: float) -> None:
    given = options(min_radius=0.5, proximity=0.6, min_speed=0.25, approach=1.0, approach_speed=0.05)
    assert regulated_speed(given, 1.0, curvature, room, remaining) == pytest.approx(speed)


def test_places_on_a_way() -> None:
    """A way 4 m to the right, then 3 m up; the body is 0.3 m above its first side, 1 m before the corner."""
    way = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    side, near = place_on_way(way, 4, 0, (3.0, 0.3))
    assert (side, near) == (0, (3.0, 0.0))
    assert remaining_length(way, 4, side, near) == pytest.approx(1.0 + 3.0 + 4.0)
    assert point_at_distance(way, 4, side, (3.0, 0.3), 0.5) == pytest.approx((3.4, 0.0))  # 0.3, 0.4, 0.5
    assert point_at_distance(way, 4, side, (3.0, 0.3), 1.25) == pytest.approx((4.0, 1.05))  # 0.75, 1, 1.25
    assert point_at_distance(way, 4, side, (3.0, 0.3), 0.2) == pytest.approx((3.0, 0.0))  # all of the way is farther
    assert point_at_distance(way, 4, side, (3.0, 0.3), 99.0) == pytest.approx((0.0, 3.0))
    assert place_on_way(way, 4, 0, (3.0, 2.9))[0] == 1  # the last side is nearer, but more than 2 m ahead


def test_the_way_around_an_l_is_the_shortest() -> None:
    """Its length is that of another search, on shapely's visibility graph, for the radius and the clearance kept."""
    simulation = begun({"kinematics": {"name": "diff"}, "state": [*START, 0.0], "goal": GOAL}, [wall(*L_WALL)])
    simulation.step()
    scene = Scene(10.0).chain(*((x, y) for x, y in L_WALL))
    assert length_of(way_of(simulation)) == pytest.approx(visibility_length(scene, 0.3, START, GOAL), rel=0.005)
    assert simulation.parts.behaviors[0].tables.margin[0, 0] == 0.1


def test_mirrored_and_turned_worlds_have_the_same_ways() -> None:
    steps, lengths = [], []
    for turn in (lambda x, y: (x, y), lambda x, y: (10.0 - x, y), lambda x, y: (10.0 - y, x), lambda x, y: (y, x)):
        start, goal, vertices = turn(*START), turn(*GOAL), [list(turn(x, y)) for x, y in L_WALL]
        aside = turn(START[0] + 1.0, START[1])
        heading = np.arctan2(aside[1] - start[1], aside[0] - start[0])
        robot = {"kinematics": {"name": "diff"}, "state": [*start, float(heading)], "goal": list(goal)}
        simulation = begun(robot, [wall(*vertices)])
        while not simulation.state.arrived[0, 0] and simulation.state.step[0] < 200:
            simulation.step()
        lengths.append(length_of(way_of(simulation)))
        steps.append(int(simulation.state.step[0]))
    assert lengths == pytest.approx([lengths[0]] * 4, rel=1e-3)
    assert max(steps) - min(steps) <= 1
    assert max(steps) < 200


def test_nothing_is_found_anew_in_worlds_that_go_on() -> None:
    robot = {"kinematics": {"name": "diff"}, "state": [*START, 0.0], "goal": [GOAL, START]}
    simulation = begun(robot, [wall(*L_WALL)], n_worlds=2)
    tables = simulation.parts.behaviors[0].tables
    simulation.step()
    tables.retry[:] = 10**6  # written where a way is looked for
    simulation.begin(Shard(np.array([1])), simulation.level_keys(5))
    for _ in range(40):
        simulation.step()
    assert tables.retry[0, 0] == 10**6
    assert tables.retry[1, 0] < 100
    while simulation.state.waypoint[0, 0] == 0:
        simulation.step()
    simulation.step()
    assert tables.retry[0, 0] < 1000
    assert tables.goal[0, 0].tolist() == START


def test_it_waits_for_what_moves() -> None:
    """In a corridor that somebody stands in who could move it stops; when that one is gone it goes on."""
    corridor = [wall([0.0, 4.6], [10.0, 4.6]), wall([0.0, 5.4], [10.0, 5.4])]
    other = {"kinematics": {"name": "diff"}, "shape": DISC, "state": [5.0, 5.0, 0.0], "behavior": {"name": "dash"}}
    robot = {"kinematics": {"name": "diff"}, "state": [1.0, 5.0, 0.0], "goal": [9.0, 5.0]}
    simulation = begun(robot, [*corridor, other])
    for _ in range(100):
        simulation.step()
    assert not simulation.state.collided[0].any()
    assert 3.5 < simulation.state.pose[0, 0, 0] < 4.6
    simulation.model.present[0, -1] = False
    for _ in range(80):
        simulation.step()
    assert simulation.state.arrived[0, 0]


def test_it_arrives_with_a_heading() -> None:
    robot = {"kinematics": {"name": "diff"}, "state": [1.0, 5.0, 0.0], "goal": [4.0, 5.0, -2.0], "arrive_mode": "state"}
    simulation = begun(robot, [])
    for _ in range(100):
        simulation.step()
    assert simulation.state.arrived[0, 0]


def test_no_way_no_command() -> None:
    robot = {"kinematics": {"name": "omni"}, "state": [*START, 0.0], "goal": GOAL}
    simulation = begun(robot, [wall([5.0, -1.0], [5.0, 11.0])])
    for _ in range(30):
        simulation.step()
    assert simulation.state.pose[0, 0, :2].tolist() == START


DRIVES = {
    "diff": {},
    "diff, slow to change": {"acce": [0.5, 1.0]},
    "omni, slow to change": {
        "kinematics": {"name": "omni"},
        "vel_max": [1, 1],
        "vel_min": [-1, -1],
        "acce": [0.5, 0.5],
    },
    "omni_angular": {"kinematics": {"name": "omni_angular"}, "vel_max": [1, 1, 1], "vel_min": [-1, -1, -1]},
    "acker": {"kinematics": {"name": "acker", "wheelbase": 0.2}, "vel_max": [1, 0.8], "vel_min": [-1, -0.8]},
}


@pytest.mark.parametrize("name", DRIVES)
def test_every_drive_arrives_in_drawn_levels(name: str) -> None:
    scenario = yaml.safe_load((configs_folder() / "scenarios" / "cluttered_room.yaml").read_text(encoding="utf-8"))
    scenario["robot"][0] |= DRIVES[name]
    rows = evaluate(BehaviorPolicy("pursuit"), Worlds(scenario, 16).episodes, 24, "dev")
    assert {row.outcome for row in rows} == {"success"}


SCANNER = [{"name": "lidar2d", "number": 90, "angle_range": 2 * np.pi, "range_max": 3.0}]
SEEN = {"behavior": {"name": "pursuit", "known": "seen"}, "sensors": SCANNER}


def test_what_scans_have_not_shown_makes_no_difference() -> None:
    """A block behind the wall, never in sight, is not there in the other world: every step is the same."""
    block = {"shape": {"name": "rectangle", "length": 1.0, "width": 1.0}}
    robot = {"kinematics": {"name": "diff"}, "state": [2.5, 5.0, 0.0], "goal": [8.0, 5.0], **SEEN}
    there = {**block, "state": [9.5, 0.6, 0.0]}
    hidden, bare = (begun(robot, [wall([5.0, 4.0], [5.0, 6.0]), *more]) for more in ([there], []))
    ways = []
    while not hidden.state.arrived[0, 0]:
        hidden.step()
        bare.step()
        ways.append(way_of(hidden).shape)
        assert hidden.state.pose[0, 0].tolist() == bare.state.pose[0, 0].tolist()
        assert hidden.state.step[0] < 200
    assert ways[0] != (2, 2)  # the wall was in sight from the start, and is in the way


def test_what_is_out_of_sight_is_not_in_the_way() -> None:
    """The way is straight until the wall comes into the range of 3 m, and leads around it from then on."""
    robot = {"kinematics": {"name": "omni"}, "state": [1.0, 5.0, 0.0], "goal": [9.0, 5.0], **SEEN}
    simulation = begun(robot, [wall([6.0, 3.5], [6.0, 6.5])])
    while simulation.state.pose[0, 0, 0] < 2.9:
        simulation.step()
        assert way_of(simulation).tolist() == [[1.0, 5.0], [9.0, 5.0]]
    while not simulation.state.arrived[0, 0]:
        simulation.step()
        assert not simulation.state.collided[0, 0]
    assert length_of(way_of(simulation)) > 1.0


def test_a_way_that_a_body_barred_is_found_again() -> None:
    """What was seen of a body that has gone since is forgotten when no way is left."""
    gate = [wall([5.0, 0.0], [5.0, 4.6]), wall([5.0, 5.4], [5.0, 10.0])]
    guard = {"shape": {"name": "circle", "radius": 0.3}, "kinematics": {"name": "omni"}, "state": [5.0, 5.0, 0.0]}
    robot = {"kinematics": {"name": "omni"}, "state": [3.0, 5.0, 0.0], "goal": [8.0, 5.0], **SEEN}
    simulation = begun(robot, [*gate, guard])
    for _ in range(40):
        simulation.step()
    assert simulation.state.pose[0, 0, 0] < 5.0
    simulation.model.present[0, -1] = False
    while not simulation.state.arrived[0, 0]:
        simulation.step()
        assert simulation.state.step[0] < 300


def test_who_sees_nothing_needs_a_scanner() -> None:
    robot = {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [9, 9], "behavior": SEEN["behavior"]}
    with pytest.raises(ScenarioError, match="'pursuit' reads the body's own scan, but the body has no range sensor"):
        ig.load_scenario({"robot": robot})
    assert ig.load_scenario({"robot": {**robot, "behavior": {"name": "pursuit"}}})
    policy = BehaviorPolicy("pursuit:known=seen")
    with pytest.raises(UnfitBehaviorError, match="has no range sensor"):
        policy.check(Worlds({"robot": robot | {"behavior": {"name": "dash"}}, "task": {}}, 1).episodes)


def test_seen_ways_are_the_same_in_any_batch() -> None:
    """Batch, share and single environment agree bit for bit, and a recorded step is the plain one."""
    scenario = yaml.safe_load((configs_folder() / "scenarios" / "cluttered_room.yaml").read_text(encoding="utf-8"))
    scenario["robot"][0]["behavior"] = SEEN["behavior"]
    loaded = ig.load_scenario(scenario)
    made = [ig.compile(loaded, 3, num_threads=2), ig.compile(loaded, 1), ig.compile(loaded, 3, fused=False)]
    for simulation, seed in zip(made, (4, 6, 4), strict=True):
        simulation.reset(seed)
        for _ in range(40):
            simulation.step()
    assert made[0].state.pose[2].tobytes() == made[1].state.pose[0].tobytes()
    assert made[0].state.pose.tobytes() == made[2].state.pose.tobytes()


def test_options_that_cannot_be() -> None:
    assert defaults(Pursuit).clearance == 0.1
    problems = list(Pursuit(lookahead_min=0.5, lookahead_max=0.4).problems())
    assert problems == [("lookahead_max", "must be >= lookahead_min, 0.5, got 0.4")]
