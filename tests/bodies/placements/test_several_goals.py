"""Goals that are drawn one after another: each keeps what the first one keeps, and bodies go to all of them in turn."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.errors import PlacementError, ScenarioError
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.scenario.reading.level_reading import read_levels

N_WORLDS = 20
OMNI = {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.2}}
PLACE = {"name": "random", "min_goal_distance": 4, "min_distance": 0.9, "clearance": 0.1, "reachable": True}


def drawn(goals: int = 3, n_worlds: int = N_WORLDS, **place: Any) -> ig.Simulation:
    """Return robots among boxes, and a wall that no robot passes."""
    robots = {**OMNI, "number": 3, "distribution": {**PLACE, "goals": goals, **place}}
    shape = {"name": "rectangle", "length": 1.5, "width": 1}
    boxes = {"number": 4, "shape": shape, "distribution": {"name": "random", "min_distance": 0}}
    wall = {"shape": {"name": "linestring", "vertices": [[0, 6], [12, 6]]}}
    scenario = ig.load_scenario({"world": {"width": 12, "height": 12}, "robot": robots, "obstacle": [boxes, wall]})
    simulation = ig.compile(scenario, n_worlds)
    simulation.reset(seed=5)
    return simulation


def test_each_goal_is_free_apart_far_from_the_one_before_and_on_its_side_of_the_wall() -> None:
    sim = drawn()
    assert sim.model.waypoint_count[:, :3].tolist() == [[3] * 3] * N_WORLDS
    stops = np.concatenate([sim.model.start[:, :3, None, :2], sim.model.waypoints[:, :3, :, :2]], axis=2)
    assert (np.linalg.norm(np.diff(stops, axis=2), axis=3) >= 4.0).all()
    above = stops[..., 1] > 6.0
    assert (above == above[:, :, :1]).all()
    assert 0 < above[:, :, 0].sum() < above[:, :, 0].size
    for w in range(N_WORLDS):
        walls = [shapely.Polygon(sim.state.segments[w, k : k + 4, :2]) for k in sim.model.segment_start[3:7]]
        for points in stops[w, :, 1:]:
            assert min(box.distance(shapely.Point(*point)) for box in walls for point in points) >= 0.3
        for i in range(3):
            for j in range(i):
                gaps = np.linalg.norm(stops[w, i, None, 1:] - stops[w, j, 1:, None], axis=2)
                assert gaps.min() >= 0.9


def test_start_and_first_goal_of_the_first_robot_are_those_without_further_goals() -> None:
    """Where no level has to be drawn again."""
    one, three = (
        ig.compile(ig.load_scenario({"robot": {**OMNI, "distribution": {**PLACE, "goals": goals}}}), N_WORLDS)
        for goals in (1, 3)
    )
    for sim in (one, three):
        sim.reset(seed=5)
    np.testing.assert_array_equal(one.model.start[:, 0], three.model.start[:, 0])
    np.testing.assert_array_equal(one.model.waypoints[:, 0, 0], three.model.waypoints[:, 0, 0])


def test_lengths_of_ways_hold_for_each_leg() -> None:
    """Without anything in the way, the way between two points is as long as the straight one."""
    place = {"name": "random", "goals": 4, "min_way_length": 3, "max_way_length": 5}
    sim = ig.compile(ig.load_scenario({"robot": {**OMNI, "distribution": place}}), N_WORLDS)
    sim.reset(seed=1)
    stops = np.concatenate([sim.model.start[:, 0, None, :2], sim.model.waypoints[:, 0, :, :2]], axis=1)
    lengths = np.linalg.norm(np.diff(stops, axis=1), axis=2)
    assert lengths.shape == (N_WORLDS, 4)
    assert (lengths <= 5.0).all()
    assert (lengths >= 3.0 * 0.97).all()  # found ways are up to 3 % longer
    assert np.ptp(lengths) > 1.5


def test_goals_in_cells_are_in_the_middle_of_free_cells_that_are_joined() -> None:
    cells = {"name": "cells", "fill": [0.4, 0.5]}
    robots = {**OMNI, "number": 2, "distribution": {"name": "cells", "goals": 3}}
    sim = ig.compile(ig.load_scenario({"world": {"obstacle_map": cells}, "robot": robots}), N_WORLDS)
    sim.reset(seed=3)
    for w in range(N_WORLDS):
        free = sim.model.map_squares[w, 0] > 0
        area = shapely.union_all([shapely.box(i, j, i + 1, j + 1) for i, j in np.argwhere(free)]).buffer(-0.01)
        for b in range(2):
            goals = sim.model.waypoints[w, b, :3, :2]
            np.testing.assert_allclose(goals % 1.0, 0.5)
            points = [shapely.Point(*point) for point in (sim.model.start[w, b, :2], *goals)]
            assert any(all(part.contains(point) for point in points) for part in shapely.get_parts(area))
            assert all(a != b for a, b in zip(points[1:], points, strict=False))


def test_what_stands_keeps_clear_of_all_goals_of_those_before_it() -> None:
    """A list of goals that the file gives counts too, for goals that are drawn later and for what is put down later."""
    given = {**OMNI, "state": [1, 1, 0], "goal": [[[5, 1], [5, 5], [1, 5]]]}
    random = {"name": "random", "range_low": [0.5, 0.5, 0], "range_high": [5.5, 5.5, 0], "min_distance": 0}
    stones = {"number": 3, "shape": {"name": "circle", "radius": 0.6}, "distribution": random}
    data = {"world": {"width": 6, "height": 6}, "robot": [given, {**OMNI, "distribution": random}], "obstacle": stones}
    sim = ig.compile(ig.load_scenario(data), 60)
    sim.reset(seed=0)
    for goal in ([5, 1], [5, 5], [1, 5]):
        assert (np.linalg.norm(sim.state.pose[:, 2:, :2] - goal, axis=2) >= 0.8).all()
        assert (np.linalg.norm(sim.model.waypoints[:, 1, 0, :2] - goal, axis=1) >= 0.4).all()


def test_a_batch_is_single_worlds_and_a_file_is_what_was_drawn(tmp_path: Path) -> None:
    batch, file = drawn(n_worlds=4), tmp_path / "levels.npz"
    levels = draw_levels(batch, ["test"], 6)
    assert levels.goal.shape[2:] == (3, 3)
    file.write_bytes(levels.content())
    again = read_levels(file)
    np.testing.assert_array_equal(again.goal, levels.goal)
    assert again.hashes().tolist() == levels.hashes().tolist()
    data = {**batch.scenario.source.data, "levels": str(file)}
    given, single = ig.compile(ig.load_scenario(data), 4), drawn(n_worlds=1)
    for sim in (batch, given):
        sim.reset(1, "test")
    for name in ("start", "waypoints", "waypoint_count"):
        np.testing.assert_array_equal(getattr(given.model, name), getattr(batch.model, name), err_msg=name)
    single.reset(3, "test")
    np.testing.assert_array_equal(single.model.waypoints[0], batch.model.waypoints[2])
    assert draw_levels(given, ["test"], 6).hashes().tolist() == levels.hashes().tolist()
    moved = levels.goal.copy()
    moved[2, 1, 2, 0] += 0.01
    assert (draw_levels(given, ["test"], 6).hashes() == levels.hashes()).all()
    changed = type(levels)(**{**vars(levels), "goal": moved}).hashes() != levels.hashes()
    assert changed.tolist() == [False, False, True, False, False, False]


def test_who_begins_anew_gets_as_many_goals() -> None:
    sim = drawn()
    before = sim.model.waypoints[:, :3].copy()
    chosen = np.tile([True, False, False], (N_WORLDS, 1))
    sim.run(lambda shard: sim.respawn(shard, np.arange(3), chosen), np.arange(N_WORLDS))
    np.testing.assert_array_equal(sim.model.waypoints[:, 1:3], before[:, 1:])
    stops = np.concatenate([sim.state.pose[:, 0, None, :2], sim.model.waypoints[:, 0, :, :2]], axis=1)
    assert (np.linalg.norm(np.diff(stops, axis=1), axis=2) >= 4.0).all()
    assert (sim.state.goal[:, 0] == sim.model.waypoints[:, 0, 0]).all()
    assert (stops[:, 1:] != before[:, 0, :, :2]).any(axis=2).all()


BEHAVIORS = ["dash", "rvo", "sfm", "pursuit", "dwa", "hybrid_astar"]


def test_every_behavior_goes_to_all_goals_in_turn() -> None:
    place = {"distribution": {"name": "random", "goals": 3, "min_goal_distance": 3, "min_distance": 0}}
    sensor = {"name": "lidar2d", "number": 60, "angle_range": 2 * np.pi, "range_max": 4}
    robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "sensors": [sensor], **place}
    robots = [{**robot, "behavior": {"name": name}} for name in BEHAVIORS]
    crowd = {**OMNI, **place, "number": 2, "group_behavior": {"name": "orca"}}
    loop = {**OMNI, **place, "behavior": {"name": "dash", "loop": True}}
    world = {"width": 9, "height": 9, "collision_mode": "unobstructed"}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": [*robots, crowd, loop]}))
    sim.reset(seed=1)
    arrived, passed, rounds = np.zeros(9, np.bool_), np.zeros((9, 3), np.bool_), 0
    for _ in range(500):
        before = sim.state.waypoint[0].copy()
        sim.step()
        ahead = sim.state.waypoint[0] - before
        assert ((ahead[:8] == 0) | (ahead[:8] == 1)).all()
        rounds += int(ahead[8] == -2)
        distance = np.linalg.norm(sim.model.waypoints[0, :, :, :2] - sim.state.pose[0, :, None, :2], axis=2)
        passed |= distance < sim.model.goal_threshold[0, :, None]
        arrived |= sim.state.arrived[0]
        assert (passed[:8][arrived[:8]]).all(), "arrived before it was at all of its goals"
    assert arrived[:8].all(), [*BEHAVIORS, "orca", "orca"]
    assert rounds >= 1


def robot_with(**more: Any) -> dict[str, Any]:
    return {"robot": {**OMNI, "number": 2, "distribution": {"name": "random", **more}}}


def test_bad_numbers_of_goals_are_told() -> None:
    for goals, told in ((0, "goals: must be >= 1, got 0"), (1001, "goals: must be <= 1000, got 1001")):
        with pytest.raises(ScenarioError, match=told):
            ig.load_scenario(robot_with(goals=goals))
    data = robot_with(goals=2)
    for more, told in (
        ({"static": True}, "goals: 2 needs bodies that move: these stand still and have no goals"),
        (
            {"behavior": {"name": "dash", "wander": True}},
            "goals: 2 needs bodies that keep their goals, .* wander: true",
        ),
    ):
        with pytest.raises(ScenarioError, match=rf"robot_0.distribution: {told}"):
            ig.compile(ig.load_scenario({"robot": {**data["robot"], **more}}, warn=False))
    full = {"world": {"width": 3, "height": 3}, **robot_with(goals=40, min_distance=1.2)}
    with pytest.raises(PlacementError, match=r"no place found for 'robot_1'.*bounds, goals, min_distance"):
        ig.compile(ig.load_scenario(full)).reset()


FILES = [
    (1, 2, "levels.goal: level 0 and 2 more, 'robot_0': needs 2 goals, as in the scenario, got 1"),
    (2, 1, "levels.goal: level 0 and 2 more, 'robot_0': needs a goal, since its distribution would draw one, got 2"),
]


@pytest.mark.parametrize(("in_file", "in_scenario", "told"), FILES)
def test_a_file_with_another_number_of_goals_is_refused(
    tmp_path: Path, in_file: int, in_scenario: int, told: str
) -> None:
    levels = draw_levels(ig.compile(ig.load_scenario(robot_with(goals=in_file))), ["test"], 3)
    (tmp_path / "levels.npz").write_bytes(levels.content())
    with pytest.raises(ScenarioError, match=re.escape(told)):
        ig.load_scenario({**robot_with(goals=in_scenario), "levels": str(tmp_path / "levels.npz")})


def test_goals_of_a_file_have_no_gaps_and_a_single_goal_stays_single(tmp_path: Path) -> None:
    goal = np.full((1, 1, 3, 3), np.nan)
    goal[0, 0, ::2] = [[8, 8, 0], [2, 8, 0]]
    one = {**OMNI, "state": [1, 1, 0], "goal": [5, 5, 0]}
    for rows, told in (
        (goal, "level 0, 'robot_0': rows of NaN must come after all goals"),
        (goal[:, :, ::2], "level 0, 'robot_0': has 1 goal in the scenario, so the file can give it no more"),
        (goal[:, :, :0], "levels.goal: holds no goal"),
    ):
        np.savez(tmp_path / "levels.npz", bodies=["robot_0"], start=np.ones((1, 1, 3)), goal=rows)
        with pytest.raises(ScenarioError, match=re.escape(told)):
            ig.load_scenario({"robot": one, "levels": str(tmp_path / "levels.npz")})
