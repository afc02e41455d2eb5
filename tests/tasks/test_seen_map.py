"""seen_map_image and way_on_seen_map, against maps that NumPy makes from the scans in another way."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cell_costs import reference_costs
from task_tools import BALL, ROBOT, drive, play

from irsim_gym.errors import ScenarioError
from irsim_gym.simulator.cell_paths.scan_marks import OCCUPIED, PASSED
from irsim_gym.simulator.cell_paths.wavefront import TIGHT
from irsim_gym.simulator.paths.grid import BLOCKED, FREE, Grid
from irsim_gym.tasks import Episodes

CELL = 0.2
PICTURE = {"name": "seen_map_image", "cell": CELL, "every": 1, "pixels": 40, "metres": 9.0, "goal_channel": False}
WAY = {"name": "way_on_seen_map", "cell": CELL, "every": 2}
LIDAR = {"name": "lidar2d", "number": 60, "angle_range": 5.5, "range_max": 4, "offset": [0.05, -0.02, 0.3]}
START = [2.03, 4.91, 0.1]
TRAP: list[dict[str, Any]] = [
    {"shape": {"name": "linestring", "vertices": [[4, 3.1], [6.2, 3.1], [6.2, 6.9], [4, 6.9]]}},
    {"shape": {"name": "circle", "radius": 0.6}, "state": [3.1, 7.9]},
    {"shape": {"name": "rectangle", "length": 1.1, "width": 0.7}, "state": [7.6, 2.2, 0.5]},
]


def robot(**more: Any) -> dict[str, Any]:
    return {**ROBOT, "state": START, "goal": [9.1, 5.2], "sensors": [LIDAR], **more}


def watching(*observations: Any, robots: Any = None, obstacle: Any = None, **more: Any) -> Episodes:
    """Return a trap of walls with a robot that observes these, or robots."""
    found = TRAP if obstacle is None else obstacle
    return play(robots or [robot()], found, {"name": "blank", "observations": list(observations)}, **more)


def arrays(episodes: Episodes, index: int = 0) -> Any:
    return episodes.terms["observations"][index].arrays


def wander(episodes: Episodes, steps: int, seed: int = 0) -> None:
    """Drive with actions that change every ten steps, the same in all worlds."""
    rng = np.random.default_rng(seed)
    for n in range(steps):
        if n % 10 == 0:
            action = rng.uniform([0.2, -0.8], [1.0, 0.8])
        drive(episodes, *action)


def states(cells: Any) -> Any:
    """Return what is known of cells: 0 nothing, 1 passed, 2 occupied."""
    return np.where(cells & OCCUPIED != 0, 2, (cells & PASSED != 0).astype(np.uint8))


def quarters(cells: Any) -> Any:
    """Return which quarters of cells are occupied, in twice as many rows and columns."""
    found = np.zeros((2 * cells.shape[0], 2 * cells.shape[1]), np.bool_)
    for bit, (row, column) in enumerate([(0, 0), (0, 1), (1, 0), (1, 1)]):
        found[row::2, column::2] = cells & (1 << bit) != 0
    return found


def place(grid: Any, x: float, y: float) -> tuple[int, int]:
    """Return row and column of the cell at a point."""
    return int(np.floor((y - grid.origin_y) / grid.cell)), int(np.floor((x - grid.origin_x) / grid.cell))


class Reference:
    """A map made from scans, beam by beam: lists of cells from sorted crossings of the lines between cells.

    If bodies move, beams clear cells as far as the beams beside them reach, too.

    Its cells are half as wide as those of the map.
    """

    def __init__(self, episodes: Episodes, grid: Any, *, moving: bool = False, agent: int = 0) -> None:
        self.grid = Grid(grid.origin_x, grid.origin_y, 0.5 * grid.cell, 2 * grid.columns, 2 * grid.rows)
        self.moving, self.agent = moving, agent
        self.cells = np.zeros((self.grid.rows, self.grid.columns), np.uint8)
        self.group, self.member = episodes.simulation.scan(episodes.task.agents[agent])  # type: ignore[misc]

    def set(self, places: Any, value: int, old: tuple[int, ...]) -> None:
        for row, column in places:
            if 0 <= row < self.grid.rows and 0 <= column < self.grid.columns and self.cells[row, column] in old:
                self.cells[row, column] = value

    def passed(self, a: Any, b: Any) -> list[tuple[int, int]]:
        """Return the cells in which a part of the way from a to b lies."""
        parts = [0.0, 1.0]
        for axis, origin in enumerate((self.grid.origin_x, self.grid.origin_y)):
            low, high = sorted((a[axis], b[axis]))
            first, last = (int(np.floor((value - origin) / self.grid.cell)) for value in (low, high))
            for line in range(first + 1, last + 1):
                parts.append((origin + line * self.grid.cell - a[axis]) / (b[axis] - a[axis]))
        parts.sort()
        middles = [0.5 * (p + q) for p, q in itertools.pairwise(parts)]
        return [place(self.grid, *(a + m * (b - a))) for m in middles]

    def add(self, episodes: Episodes, w: int = 0) -> None:
        """Take in the present scan: first what beams pass, then what they hit."""
        options = self.group.options[self.member]
        x, y, heading = episodes.simulation.state.pose[w, episodes.task.agents[self.agent]]
        turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
        eye = np.array([x, y]) + turn @ np.array(options.offset[:2])
        angles = np.linspace(-0.5 * LIDAR["angle_range"], 0.5 * LIDAR["angle_range"], LIDAR["number"])
        readings, hits = self.group.arrays["ranges"][w, self.member], []
        for i, angle in enumerate(angles):
            direction = turn @ [np.cos(angle + options.offset[2]), np.sin(angle + options.offset[2])]
            end = eye + float(readings[i]) * direction
            if readings[i] < options.range_max:
                hits.append(place(self.grid, *end))
            self.set(self.before(eye, end, readings[i] < options.range_max), 1, (0, 1))
            if self.moving:
                least = readings[max(i - 1, 0) : i + 2].min()
                self.set(self.before(eye, eye + float(least) * direction, least < options.range_max), 1, (2,))
        self.set(hits, 2, (0, 1, 2))

    def before(self, eye: Any, end: Any, is_hit: bool) -> list[tuple[int, int]]:
        """Return the cells that a beam passes, without the one that it hits."""
        return [cell for cell in self.passed(eye, end) if not (is_hit and cell == place(self.grid, *end))]


def check(cells: Any, reference: Reference) -> None:
    """Compare a map with the reference: a cell is occupied if one of its quarters is, and passed if one of them is."""
    np.testing.assert_array_equal(quarters(cells), reference.cells == 2)
    parts = np.stack([reference.cells[i::2, j::2] for i in (0, 1) for j in (0, 1)])
    np.testing.assert_array_equal(states(cells), parts.max(axis=0))


NOISY = {"kinematics": {**ROBOT["kinematics"], "noise": True}, "sensors": [{**LIDAR, "noise": True, "std": 0.1}]}


@pytest.mark.parametrize("more", [{}, NOISY])
def test_cells_are_those_of_a_map_made_beam_by_beam(more: dict[str, Any]) -> None:
    episodes = watching(PICTURE, robots=[robot(**more)])
    seen = arrays(episodes).seen
    reference = Reference(episodes, seen.grid)
    for n in range(60):
        reference.add(episodes)
        check(seen.cells[0, 0], reference)
        wander(episodes, 1, seed=n // 8)
    assert [(states(seen.cells[0, 0]) == value).sum() > 50 for value in (0, 1, 2)] == [True] * 3


def test_what_moves_away_is_cleared_and_what_stands_stays() -> None:
    mover = {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.3}, "state": [4.03, 5.5]}
    mover |= {"goal": [4.03, 9], "behavior": {"name": "dash"}, "vel_max": [1, 1], "vel_min": [-1, -1]}
    episodes = watching(PICTURE, WAY, obstacle=[mover, *TRAP[1:]])
    seen, ways = arrays(episodes).seen, arrays(episodes, 1)
    reference = Reference(episodes, seen.grid, moving=True)
    row, column = place(reference.grid, 3.74, 5.5)  # its side that faces the robot
    ahead = []
    for _ in range(30):
        reference.add(episodes)
        check(seen.cells[0, 0], reference)
        ahead.append(quarters(seen.cells[0, 0])[row - 2 : row + 4, column : column + 4].any())
        drive(episodes, -1, 0)
    assert ahead[0]
    assert not ahead[-1]
    drive(episodes, -1, 0)
    expected = levels_of(quarters(ways.seen.cells[0, 0]), 0.2 / CELL)
    np.testing.assert_array_equal(ways.levels[0, 0], expected)


def test_beams_along_a_wall_do_not_clear_it() -> None:
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 2}, "state": [7.5, 7]}
    mover = {**BALL, "state": [1, 1], "goal": [2, 1], "kinematics": {"name": "omni"}, "behavior": {"name": "dash"}}
    round_scan = {"name": "lidar2d", "number": 200, "angle_range": 6.2832, "range_max": 6}
    viewer = {"state": [5, 5.4, 0], "kinematics": {"name": "omni"}, "sensors": [round_scan]}
    episodes = watching({**PICTURE, "cell": 0.17}, robots=[robot(**viewer)], obstacle=[mover, wall])
    seen = arrays(episodes).seen
    rows, columns = zip(*(place(seen.grid, 7.0, y) for y in np.arange(6.1, 7.9, 0.05)), strict=True)
    face = list(rows), list(columns)
    occupied = []
    for _ in range(25):
        occupied.append((seen.cells[0, 0][face] & OCCUPIED != 0).sum())
        drive(episodes, 1, 0.0)  # below the wall, until its left side is straight ahead
    assert episodes.simulation.state.pose[0, 0, 0] > 7.0
    assert min(occupied[10:]) >= max(occupied) - 6


@pytest.mark.parametrize("rotated", [True, False])
def test_the_picture_shows_the_cell_of_each_pixel(rotated: bool) -> None:
    episodes = watching({**PICTURE, "rotated": rotated})
    wander(episodes, 40)
    seen, (x, y, heading) = arrays(episodes).seen, episodes.simulation.state.pose[0, 0]
    picture = episodes.view.images["seen_map_image"][0, 0]
    assert picture.shape == (40, 40, 1)
    known, up = states(seen.cells[0, 0]), heading if rotated else 0.5 * np.pi
    for i in range(40):
        for j in range(40):
            ahead, left = (19.5 - i) * 9 / 40, (19.5 - j) * 9 / 40
            row, column = place(
                seen.grid, x + ahead * np.cos(up) - left * np.sin(up), y + ahead * np.sin(up) + left * np.cos(up)
            )
            is_inside = 0 <= row < seen.grid.rows and 0 <= column < seen.grid.columns
            state = known[row, column] if is_inside else 0
            assert picture[i, j, 0] == {0: 127, 1: 0, 2: 255}[int(state)]


def test_the_goal_has_a_channel_of_its_own() -> None:
    episodes = watching({**PICTURE, "goal_channel": True})
    picture = episodes.view.images["seen_map_image"][0, 0]
    assert picture.shape == (40, 40, 2)
    assert picture[..., 1].max() == 255
    assert picture[20:, :, 1].max() == 0  # it lies ahead


def levels_of(occupied: Any, reach: float) -> Any:
    """Return where a disc [cells] fits, from the quarters that are occupied."""
    rows, columns = occupied.shape[0] // 2, occupied.shape[1] // 2
    levels = np.full((rows, columns), FREE)
    middle_y, middle_x = np.indices((rows, columns)) + 0.5
    for row, column in np.argwhere(occupied).tolist():
        dx, dy = np.abs(middle_x - (column + 0.5) / 2), np.abs(middle_y - (row + 0.5) / 2)
        levels[(np.hypot(dx, dy) < reach) & (levels == FREE)] = TIGHT
        levels[np.hypot(dx + 0.5, dy + 0.5) <= reach] = BLOCKED
        levels[row // 2, column // 2] = BLOCKED
    levels[[0, -1]], levels[:, [0, -1]] = BLOCKED, BLOCKED
    return levels


def is_straight(levels: Any, place: Any, goal: Any, grid: Any) -> bool:
    """Return whether points at every half cell of the way lie in free cells, tight ones at its beginning aside."""
    parts = int(np.ceil(2 * np.hypot(*(goal - place)) / CELL))
    ways = place + np.outer(np.arange(1, parts) / parts, goal - place)
    rows = np.floor((ways[:, 1] - grid.origin_y) / grid.cell).astype(int)
    columns = np.floor((ways[:, 0] - grid.origin_x) / grid.cell).astype(int)
    found = levels[rows, columns].tolist()
    first = found.index(FREE) if FREE in found else len(found)
    return BLOCKED not in found[:first] and set(found[first:]) <= {FREE}


def test_the_way_is_the_shortest_one_on_the_cells_that_were_seen() -> None:
    episodes = watching(WAY)
    ways, grid, kinds = arrays(episodes), arrays(episodes).seen.grid, set()
    goal = np.array([9.1, 5.2])
    for n in range(70):
        (x, y, heading), (cosine, sine, length) = episodes.simulation.state.pose[0, 0], episodes.view.observation[0, 0]
        levels = levels_of(quarters(ways.seen.cells[0, 0]), 0.2 / CELL)
        np.testing.assert_array_equal(ways.levels[0, 0], levels)
        straight, length = np.hypot(*(goal - [x, y])), float(length) * np.hypot(10, 10)
        angle = heading + np.arctan2(sine, cosine)
        kinds.add(is_clear := is_straight(levels, np.array([x, y]), goal, grid))
        if is_clear:
            assert length == pytest.approx(straight, abs=1e-5)
            assert np.cos(angle - np.arctan2(goal[1] - y, goal[0] - x)) == pytest.approx(1.0, abs=1e-6)
        else:
            row, column = (int(np.floor((v - o) / CELL)) for v, o in ((y, grid.origin_y), (x, grid.origin_x)))
            source = int(np.floor((goal[1] - grid.origin_y) / CELL)) * grid.columns
            source += int(np.floor((goal[0] - grid.origin_x) / CELL))
            costs = reference_costs(levels, source)
            assert ways.least[0, 0, row, column] == costs[row, column]
            # Never shorter than straight; the first piece is straightened, the rest along cells.
            assert straight - 1e-6 <= length <= costs[row, column] * CELL / 5 + CELL
            # Where it points there is a cell whose cost makes up the length.
            away = np.arange(0.01, 8, 0.01)
            points = np.stack([x + away * np.cos(angle), y + away * np.sin(angle)], axis=1)
            cells = np.floor((points - [grid.origin_x, grid.origin_y]) / CELL).astype(int)
            inside = ((cells > 0) & (cells < [grid.columns - 1, grid.rows - 1])).all(axis=1)
            total = away[inside] + costs[cells[inside, 1], cells[inside, 0]] * CELL / 5
            assert np.abs(total - length).min() < 0.06
        drive(episodes, *((1.0, 0.2 * np.sin(n)) if n < 28 else (0.3, 0.8)))
    assert kinds == {True, False}


def test_the_way_out_of_a_trap_leads_back_first() -> None:
    episodes = watching(WAY)
    assert episodes.view.observation[0, 0, 2] * np.hypot(10, 10) < 7.5  # what is behind the wall ahead is unknown
    for _ in range(28):
        drive(episodes, 1.0, 0.0)
    x = episodes.simulation.state.pose[0, 0, 0]
    cosine, _, length = episodes.view.observation[0, 0]
    assert 4.6 < x < 5.4  # within the walls
    assert cosine < -0.2
    # Back to the wall's end, around it at 0.2 m and on: 2 * 0.9 m + 1.7 m to the corner, then 5.3 m or so.
    assert 8.0 < length * np.hypot(10, 10) < 11.0


def hidden_pair(*, moving: bool) -> list[Episodes]:
    """Return two worlds that differ only behind the wall: in one a disc is gone, another has moved.

    Args:
        moving: Whether these discs drift, and a ball rolls to and fro before the wall.
    """
    wall = {"shape": {"name": "linestring", "vertices": [[5, 2.5], [5, 7.5]]}}
    drifts = {"kinematics": {"name": "omni"}, "behavior": {"name": "dash"}, "vel_max": [0.02, 0.02]} if moving else {}
    discs = [
        {"shape": {"name": "circle", "radius": 0.4}, "state": [6.5, y], "goal": [7.5, 4.8], **drifts}
        for y in (5.0, 6.0, 6.6)
    ]
    ball = {**BALL, "state": [3.4, 3.2], "kinematics": {"name": "omni"}, "behavior": {"name": "dash"}, "goal": [3.4, 6]}
    seen = [wall, ball] if moving else [wall]
    both = [*seen, discs[0], discs[1]], [*seen, {**discs[2], "state": [7.4, 4.4]}]
    return [watching(PICTURE, WAY, obstacle=obstacle) for obstacle in both]


@pytest.mark.parametrize("moving", [False, True])
def test_nothing_shows_before_a_scan_has_shown_it(moving: bool) -> None:
    pair, differed, n_freed = hidden_pair(moving=moving), [], 0
    for _ in range(100):
        scans = [episodes.simulation.scan(0)[0].arrays["ranges"][0, 0].copy() for episodes in pair]  # type: ignore[index]
        differed.append(not np.array_equal(*scans))
        if not any(differed):
            np.testing.assert_array_equal(*[episodes.view.observation for episodes in pair])
            np.testing.assert_array_equal(*[episodes.view.images["seen_map_image"] for episodes in pair])
            n_freed += int(arrays(pair[0]).seen.n_freed[0, 0])
        for episodes in pair:
            drive(episodes, *((-1, -0.6) if len(differed) < 12 else (1, 0) if len(differed) < 57 else (1, 0.5)))
    assert differed.index(True) > 20
    assert (n_freed > 0) == moving
    assert (pair[0].view.observation != pair[1].view.observation).any()


def test_single_batch_and_shards_agree_and_other_worlds_are_left_alone() -> None:
    there = {"name": "random", "range_low": [1, 1, -3], "range_high": [9, 9, 3]}
    drawn = {key: value for key, value in robot(distribution=there).items() if key not in ("state", "goal")}
    batch, sharded = (watching(PICTURE, WAY, robots=[drawn], n_worlds=4, num_threads=n) for n in (1, 3))
    single = watching(PICTURE, WAY, robots=[drawn])
    single.begin(np.array([0]), np.array([2]))
    for n in range(24):
        for episodes in (batch, sharded, single):
            wander(episodes, 1, seed=n // 6)
        np.testing.assert_array_equal(batch.view.observation, sharded.view.observation)
        np.testing.assert_array_equal(single.view.observation[0], batch.view.observation[2])
    before = [arrays(batch).seen.cells.copy(), arrays(batch, 1).least.copy(), arrays(batch, 1).levels.copy()]
    batch.begin_next(np.array([1]))
    after = [arrays(batch).seen.cells, arrays(batch, 1).least, arrays(batch, 1).levels]
    for old, new in zip(before, after, strict=True):
        np.testing.assert_array_equal(old[[0, 2, 3]], new[[0, 2, 3]])
    fresh = watching(PICTURE, WAY, robots=[drawn])
    fresh.begin(np.array([0]), batch.state.level[1])
    np.testing.assert_array_equal(fresh.view.observation[0], batch.view.observation[1])
    np.testing.assert_array_equal(arrays(fresh).seen.cells[0], arrays(batch).seen.cells[1])


@pytest.mark.parametrize(
    "obstacle", [None, [{**BALL, "kinematics": {"name": "omni"}, "behavior": {"name": "dash"}, "goal": [5, 9]}]]
)
def test_observations_of_a_task_share_a_map_and_show_what_they_show_alone(obstacle: Any) -> None:
    found = [*TRAP, *(obstacle or [])]
    kinds = {"way_on_seen_map": {**WAY, "every": 1}, "seen_map_image": PICTURE}
    alone = {name: watching(kind, obstacle=found) for name, kind in kinds.items()}
    for names in itertools.permutations(kinds):
        together = watching(*(kinds[name] for name in names), obstacle=found)
        maps = [term.arrays.seen for term in together.terms["observations"]]
        assert maps[0] is maps[1]
        for n in range(24):
            for episodes in alone.values():
                if n == 0:
                    episodes.begin(np.array([0]), np.array([0]))
                drive(episodes, 1.0, 0.4 * np.sin(n))
            drive(together, 1.0, 0.4 * np.sin(n))
        rows = [alone[name].view.observation[0, 0] for name in names if name != "seen_map_image"]
        np.testing.assert_array_equal(together.view.observation[0, 0], np.concatenate(rows))
        pictures = [episodes.view.images["seen_map_image"] for episodes in (together, alone["seen_map_image"])]
        np.testing.assert_array_equal(*pictures)


def test_maps_of_other_cells_or_of_fewer_scans_are_not_shared() -> None:
    for other in ({**WAY, "every": 1, "cell": 2 * CELL}, {**WAY, "every": 2}):
        first, second = (term.arrays.seen for term in watching(other, PICTURE).terms["observations"])
        assert first is not second


def test_each_agent_of_a_team_has_a_map_of_its_own() -> None:
    robots = [robot(), robot(state=[8.03, 8.1, 2.0], goal=[2, 2])]
    episodes = watching(PICTURE, robots=robots, team=True)
    references = [Reference(episodes, arrays(episodes).seen.grid, moving=True, agent=a) for a in (0, 1)]
    for _ in range(20):
        for a, reference in enumerate(references):
            reference.add(episodes)
            check(arrays(episodes).seen.cells[0, a], reference)
        wander(episodes, 1)
    assert (references[0].cells != references[1].cells).any()


def test_a_goal_that_is_walled_in_has_no_way() -> None:
    box = {"shape": {"name": "linestring", "vertices": [[8, 4], [9.9, 4], [9.9, 6], [8, 6], [8, 4]]}}
    near = [{**LIDAR, "number": 400, "angle_range": 6.28, "range_max": 20}]
    inside = {"name": "blank", "observations": [WAY]}
    episodes = play([robot(state=[9.1, 5.0, 0.1], goal=[2.1, 5.2], sensors=near)], [box], inside)
    cosine, sine, length = episodes.view.observation[0, 0]
    assert length == 1.0
    assert np.arctan2(sine, cosine) == pytest.approx(np.arctan2(0.2, -7.0) - 0.1, abs=1e-5)


@pytest.mark.parametrize("name", ["seen_map_image", "way_on_seen_map"])
def test_a_robot_without_a_scanner_is_told(name: str) -> None:
    with pytest.raises(ScenarioError, match=r"observations\[0\].*'robot_0' has no range sensor: add one"):
        watching({"name": name}, robots=[robot(sensors=[])])


def short_run() -> Any:
    """Return the observations of a few steps."""
    episodes = watching({**WAY, "cell": 0.5}, {**PICTURE, "cell": 0.5})
    rows = []
    for _ in range(12):
        drive(episodes, 1.0, 0.1)
        image = episodes.view.images["seen_map_image"][0, 0, ::5, ::5, 0].reshape(-1)
        rows.append(np.concatenate([episodes.view.observation[0, 0], image]))
    return np.array(rows)


def test_compiled_kernels_do_what_plain_python_does(tmp_path: Path) -> None:
    file = tmp_path / "plain.npy"
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, __file__, str(file)], env=plain, check=True, timeout=120)
    np.testing.assert_array_equal(short_run(), np.load(file))


if __name__ == "__main__":
    np.save(sys.argv[1], short_run())
