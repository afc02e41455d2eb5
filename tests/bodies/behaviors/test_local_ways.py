"""The ways, seen cells, rollouts and turns of local planners, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_dwa import CAR, DIFF, OMNI, command, scene

import irsim_gym as ig
from irsim_gym.base.arraytypes import BodyOutline
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.local_planners.dwa import MOST_SAMPLES, Dwa
from irsim_gym.bodies.behaviors.local_planners.dwa_search import note_move, note_turn
from irsim_gym.bodies.behaviors.local_planners.paths import keep_way
from irsim_gym.bodies.behaviors.local_planners.rollouts import POSES, gap_at, is_round, lay_poses, twist_of
from irsim_gym.bodies.behaviors.local_planners.seen_way import find_seen_way, is_still_free, note_hit
from irsim_gym.bodies.behaviors.local_planners.task import see_hits, task_of
from irsim_gym.bodies.behaviors.local_planners.way import advance_on_way, lay_way, nearest_on_side, off_way
from irsim_gym.bodies.behaviors.pursuit.motion import Moving
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_BODY, OMNI_WORLD
from irsim_gym.simulator.world.own_scan import OwnScan

GRID = Grid(0.0, 0.0, 0.5, 10, 8)


def planner(path: str, posts: Any = (), **more: Any) -> tuple[Simulation, Any, Any]:
    """Return a robot at the origin of a world of 6 m by 4 m, 2 m before its goal, its tables and its turns."""
    data = scene(list(posts), options={"path": path, "samples": [3, 5]}, **{**DIFF, "to": (2, 0), **more})
    data["world"] |= {"width": 6, "height": 4, "offset": [-3, -2]}
    simulation = ig.compile(ig.load_scenario(data))
    simulation.reset(seed=0)
    return simulation, *simulation.parts.behaviors[0].tables[0]


@pytest.mark.parametrize("path", ["map", "seen"])
def test_a_way_is_kept_until_the_goal_changes_or_the_body_has_gone_astray(path: str) -> None:
    simulation, tables, _ = planner(path)
    ways, state = tables.ways, simulation.state
    simulation.step()
    assert (ways.count[0, 0], ways.side[0, 0]) == (2, 0)
    assert ways.points[0, 0, :2].tolist() == [[0, 0], [2, 0]]
    detour = [[0, 0], [0, 1], [2, 1], [2, 0]]

    def kept(pose: list[float], goal: list[float]) -> bool:
        """Return whether another way is still there after a step."""
        ways.points[0, 0, :4], ways.count[0, 0], ways.side[0, 0], ways.goal[0, 0] = detour, 4, 0, [2, 0]
        ways.since[0, 0] = 0
        state.pose[0, 0, :2], state.goal[0, 0, :2] = pose, goal
        simulation.step()
        assert ways.goal[0, 0].tolist() == goal
        return bool(ways.count[0, 0] == 4)

    assert kept([0, 0], [2, 0])
    assert kept([0.5, 0.1], [2, 0])  # 0.5 m beside it
    assert not kept([0, 0], [2, -1])
    assert not kept([0, 0], [1, 0])
    assert not kept([-1.1, 0.5], [2, 0])  # 1.1 m beside it


def test_points_of_a_way_that_are_too_near_to_the_one_before_are_left_out() -> None:
    _, tables, _ = planner("map")
    ways = tables.ways
    ways.path[:4] = [[1, 2], [1.05, 2.02], [1.5, 2.3], [1.52, 2.33]]
    keep_way(ways, 0, 0, 4, (1.52, 2.33))
    assert ways.count[0, 0] == 3
    assert ways.points[0, 0, :3].tolist() == [[1, 2], [1.5, 2.3], [1.52, 2.33]]
    assert ways.goal[0, 0].tolist() == [1.52, 2.33]
    # 300 points, of which there is room for 256: the last one is kept, and those before it as far as they go.
    ways.path[:300, 0], ways.path[:300, 1] = np.arange(300.0), -2.0 * np.arange(300.0)
    keep_way(ways, 0, 0, 300, (299.0, -598.0))
    assert ways.count[0, 0] == 256
    assert ways.points[0, 0, [0, 254, 255]].tolist() == [[0, 0], [254, -508], [299, -598]]


def test_the_side_beside_which_a_body_is() -> None:
    _, tables, _ = planner("map")
    ways = tables.ways
    ways.points[0, 0, :4], ways.count[0, 0] = [[0, 0], [1.5, 0], [1.5, 3], [0, 3]], 4
    for begin, place, side, distance in ((0, (0.7, 0.4), 0, 0.4), (0, (1.4, 0.4), 1, 0.1), (1, (1.7, 2.0), 1, 0.2)):
        ways.side[0, 0] = begin
        assert advance_on_way(ways, 0, 0, place) == pytest.approx(distance)
        assert ways.side[0, 0] == side
    assert advance_on_way(ways, 0, 0, (0.5, 0.0)) == pytest.approx(1.0)  # never back to a side that was left
    ways.side[0, 0] = 0
    assert advance_on_way(ways, 0, 0, (0.5, 2.9)) == pytest.approx(1.0)  # nor to one more than 2 m ahead
    ways.count[0, 0] = 0
    assert advance_on_way(ways, 0, 0, (9.0, 9.0)) == 0.0


@pytest.mark.parametrize(
    ("heading", "length", "expected"),
    [
        (0.0, 9.0, [(0, 0), (0.5, 0), (0.5, 1), (2.5, 1)]),
        (0.0, 1.55, [(0, 0), (0.5, 0), (0.5, 1), (2.5, 1)]),  # 0.5 m and 1 m are less than that
        (0.0, 1.45, [(0, 0), (0.5, 0), (0.5, 1)]),
        (0.0, 0.4, [(0, 0), (0.5, 0)]),
        (np.pi / 2, 9.0, [(0, 0), (0, -0.5), (1, -0.5), (1, -2.5)]),
    ],
)
def test_the_way_ahead_is_in_the_frame_of_the_body(heading: float, length: float, expected: Any) -> None:
    """The robot is 0.5 m along a way that leads 1 m ahead, 1 m to the left and 2 m ahead."""
    simulation, tables, _ = planner("map")
    ways, state = tables.ways, simulation.state
    ways.points[0, 0, :4], ways.count[0, 0] = [[-0.5, 0], [0.5, 0], [0.5, 1], [2.5, 1]], 4
    state.pose[0, 0], state.goal[0, 0, :2] = [0, 0, heading], [2.5, 1]
    count = lay_way(state, ways, 0, 0, length, tables.way)
    np.testing.assert_allclose(tables.way[:, :count].T, expected, atol=1e-12)


def test_the_nearest_point_on_a_side() -> None:
    """From (1, 2) to (4, 6) it has the direction (0.6, 0.8); the body is 1 m to the left of its middle."""
    points = np.array([[9.0, 9.0], [1.0, 2.0], [4.0, 6.0]])
    assert nearest_on_side(points, 1, (2.5 - 0.8, 4.0 + 0.6)) == pytest.approx((0.8, -0.6))
    assert nearest_on_side(points, 1, (0.4, 1.2)) == pytest.approx((0.6, 0.8))
    assert nearest_on_side(points, 1, (4.6, 6.8)) == pytest.approx((-0.6, -0.8))


@pytest.mark.parametrize(
    ("xs", "point", "most", "expected"),
    [
        ([0, 1, 2, 3], (1.5, 0.2), 9.0, (0.2, 1.5)),  # sides of 1 m
        ([0, 1, 1, 3], (2.5, -0.3), 9.0, (0.3, 2.5)),  # a point twice
        ([0, 1, 2, 3], (2.5, 0.0), 1.0, (1.5, 1.0)),  # no farther than it drives
        ([0, 1, 2, 3], (-0.5, 0.1), 9.0, (0.1, -0.5)),  # it goes on behind its beginning
        ([0, 1, 2, 3], (3.3, 0.4), 9.0, (0.5, 3.0)),
        ([2, 2, 2, 2], (2.3, 0.4), 9.0, (0.5, 0.0)),  # no side has a length
    ],
)
def test_how_far_a_point_is_off_a_way(xs: Any, point: Any, most: float, expected: Any) -> None:
    assert off_way(np.array([xs, [0] * 4], np.float64), 4, point, most) == pytest.approx(expected)


@pytest.mark.parametrize("hit", [(2.1, 1.3), (0.1, 3.9), (4.9, 0.2), (2.5, 2.0)])
def test_cells_too_near_to_a_hit(hit: tuple[float, float]) -> None:
    """A body of 0.4 m that keeps 0.5 m more, against the distance of all centres; row by row."""
    hard, soft = np.zeros((8, 10), np.int32), np.zeros((8, 10), np.int32)
    note_hit(*hit, 0.4, 0.5, GRID, 7, hard, soft)
    x, y = np.meshgrid(0.25 + 0.5 * np.arange(10), 0.25 + 0.5 * np.arange(8))
    distance = np.hypot(x - hit[0], y - hit[1])
    np.testing.assert_array_equal(soft, np.where(distance <= 0.9, 7, 0))
    np.testing.assert_array_equal(hard, np.where(distance <= 0.4, 7, 0))


def test_what_a_scan_hits_is_noted_where_it_is() -> None:
    """A post of 0.3 m about (-0.9, 0.8): its side towards the robot is 0.9 m away, the body has 0.2 m."""
    simulation, tables, _ = planner("seen", [(-0.9, 0.8, 0.3)])
    simulation.step()
    hard, grid = tables.ways.seen.hard[0, 0], tables.ways.grid
    rows, columns = np.nonzero(hard == 1)
    x, y = grid.origin_x + (columns + 0.5) * grid.cell, grid.origin_y + (rows + 0.5) * grid.cell
    distance = np.hypot(x + 0.9, y - 0.8)
    assert len(rows) > 10
    assert distance.max() <= 0.5 + 1e-3
    near = np.hypot(0.9 - 0.3 * 0.747, 0.8 - 0.3 * 0.664)  # where the line to its middle meets it
    assert np.hypot(x, y).min() == pytest.approx(near - 0.2, abs=grid.cell)


def seen_way(start: Any, goal: Any, seen: Any, grid: Grid = GRID, oldest: int = 3) -> list[list[float]]:
    path = grid.path()
    count = find_seen_way(start, goal, grid, np.asarray(seen, np.int32), oldest, grid.search(), path)
    return path[:count].tolist()


def test_a_way_past_seen_cells() -> None:
    """A wall in column 5 with a gap in its last row; what was seen in step 3 or before is forgotten."""
    start, goal, wall = (1.1, 1.2), (4.1, 1.3), np.zeros((8, 10), np.int32)
    assert seen_way(start, goal, wall) == [list(start), list(goal)]
    wall[:7, 5] = 3
    assert seen_way(start, goal, wall) == [list(start), list(goal)]
    wall[:7, 5] = 4
    way = seen_way(start, goal, wall)
    assert (way[0], way[-1]) == (list(start), list(goal))
    assert max(y for _, y in way) > 3.5
    assert not any(2.5 < x < 3.0 and y < 3.5 for x, y in way)
    wall[7, 5] = 4
    assert seen_way(start, goal, wall) == []


def test_ways_to_and_from_the_first_cell_and_to_nowhere() -> None:
    free = np.zeros((8, 10), np.int32)
    assert seen_way((3.1, 2.2), (0.1, 0.2), free) == [[3.1, 2.2], [0.1, 0.2]]
    assert seen_way((0.1, 0.2), (3.1, 2.2), free) == [[0.1, 0.2], [3.1, 2.2]]
    grid, blocked = Grid(0.0, 0.0, 0.5, 40, 4), np.full((4, 40), 9)
    blocked[:, :5] = 0
    assert seen_way((1.0, 1.0), (18.0, 1.0), blocked, grid) == []  # nothing free is near the goal
    assert seen_way((18.0, 1.0), (1.0, 1.0), blocked, grid) == []


@pytest.mark.parametrize(
    ("points", "first", "free"),
    [
        ([[0.25, 2.25], [4.75, 2.25]], 0, False),
        ([[0.25, 1.75], [4.75, 1.75]], 0, True),
        ([[3.25, 0.25], [3.25, 3.75]], 0, False),
        ([[2.75, 0.25], [2.75, 3.75]], 0, True),
        ([[3.75, 0.25], [3.75, 3.75]], 0, True),
        ([[0.25, 2.25], [4.75, 2.25], [4.75, 3.75]], 1, True),  # it is past that
        ([[4.75, 3.75], [3.25, 3.75], [3.25, 0.25]], 0, False),  # on the second side
        ([[-2.0, 1.0], [7.0, 1.0]], 0, True),  # in and out of the grid
        ([[1.0, -2.0], [1.0, 7.0]], 0, True),
    ],
)
def test_a_way_is_free_until_one_of_its_cells_is_seen_blocked(points: Any, first: int, free: bool) -> None:
    """The cell of row 4 and column 6 has been found blocked in step 5: x from 3 to 3.5 m, y from 2 to 2.5 m."""
    seen, way = np.zeros((8, 10), np.int32), np.array(points, np.float64)
    seen[4, 6] = 5
    assert is_still_free(way, first, len(points), GRID, seen, 4) == free
    assert is_still_free(way, first, len(points), GRID, seen, 5)


def test_hits_close_to_the_one_before_are_left_out() -> None:
    """Four hits 1 m ahead, at 0, 1, -50 and 30 cm to the left, of which the second is nearer than 2 cm."""
    beams = np.array([[0.0, 0.01, -0.5, 0.3]])
    scan = OwnScan(
        sensors=np.zeros(1, np.int64), ranges=np.ones((1, 1, 4), np.float32), angles=np.zeros((1, 4)),
        beams_x=np.ones((1, 4)), beams_y=beams, offset=np.zeros((1, 3)), range_min=np.zeros(1),
        range_max=np.full(1, 9.0), noise=np.zeros(1),
    )  # fmt: skip
    simulation, _, _ = planner("straight")
    hits = np.zeros((2, 4))
    count = see_hits(scan, 0, 0, simulation.parts.behaviors[0].params[0], hits)
    assert hits[:, :count].T.tolist() == [[1, 0], [1, -0.5], [1, 0.3]]


@kernel
def goal_of(options: Any, model: Any, state: Any, tables: Any) -> tuple[float, float, float]:
    task = task_of(0, 0, 0, options, model, state, tables)
    return task.goal_x, task.goal_y, task.length


def test_the_goal_is_in_the_frame_of_the_body() -> None:
    simulation, tables, _ = planner("straight")
    options, state = simulation.parts.behaviors[0].params[0], simulation.state
    for heading, goal in ((0.0, (2, 1)), (np.pi / 2, (1, -2)), (-np.pi / 2, (-1, 2))):
        state.pose[0, 0], state.goal[0, 0, :2] = [0.5, 0.3, heading], [2.5, 1.3]
        found = goal_of(options, simulation.model, state, tables)
        assert found == pytest.approx((*goal, np.sqrt(5)))


@pytest.mark.parametrize(
    ("drive", "by_rate", "asked", "twist"),
    [
        (DIFFERENTIAL, False, (1.0, 2.0), (1, 0, 2)),
        (OMNI_WORLD, False, (1.0, 2.0), (0.8 + 1.2, 1.6 - 0.6, 0)),
        (OMNI_BODY, False, (1.0, 2.0), (1, 2, 0)),
        (ACKERMANN, True, (1.0, 2.0), (1, 0, 2)),
        (ACKERMANN, True, (0.0, 2.0), (0, 0, 0)),
        (ACKERMANN, False, (2.0, np.arctan(0.25)), (2, 0, 1)),  # 2 m/s times 0.25 over 0.5 m
    ],
)
def test_the_twist_of_a_command(drive: int, by_rate: bool, asked: Any, twist: Any) -> None:
    """The body's heading has the cosine 0.8 and the sine 0.6."""
    unused = np.zeros(3)
    moving = Moving(drive, by_rate, 0.5, 0.1, unused, 0.0, unused, unused, unused, unused)
    assert twist_of(moving, (0.8, 0.6), *asked) == pytest.approx(twist)


def outline(segments: Any, discs: Any) -> BodyOutline:
    rows, circles = np.reshape(segments, (-1, 4)).astype(float), np.reshape(discs, (-1, 3)).astype(float)
    return BodyOutline(rows, 0, len(rows), circles, 0, len(circles), True)


def test_only_a_disc_about_the_origin_is_round() -> None:
    discs = {(0, 0): True, (0, 0.3): False, (0.3, 0): False, (0.3, 0.3): False}
    assert {place: is_round(outline([], [[*place, 0.2]])) for place in discs} == discs
    assert not is_round(outline([], [[0, 0, 0.2]] * 2))
    assert not is_round(outline([[0, 0, 1, 0]], [[0, 0, 0.2]]))


def test_the_gap_of_an_outline_that_has_turned() -> None:
    """A box of 2 m by 1 m after a quarter turn to the left about its middle, which is at (1, 2)."""
    box = outline([[-1, -0.5, 1, -0.5], [1, -0.5, 1, 0.5], [1, 0.5, -1, 0.5], [-1, 0.5, -1, -0.5]], [])
    poses = np.zeros(1, POSES)
    record, reach = poses[0], np.sqrt(1.25)
    lay_poses((0.0, 0.0, 0.0), 0, 0.0, record)
    record.x[0], record.y[0], record.cosine[0], record.sine[0] = 1.0, 2.0, 0.0, 1.0
    for (x, y), gap in (((1, 4), 1.0), ((3, 2), 1.5), ((-1, 2), 1.5), ((1, -0.5), 1.5), ((1.4, 2.9), 0.0)):
        points = np.array([[9.0, x], [9.0, y]])
        record.near[0] = (x - 1.0) ** 2 + (y - 2.0) ** 2
        assert gap_at(box, reach, 5.0, points, 2, record, 0) == pytest.approx(gap)
        assert gap_at(box, reach, 0.5, points, 2, record, 0) == pytest.approx(min(gap, 0.5))


@pytest.mark.parametrize(
    ("posts", "goal", "turned"),
    [
        ([], (2, 0), 0),
        ([], (1, 0.5), 0),  # on a curve
        ([(0.62, 0.0, 0.4)], (0, 1.5), 1),
        ([(0.62, 0.0, 0.4)], (0, -1.5), -1),
    ],
)
def test_only_turns_on_the_spot_are_noted(posts: Any, goal: Any, turned: int) -> None:
    simulation, _, turns = planner("straight", posts, to=goal, acce=[1.0, 9.0])
    simulation.step()
    first, second = simulation.state.command[0, 0, :2]
    assert turns.turned[0, 0] == turned
    assert (first == 0.0 and second != 0.0) == (turned != 0)
    assert (second != 0.0) == (goal[1] != 0)


def test_turns_are_forgotten_after_a_distance_along_either_axis() -> None:
    """After turns to both sides at (1, 4); 0.25 m away everything begins anew."""
    _, _, turns = planner("straight")
    here = np.array([1.0, 4.0, 9.0])
    note_move(turns, 0, 0, here, 0.25)
    assert turns.origin[0, 0].tolist() == [1, 4]
    for side, turned in ((1, 1), (1, 1), (-1, -2), (-1, -2)):
        note_turn(turns, 0, 0, side)
        assert turns.turned[0, 0] == turned
    for dx, dy, is_far in ((0.2, 0.1, False), (0.0, -0.25, False), (-0.26, 0.0, True), (0.0, 0.26, True)):
        turns.origin[0, 0], turns.turned[0, 0] = [1, 4], 2
        note_move(turns, 0, 0, here + np.array([dx, dy, 0.0]), 0.25)
        assert turns.turned[0, 0] == (0 if is_far else 2)
        assert turns.origin[0, 0].tolist() == ([1 + dx, 4 + dy] if is_far else [1, 4])


@pytest.mark.parametrize("samples", [(0, 5), (5, 0), (5, MOST_SAMPLES + 1), (MOST_SAMPLES + 1, 5)])
def test_numbers_of_samples_that_cannot_be(samples: tuple[int, int]) -> None:
    message = f"must be two numbers from 1 to {MOST_SAMPLES}, got {list(samples)}"
    assert list(Dwa(samples=samples).problems()) == [("samples", message)]
    assert list(Dwa(samples=(1, MOST_SAMPLES)).problems()) == []


@pytest.mark.parametrize("drive", [DIFF, OMNI, CAR])
def test_who_is_there_stands(drive: dict[str, Any]) -> None:
    simulation, _, _ = planner("straight", to=(0.1, 0.0), **drive)
    simulation.state.command[0, 0] = [0.7, 0.3, 0.1]
    simulation.step()
    assert simulation.state.command[0, 0].tolist() == [0, 0, 0]
    assert command(scene([], **drive)).tolist() == [1, 0]
