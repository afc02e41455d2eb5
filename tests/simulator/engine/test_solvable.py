"""Levels that can be solved: what stands is in the way, agents follow no behaviour, and nothing outlives a level."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.errors import PlacementError, ScenarioError
from irsim_gym.simulator.cell_paths.queries import free_path_length
from irsim_gym.tasks import Episodes, load_task

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
RANDOM = {"name": "random", "min_distance": 0, "reachable": True}


def begun(data: dict[str, Any], n_worlds: int = 100, agents: tuple[int, ...] = (0,)) -> ig.Simulation:
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=agents)
    sim.reset()
    return sim


def discs(count: int, radius: float = 0.8, **keys: Any) -> dict[str, Any]:
    shape = {"name": "circle", "radius": radius}
    return {"number": count, "shape": shape, "distribution": {"name": "random", "min_distance": 0}, **keys}


def gaps(sim: ig.Simulation, points: np.ndarray) -> np.ndarray:
    """Return the distance of each world's point from the nearest standing disc."""
    stands = np.flatnonzero(sim.model.stands)
    centres, radii = sim.state.pose[:, stands, :2], sim.state.discs[:, stands, 2]
    return (np.linalg.norm(centres - points[:, None], axis=2) - radii).min(axis=1)


def test_bodies_that_nobody_drives_stand_in_the_way() -> None:
    parked = {**DIFF, "number": 8, "distribution": RANDOM}
    sim = begun(
        {"robot": [{**DIFF, "distribution": RANDOM}, parked], "obstacle": discs(6, kinematics={"name": "diff"})}
    )
    assert sim.model.stands.tolist() == [False] + [True] * 14
    assert gaps(sim, sim.state.goal[:, 0, :2]).min() >= 0.2


@pytest.mark.parametrize("behavior", [{"name": "dash", "wander": True}, {"name": "dash", "loop": True}])
def test_an_agents_behavior_is_overridden(behavior: dict[str, Any]) -> None:
    sim = begun({"robot": {**DIFF, "distribution": RANDOM, "behavior": behavior}, "obstacle": discs(8)})
    assert gaps(sim, sim.state.goal[:, 0, :2]).min() >= 0.2
    assert (sim.state.waypoint_end[:, 0] == 1).all()
    assert sim.model.waypoint_count[0, 0] == 1


def test_all_given_goals_stay_free_and_can_be_reached() -> None:
    robot = {**DIFF, "state": [1, 1, 0], "goal": [[[9, 1, 0], [9, 9, 0]]]}
    sim = begun({"robot": robot, "obstacle": discs(10)})
    for goal in sim.model.waypoints[0, 0, :2, :2]:
        assert gaps(sim, np.broadcast_to(goal, (100, 2))).min() >= 0.2
    for w in range(100):
        free = shapely.box(0, 0, 10, 10).difference(
            shapely.union_all([shapely.Point(*disc[:2]).buffer(disc[2] + 0.2) for disc in sim.state.discs[w, 1:]])
        )
        assert any(
            all(part.contains(shapely.Point(point)) for point in ((1, 1), (9, 1), (9, 9)))
            for part in shapely.get_parts(free)
        )


def ways(sim: ig.Simulation, bodies: tuple[int, ...]) -> list[bool]:
    """Return for each world and body whether start and goal lie in one part of what walls and standing discs leave."""
    stands, joined = np.flatnonzero(sim.model.stands & ~sim.model.unobstructed), []
    for w in range(len(sim.state.pose)):
        blocks = [shapely.Point(*disc[:2]).buffer(disc[2] + 0.3, quad_segs=64) for disc in sim.state.discs[w, stands]]
        if sim.model.cells is not None:
            cells = np.argwhere(sim.model.map_squares[w, 0] == 0).tolist()
            blocks += [shapely.box(i, j, i + 1, j + 1).buffer(0.3) for i, j in cells]
        parts = shapely.get_parts(shapely.box(*sim.model.bounds).difference(shapely.union_all(blocks)))
        for b in bodies:
            ends = shapely.MultiPoint([sim.state.pose[w, b, :2], sim.model.waypoints[w, b, 0, :2]])
            joined.append(any(part.covers(ends) for part in parts))
    return joined


def test_ways_lead_past_standing_bodies_that_are_placed_later() -> None:
    # There is room for 22 discs of 0.6 m, but in one of ten levels they close a way that was proved before.
    shape = {"name": "circle", "radius": 0.3}
    moving = {**DIFF, "shape": shape, "number": 2, "behavior": {"name": "dash"}, "distribution": RANDOM}
    assert all(ways(begun({"obstacle": [moving, discs(22, 0.6)]}, n_worlds=50, agents=()), (0, 1)))


def test_ways_keep_their_length_past_bodies_that_are_placed_later() -> None:
    limits = {"name": "random", "range_low": [1, 1, 0], "range_high": [9, 9, 0], "max_way_length": 5}
    moving = {**DIFF, "behavior": {"name": "dash"}, "distribution": limits}
    sim = begun({"obstacle": [moving, discs(20, 0.6)]}, n_worlds=60, agents=())
    ends = [(sim.state.pose[w, 0, :2], sim.model.waypoints[w, 0, 0, :2]) for w in range(60)]
    lengths = [free_path_length(sim.model, sim.state, w, 0.2, *ends[w]) for w in range(60)]
    assert max(lengths) <= 5 * 1.03


def test_cells_are_joined_past_standing_bodies_that_are_placed_later() -> None:
    # A robot that stands in a corridor closes it, and without loops there is no way around.
    world = {"width": 9, "height": 9, "obstacle_map": {"name": "maze", "resolution": 1, "loops": 0}}
    robot = {**DIFF, "number": 2, "shape": {"name": "circle", "radius": 0.3}, "distribution": {"name": "cells"}}
    sim = begun({"world": world, "robot": robot})
    assert all(ways(sim, (0,)))


def test_a_level_that_no_draw_can_make_passable_is_an_error() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 10]]}}
    robot = {**DIFF, "state": [1, 1, 0], "goal": [9, 1, 0]}
    with pytest.raises(PlacementError, match="no way to its goal"):
        begun({"robot": robot, "obstacle": [wall, discs(2)]}, n_worlds=1)


def test_absent_bodies_leave_nothing_behind() -> None:
    obstacle = {**DIFF, "number_range": [0, 4], "distribution": RANDOM, "behavior": {"name": "dash"}}
    data = {"world": {"name": "yard"}, "robot": {**DIFF, "distribution": RANDOM}, "obstacle": obstacle}
    used = begun(data, n_worlds=1)
    for level in range(20):
        used.reset(seed=level)
        fresh = ig.compile(used.scenario, 1, agents=(0,))
        fresh.reset(seed=level)
        np.testing.assert_array_equal(used.state.goal, fresh.state.goal)
        np.testing.assert_array_equal(used.state.pose, fresh.state.pose)


def test_the_first_step_drops_a_goal_not_the_reset() -> None:
    sim = begun({"robot": {**DIFF, "state": [1, 5, 0], "goal": [[[1, 5, 0], [9, 5, 0]]]}}, n_worlds=1)
    assert sim.state.waypoint[0, 0] == 0
    sim.step([0.0, 0.0])
    assert sim.state.waypoint[0, 0] == 1


def test_bounds_that_do_not_fit_the_world_are_told_with_their_line() -> None:
    robot = {**DIFF, "distribution": {"name": "random", "range_low": [12, 0, 0]}}
    with pytest.raises(ScenarioError, match=r"range_low \[12.0, 0.0, 0.0\] exceeds range_high \[9.5, 9.5"):
        begun({"robot": robot})


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ({"number_range": [0, 1], "distribution": RANDOM}, "number_range may leave it out"),
        ({"behavior": {"name": "dash", "loop": True}}, "has no goal"),
    ],
)
def test_robots_that_cannot_learn(robot: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        load_task(ig.load_scenario({"robot": {**DIFF, **robot}}))


def test_a_new_goal_begins_a_new_record() -> None:
    scenario = ig.load_scenario({"robot": {**DIFF, "state": [1, 5, 0], "goal": [[[2, 5, 0], [9, 5, 0]]]}})
    task = load_task(scenario, {"name": "blank", "observations": ["goal_record"]})
    episodes = Episodes(ig.compile(scenario, agents=(0,)), task)
    episodes.begin(np.array([0]), np.array([0]))
    for _ in range(30):
        episodes.step(np.array([[[1.0, 0.0]]]))
        assert episodes.view.observation[0, 0].tolist() == [0, 0]


def test_crossing_irregularity_is_refused() -> None:
    shape = {"name": "polygon", "random_shape": True, "irregularity_range": [0, 3]}
    with pytest.raises(ScenarioError, match="must lie between 0 and 1, got up to 3"):
        ig.load_scenario({"obstacle": {"shape": shape}})
