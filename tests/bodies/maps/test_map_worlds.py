"""Worlds with a map: contact, scans and clearance."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.simulator.cell_paths.queries import free_path
from tests.simulator.geometry.cell_maps import area

# 5 x 4 cells of 2 x 1 m with lower left corner (1, 2); a wall of two cells in the middle column.
MAP = np.zeros((5, 4), np.bool_)
MAP[2, 1:3] = True
WORLD = {"width": 10, "height": 4, "offset": [1, 2], "obstacle_map": MAP}
ROBOT = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.5}, "state": [2, 4, 0]}
LIDAR = {"name": "lidar2d", "number": 3, "angle_range": "pi", "range_max": 6}


def simulation(robots: Any, obstacles: Any = (), n_worlds: int = 1, **world: Any) -> Any:
    data = {"world": {**WORLD, **world}, "robot": robots, "obstacle": list(obstacles)}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=tuple(range(len(robots))))
    sim.reset(seed=0)
    return sim


def test_the_map_is_the_last_body() -> None:
    sim = simulation([ROBOT], [{"shape": {"name": "circle"}, "state": [20, 20, 0]}])
    assert sim.parts.names == ("robot_0", "obstacle_1", "obstacle_2")
    assert sim.model.map_frame.item() == (1, 2, 2, 1, 2)
    assert np.array_equal(sim.model.map_squares[0, 0] == 0, MAP)


def test_a_robot_stops_at_the_wall() -> None:
    sim = simulation([ROBOT])
    steps = 0
    while not sim.state.collided[0, 0]:
        sim.step([1.0, 0.0])
        steps += 1
    # The wall begins at x = 5, the robot's front at 2.5; 25 steps of 0.1 m touch it.
    assert steps in (25, 26)
    assert sim.state.hit[0].tolist() == [1, 0]
    assert sim.state.collided[0].tolist() == [True, True]
    sim.step([-1.0, 0.0])
    assert sim.state.pose[0, 0, 0] == pytest.approx(2.0 + 0.1 * steps)


@pytest.mark.parametrize(
    ("mode", "stopped"), [("stop", True), ("unobstructed", False), ("unobstructed_obstacles", True)]
)
def test_collision_modes(mode: str, stopped: bool) -> None:
    sim = simulation([ROBOT], collision_mode=mode)
    for _ in range(28):
        sim.step([1.0, 0.0])
    assert sim.state.collided[0, 0]
    assert sim.state.stopped[0, 0] == stopped


def test_an_unobstructed_body_passes() -> None:
    sim = simulation([{**ROBOT, "unobstructed": True}])
    for _ in range(28):
        sim.step([1.0, 0.0])
    assert not sim.state.collided[0].any()


def test_the_lower_body_is_named_first() -> None:
    inside = [{**ROBOT, "state": [2 + x, 4, 0]} for x in (0.0, 0.6)]
    sim = simulation([*inside, {**ROBOT, "state": [9, 4, 0]}], collision_mode="unobstructed")
    for _ in range(28):
        sim.step([1.0, 0.0])
    assert sim.state.hit[0].tolist() == [1, 0, -1, 0]


def test_a_fixed_obstacle_in_the_wall_touches_it_for_good() -> None:
    sim = simulation([ROBOT], [{"shape": {"name": "rectangle"}, "state": [6, 3.2, 0]}])
    sim.step([0.0, 0.0])
    assert sim.state.hit[0].tolist() == [-1, 2, 1]


def test_scans_see_the_map_and_what_stands_before_it() -> None:
    post = {"shape": {"name": "circle", "radius": 0.5}, "state": [8.5, 4, 0]}
    left = {**ROBOT, "sensors": [LIDAR]}
    right = {**ROBOT, "state": [10, 4, 3.141592653589793], "sensors": [{**LIDAR, "offset": [0.5, 0, 0]}]}
    sim = simulation([left, right], [post])
    group, _ = sim.scan(0)
    assert group.arrays["ranges"][0, 0].tolist() == pytest.approx([6, 3, 6])
    assert group.arrays["ranges"][0, 1].tolist() == pytest.approx([6, 0.5, 6], abs=1e-6)


def test_range_min_holds_at_the_map() -> None:
    sim = simulation([{**ROBOT, "state": [4.2, 4, 0], "sensors": [{**LIDAR, "range_min": 1.5}]}])
    assert sim.scan(0)[0].arrays["ranges"][0, 0].tolist() == pytest.approx([6, 1.5, 6])


def test_velocity_of_the_map_is_zero() -> None:
    sim = simulation([{**ROBOT, "sensors": [{**LIDAR, "has_velocity": True}]}])
    sim.step([0.0, 0.0])
    assert not sim.scan(0)[0].arrays["velocity"].any()


def test_clearance() -> None:
    sim = simulation([ROBOT, {**ROBOT, "state": [6, 5.8, 0]}])
    distance = np.zeros((1, 2))
    sim.run(lambda shard: sim.clearance(shard, np.array([0, 1]), distance))
    assert distance[0].tolist() == pytest.approx([2.5, 0.3])
    sim.run(lambda shard: sim.clearance(shard, np.array([0, 1]), distance, limit=1.0))
    assert distance[0].tolist() == pytest.approx([1.0, 0.3])


def test_a_start_in_the_wall_is_refused() -> None:
    with pytest.raises(ScenarioError, match="robot_0: the start lies in the obstacle map; a robot"):
        simulation([{**ROBOT, "state": [6, 4, 0]}])


def test_behaviours_do_not_take_the_map_for_a_body() -> None:
    """Its cells are no body with a place and a size; in IR-SIM it is one disc around all of them."""
    driver = {
        **ROBOT,
        "state": [2, 5.7, 0],
        "goal": [10, 5.7, 0],
        "behavior": {"name": "dash"},
        "fov": 6,
        "fov_radius": 9,
    }
    data = {"world": WORLD, "robot": [driver], "obstacle": []}
    sim = ig.compile(ig.load_scenario(data))
    sim.reset(seed=0)
    for _ in range(60):
        sim.step()
    assert sim.state.pose[0, 0, 0] == pytest.approx(8.0)


@pytest.mark.parametrize("name", ["cave", "floor_plan"])
def test_every_level_of_the_shipped_scenarios_has_a_way(name: str) -> None:
    """The ways that are found keep the robot's radius from every occupied cell, by shapely's word."""
    sim = ig.compile(ig.load_scenario(name), 3, agents=(0,))
    sim.reset(seed=0)
    occupied = area(sim.scenario.occupied, *sim.model.map_frame.item()[:4])
    radius = float(sim.model.reach[0, 0])
    for w in range(3):
        start, goal = sim.state.pose[w, 0], sim.state.goal[w, 0]
        way = free_path(sim.model, sim.state, w, radius, start, goal, cell=0.5 * radius)
        assert way[0].tolist() == start[:2].tolist()
        assert way[-1].tolist() == goal[:2].tolist()
        assert shapely.distance(shapely.LineString(way), occupied) > radius - 1e-9
