"""Ways over the cells that scans have shown: what is renewed, and whose maps and ways these are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.simulator.cell_paths.scan_marks import OCCUPIED
from irsim_gym.simulator.cell_paths.wavefront import block_border
from irsim_gym.simulator.paths.grid import BLOCKED, Grid
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.observations.bodies.time_to_collision import MovingPoint, meet_side
from irsim_gym.tasks.observations.seen_map.seen_ways import clear_levels, find_way, narrow_ways
from irsim_gym.tasks.observations.seen_map.team_ways import write_points

WAY = {"name": "way_on_seen_map", "cell": 0.5, "every": 1}


def alone(observation: dict[str, Any] = WAY, **more: Any) -> tuple[Episodes, Any, Any]:
    """Return a robot in an empty yard that observes one thing, the observation's term and its arrays."""
    episodes = play({**ROBOT, **more}, None, {"name": "blank", "observations": [observation]})
    term = episodes.terms["observations"][0]
    return episodes, term, term.arrays


def border(shape: tuple[int, ...]) -> Any:
    """Return free cells with a blocked border."""
    levels = np.zeros(shape, np.uint8)
    block_border(levels)
    return levels


def test_cells_that_become_free_give_all_levels_and_costs_anew() -> None:
    """Nothing is added or taken away without need, and costs are kept as long as nothing became free."""
    episodes, term, ways = alone()
    empty = border(ways.levels.shape[2:])

    def narrowed(*, freed: int, noted: int = 0) -> tuple[Any, bool]:
        """Return the levels after a scan that freed so many quarters, and whether costs are kept."""
        ways.levels[0, 0], ways.target[0, 0] = empty, [8, 5]
        ways.levels[0, 0, 3, 3] = BLOCKED
        ways.seen.n_freed[0, 0], ways.seen.n_fresh[0, 0], ways.seen.noted[0, 0] = freed, 0, noted
        narrow_ways(np.array([0]), term.bound, ways, episodes.simulation.model, episodes.state)
        return ways.levels[0, 0].copy(), bool(ways.target[0, 0, 0] == 8)

    ways.seen.cells[:], stale = 0, empty.copy()
    stale[3, 3] = BLOCKED
    for freed, levels, is_kept in ((0, stale, True), (1, empty, False), (2, empty, False)):
        found = narrowed(freed=freed)
        np.testing.assert_array_equal(found[0], levels)
        assert found[1] == is_kept
    found = narrowed(freed=1, noted=-1)  # this scan is not in the map yet
    np.testing.assert_array_equal(found[0], stale)
    assert found[1]
    ways.seen.cells[0, 0, 6, 7] = OCCUPIED
    levels, _ = narrowed(freed=1)
    assert np.argwhere(levels != empty).tolist() == [[6, 7]]  # row and column


def test_an_episode_that_begins_forgets_its_goal_and_others_do_not() -> None:
    episodes, _, ways = alone()
    ways.target[:], ways.levels[:] = 3.0, BLOCKED
    episodes.state.began[0, 0] = False
    clear_levels(np.array([0]), ways, episodes.state)
    assert ways.target[0, 0].tolist() == [3, 3]
    assert (ways.levels == BLOCKED).all()
    episodes.state.began[0, 0] = True
    clear_levels(np.array([0]), ways, episodes.state)
    assert np.isnan(ways.target[0, 0, 0])
    np.testing.assert_array_equal(ways.levels[0, 0], border(ways.levels.shape[2:]))


def test_costs_are_renewed_for_a_goal_elsewhere_along_either_axis() -> None:
    """From the middle of column 4 and row 4, over free cells of 0.5 m: four steps to each goal."""
    _, _, ways = alone()
    ways.levels[0, 0], ways.target[:] = border(ways.levels.shape[2:]), np.nan
    grid = ways.seen.grid
    here = (grid.origin_x + 4.5 * 0.5, grid.origin_y + 4.5 * 0.5)
    for column, row in ((8, 4), (8, 8), (4, 8), (4, 4 + 8), (8, 4)):
        goal = (grid.origin_x + (column + 0.5) * 0.5, grid.origin_y + (row + 0.5) * 0.5)
        count = find_way(ways, 0, 0, 0, here, goal)
        assert ways.way[0, 0] == 4 * grid.columns + 4
        assert ways.way[0, count - 1] == row * grid.columns + column
        assert count == max(abs(column - 4), abs(row - 4)) + 1
        assert ways.target[0, 0].tolist() == pytest.approx(goal)
        ways.least[0, 0, row, column + 1] = 5  # a mark of costs that are kept
        find_way(ways, 0, 0, 0, here, goal)
        assert ways.least[0, 0, row, column + 1] == 5


def test_points_of_a_way_begin_with_its_start() -> None:
    """A straight way has a point for each cell of 0.5 m, one over cells their middles."""
    grid, none = Grid(1.0, -2.0, 0.5, 20, 10), np.zeros(0, np.int32)
    points = np.full((6, 2), np.nan)
    assert write_points(points, (2.0, 1.0), (3.2, 2.6), none, grid) == 5
    assert points[:5] == pytest.approx(np.array([[2, 1], [2.3, 1.4], [2.6, 1.8], [2.9, 2.2], [3.2, 2.6]]))
    assert np.isnan(points[5]).all()
    way = np.array([3 * 20 + 5, 4 * 20 + 6], np.int32)
    assert write_points(points, (3.5, -0.5), (9, 9), way, grid) == 3
    assert points[:3].tolist() == [[3.5, -0.5], [3.75, -0.25], [4.25, 0.25]]
    assert write_points(points[:2], (3.5, -0.5), (9, 9), way, grid) == 2


def test_hits_of_robots_are_left_out_of_the_map_of_whoever_takes_a_scan() -> None:
    """After a respawn the robots' episodes are not equally old: one takes a scan when the other does not."""
    robots = [{**ROBOT, "state": [2, 5, 0]}, {**ROBOT, "state": [4, 5, np.pi], "goal": [1, 5, 0]}]
    task = {"name": "blank", "observations": [{"name": "yielding_way", "every": 2}]}
    episodes = play(robots, None, task, team=True)
    skipped = episodes.terms["observations"][0].arrays.ways.seen.skipped
    assert skipped[0, 0].any()
    assert skipped[0, 1].any()
    for ages in ((0, 1), (1, 0)):
        episodes.state.steps[0], skipped[:] = ages, False
        drive(episodes, -1.0, 0.0)
        assert [bool(skipped[0, a].any()) for a in range(2)] == [age == 1 for age in ages]


def test_a_wall_that_is_overlapped_is_met_at_once() -> None:
    """The agent's disc of 0.5 m reaches 0.2 m beyond the wall at x = 0.3: time 0 towards it, never less."""
    ahead, aside = np.array([1, -1, 0], np.float32), np.array([0, 0, 1], np.float32)
    row = np.full(3, 4.0, np.float32)
    meet_side(MovingPoint(0.3, -5.0, 0.0, 0.0, 0.5), 0.0, 10.0, ahead, aside, row)
    assert row.tolist() == [0, 4, 4]
    row[:] = 4.0
    meet_side(MovingPoint(2.5, -5.0, 0.0, 0.0, 0.5), 0.0, 10.0, ahead, aside, row)
    assert row.tolist() == [2, 4, 4]


def test_directions_and_speeds_of_times_are_named() -> None:
    """Of four directions the first is straight behind; the speeds are halves of 1 m/s."""
    kind = {"name": "time_to_collision", "directions": 4, "speeds": 2, "speed": 1.0}
    episodes, term, _ = alone(kind, sensors=[])
    columns = term.options.columns(term, episodes.simulation.model, 0)
    quarters = [-np.pi, -np.pi / 2, 0, np.pi / 2]
    assert [part.count for part in columns] == [4, 4]
    for part in columns:
        assert [angle for angle, _ in part.sectors] == pytest.approx(quarters)
    assert ["0.5 m/s" in columns[0].meaning, "1 m/s" in columns[1].meaning] == [True, True]


def test_a_body_that_no_goal_leads_to_is_met_all_the_same() -> None:
    robot = {key: value for key, value in ROBOT.items() if key != "goal"}
    task = {"name": "blank", "observations": [{"name": "time_to_collision", "directions": 4, "horizon": 10.0}]}
    episodes = play([{**robot, "sensors": []}], BALL, task)
    assert episodes.view.observation[0, 0] == pytest.approx([0, 0, 1 - 2.3 / 10, 0], abs=1e-6)
