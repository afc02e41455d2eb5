"""Keeps a map of what a robot's scans have shown, and finds the shortest way to its goal on it, with NumPy alone.

It finds what the observation ``way_on_seen_map`` finds in the simulator: quarters of cells are occupied, unknown space
counts as free, and cells in which the robot fits, but not at their centre, cost eight times as much.
"""

from __future__ import annotations

import math
from typing import Any, Tuple  # noqa: UP035  (Python 3.8 of ROS 1)

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Place = Tuple[float, float]  # noqa: UP006
FREE, TIGHT, BLOCKED = 0, 1, 2
"""Levels of a cell."""
STRAIGHT, ACROSS, FACTOR = 5, 7, 8
"""Costs of a straight and of a diagonal step, and the factor of a step from a tight cell."""
NEIGHBOURS = ((0, 1, 5), (0, -1, 5), (1, 0, 5), (-1, 0, 5), (1, 1, 7), (1, -1, 7), (-1, 1, 7), (-1, -1, 7))
"""Rows and columns to a cell's neighbours, and costs; of equally short ways, the one counts whose steps come first."""
NEAR, EDGE = 15, 1e-6
"""How far a free cell is looked for [cells]; how far inside the upper and right edge beams are cut [quarters]."""


class SeenMap:
    """The map of one robot, by ``seen_map`` and ``scan`` of contract.json."""

    def __init__(self, contract: dict[str, Any]) -> None:
        form, scan = contract["seen_map"], contract["scan"]
        (self.x, self.y), self.cell = map(float, form["origin"]), float(form["cell"])
        self.rows, self.columns, self.every, self.frees = (int(form[k]) for k in ("rows", "columns", "every", "frees"))
        self.least, self.most = np.float32(scan["range_min"]), np.float32(scan["range_max"])
        self.mount = scan["mount"]
        angles = scan["first"] + scan["step"] * np.arange(scan["beams"]) + self.mount[2]
        self.beams = np.stack([np.cos(angles), np.sin(angles)])
        self.near, self.near_levels = _surroundings(form["inflation"] / self.cell)
        # How far on a neighbour is among all cells, in all, by its row and by its column; the cost of the step.
        self.steps = [(i * self.columns + j, i * self.columns, j, cost) for i, j, cost in NEIGHBOURS]
        # More than any way costs, and as much as a step to a blocked cell; the sum of a line of steps has to fit.
        is_small = self.rows * self.columns <= 2**14 and max(self.rows, self.columns) < 2**10
        self.never, self.kind = (2**20, "int32") if is_small else (2**30, "int64")
        self.forget()

    def forget(self) -> None:
        """Begin with an empty map."""
        self.n_steps, self.occupied = 0, np.zeros((2 * self.rows, 2 * self.columns), np.bool_)
        self._narrow(*np.nonzero(self.occupied), anew=True)

    def fault(self, *places: Array) -> str:
        """Return "" if places [m] lie on the map, else that they do not."""
        for x, y in [((place[0] - self.x) / self.cell, (place[1] - self.y) / self.cell) for place in places]:
            if not (1.0 <= x <= self.columns - 1.0 and 1.0 <= y <= self.rows - 1.0):
                return "the robot or its goal is off the map: see seen_map in the contract"
        return ""

    def way(self, ranges: Array, pose: Array, goal: Array) -> Array:
        """Take a scan, and return where to go straight, and how far it is from there to the goal: x, y, length [m].

        Without a way, the place is the goal, and the length is infinite.

        Args:
            ranges: The scan as the scanner reports it [m], see REP 117, ``(n_beams,)``, float32.
            pose: The robot's pose [m, m, rad].
            goal: Its goal, x and y [m].
        """
        if self.n_steps % self.every == 0:
            self._add(ranges, pose)
        self.n_steps += 1
        here, there = (float(pose[0]), float(pose[1])), (float(goal[0]), float(goal[1]))
        if self._is_clear(here, there):
            return np.array([*there, 0.0])
        cells = self._shortest(here, there)
        if not cells:
            return np.array([*there, np.inf])
        last = self._last_in_sight(here, cells)
        length = self.costs[last] * (self.cell / STRAIGHT)
        return np.array([*(self._centre(last) if length > 0.0 else there), length])

    def _add(self, ranges: Array, pose: Array) -> None:
        """Mark the quarters of cells in which beams end, and free those that beams have passed."""
        scale, heading = 1.0 / self.cell, float(pose[2])
        cosine, sine = scale * math.cos(heading), scale * math.sin(heading)
        eye_x = scale * (pose[0] - self.x) + cosine * self.mount[0] - sine * self.mount[1]
        eye_y = scale * (pose[1] - self.y) + sine * self.mount[0] + cosine * self.mount[1]

        def ends(lengths: Array, beams: Array) -> tuple[Array, Array]:
            ahead, left = lengths.astype(np.float64) * beams
            return eye_x + cosine * ahead - sine * left, eye_y + sine * ahead + cosine * left

        doubted = np.zeros_like(self.occupied)
        if self.frees and 0.0 <= eye_x < self.columns and 0.0 <= eye_y < self.rows:
            clean = np.clip(np.where(np.isnan(ranges), self.most, ranges), self.least, self.most)
            beside = np.pad(clean, 1, "edge")
            # Alone, a beam would free the quarters along a wall that it grazes.
            short = np.minimum(clean, np.minimum(beside[:-2], beside[2:]))
            valid = short > self.least
            x, y = ends(short[valid], self.beams[:, valid])
            hits = (short[valid] < self.most) & self._inside(x, y)
            size = np.array([[2 * self.columns], [2 * self.rows]]) - EDGE
            doubted.flat[_passed(np.array([2.0 * eye_x, 2.0 * eye_y]), 2.0 * np.stack([x, y]), size, hits)] = True
            doubted &= self.occupied
            self.occupied[doubted] = False
        hits = (self.least < ranges) & (ranges < self.most)
        x, y = ends(ranges[hits], self.beams[:, hits])
        inside = self._inside(x, y)
        rows, columns = (2.0 * y[inside]).astype(np.int64), (2.0 * x[inside]).astype(np.int64)
        fresh = ~self.occupied[rows, columns]
        self.occupied[rows, columns] = True
        if (doubted & ~self.occupied).any():
            self._narrow(*np.nonzero(self.occupied), anew=True)
        elif fresh.any():
            self._narrow(rows[fresh], columns[fresh])

    def _inside(self, x: Array, y: Array) -> Array:
        return np.asarray((x >= 0.0) & (x < self.columns) & (y >= 0.0) & (y < self.rows))

    def _narrow(self, rows: Array, columns: Array, *, anew: bool = False) -> None:
        """Write which cells are blocked or tight because of occupied quarters; ``anew``: of these alone."""
        if anew:
            self.target, self.costs = (math.nan, math.nan), [0]
            # One row more, and a cell: lines of cells of several lengths fill the array, see ``_lines``.
            self.flat = np.full((self.rows + 1) * self.columns + 1, BLOCKED, np.uint8)
            self.levels = self.flat[: self.rows * self.columns].reshape(self.rows, self.columns)
            self.levels[1:-1, 1:-1] = FREE
        # Cells beyond the border become those at the border, which are blocked already.
        i = np.minimum(np.maximum((rows >> 1)[:, None] + self.near[0], 0), self.rows - 1)
        j = np.minimum(np.maximum((columns >> 1)[:, None] + self.near[1], 0), self.columns - 1)
        cells, levels = i * self.columns + j, self.near_levels[2 * (rows & 1) + (columns & 1)]
        for level in (TIGHT, BLOCKED):
            some = cells[levels == level]
            self.flat[some] = np.maximum(self.flat[some], level)
        self.walls = self.levels.tobytes()

    def _centre(self, cell: int) -> Place:
        row, column = divmod(cell, self.columns)
        return self.x + (column + 0.5) * self.cell, self.y + (row + 0.5) * self.cell

    def _is_clear(self, here: Place, there: Place) -> bool:
        """Return whether all points at every half cell between two places [m] are free.

        Tight cells count as free up to the first one that is free. Both ends are left out.
        """
        dx, dy = there[0] - here[0], there[1] - here[1]
        parts = math.ceil(2.0 * math.sqrt(dx * dx + dy * dy) / self.cell)
        share = np.arange(1, parts)
        columns = ((here[0] + dx * share / parts - self.x) / self.cell).astype(np.int64)
        rows = ((here[1] + dy * share / parts - self.y) / self.cell).astype(np.int64)
        # Points off the map read other cells; but the border, which every line to such a point crosses, is blocked.
        states = self.flat.take(rows * self.columns + columns, mode="clip").tobytes()
        return BLOCKED not in states and TIGHT not in states.lstrip(bytes([TIGHT]))

    def _last_in_sight(self, here: Place, cells: list[int]) -> int:
        """Return a cell of a way, as far along it as can be reached straight from a place [m]."""
        near, far, step = min(2, len(cells) - 1), len(cells), 2
        while near + step < len(cells):
            if not self._is_clear(here, self._centre(cells[near + step])):
                far = near + step
                break
            near, step = near + step, 2 * step
        while far - near > 1:
            middle = (near + far) // 2
            if self._is_clear(here, self._centre(cells[middle])):
                near = middle
            else:
                far = middle
        return cells[near]

    def _shortest(self, here: Place, goal: Place) -> list[int]:
        """Return the cells of the shortest way from a place to the goal [m]; none without a way."""
        start = self._free_cell(here)
        if start < 0:
            return []
        if goal != self.target:
            self.target, self.costs = goal, self._costs_to(goal)
        cells = self._followed(start)
        # Costs only rise as more is seen: a way that the known ones explain is the shortest, and none stays none.
        if not cells and self.costs[start] < self.never:
            self.costs = self._costs_to(goal)
            cells = self._followed(start)
        return cells

    def _free_cell(self, place: Place) -> int:
        """Return the cell at a place [m], or the nearest one around that is not blocked; -1 without one."""
        column, row = (place[0] - self.x) / self.cell - 0.5, (place[1] - self.y) / self.cell - 0.5
        i, j = math.ceil(row - 0.5), math.ceil(column - 0.5)
        if 0 <= i < self.rows and 0 <= j < self.columns and self.levels[i, j] != BLOCKED:
            return i * self.columns + j
        low, left = max(i - NEAR, 0), max(j - NEAR, 0)
        around = self.levels[low : max(i + NEAR + 1, 0), left : max(j + NEAR + 1, 0)]
        rows, columns = np.nonzero(around != BLOCKED)
        if not len(rows):
            return -1
        up, aside = rows + low - row, columns + left - column
        best = (up * up + aside * aside).argmin()
        return int((rows[best] + low) * self.columns + columns[best] + left)

    def _followed(self, start: int) -> list[int]:
        """Return the cells that the costs lead through from a cell; none where they do not explain a step."""
        costs, walls, here, cells = self.costs, self.walls, start, [start]
        while 0 < costs[here] < self.never:
            cost, factor = costs[here], FACTOR if walls[here] == TIGHT else 1
            for step, along, aside, length in self.steps:
                there = here + step
                # A blocked cell can only be the end of a way.
                if costs[there] + length * factor > cost or (walls[there] == BLOCKED and costs[there] > 0):
                    continue
                if length == STRAIGHT or not (walls[here + along] == BLOCKED or walls[here + aside] == BLOCKED):
                    break
            else:
                return []
            here = there
            cells.append(here)
        return cells if costs[here] == 0 else []

    def _costs_to(self, goal: Place) -> list[int]:
        """Return what the shortest way from each cell to the goal [m] costs, at least ``never`` where there is none.

        Costs spread along whole diagonals, rows and columns at once, until none is lowered any more.
        """
        column = min(max(math.floor((goal[0] - self.x) / self.cell), 1), self.columns - 2)
        row = min(max(math.floor((goal[1] - self.y) / self.cell), 1), self.rows - 2)
        costs, before = np.full(len(self.flat), self.never, self.kind), -1
        costs[row * self.columns + column] = 0
        lines = self._lines(costs)
        while before != (total := int(costs.sum())):
            before = total
            for part, on, back in lines:
                np.minimum(part, np.minimum.accumulate(part - on) + on, out=part)
                np.minimum(part, np.minimum.accumulate((part + back)[::-1])[::-1] - back, out=part)
            np.minimum(costs, self.never, out=costs)
        return list(costs[: self.levels.size].tolist())

    def _lines(self, costs: Array) -> list[tuple[Array, Array, Array]]:
        """Return costs by diagonals, columns and rows, which lie along the first axis, and sums of the steps on them.

        In rows of w + 1 and w - 1 cells, the cells of a diagonal of a map of w columns lie below each other. Sums are
        those of the steps up to each cell, first of ways that come from above, then of those from below.
        """
        steps = [np.array([step, FACTOR * step, self.never], self.kind) for step in (STRAIGHT, ACROSS, 0)]
        (straight, across, blocked), wide, lines = (costs_of.take(self.flat) for costs_of in steps), self.columns, []
        for side in (1, -1):
            # No cutting of corners: both cells beside a diagonal step must not be blocked.
            on = np.maximum(across, np.maximum(_moved(blocked, wide), _moved(blocked, side)))
            back = np.maximum(across, np.maximum(_moved(blocked, -wide), _moved(blocked, -side)))
            lines.append([_rows(values, wide + side) for values in (costs, on, back)])
        columns = [_rows(values, wide) for values in (costs, straight, straight)]
        lines += [columns, [part.T for part in columns]]
        return [(part, on.cumsum(0, self.kind), back.cumsum(0, self.kind) - back) for part, on, back in lines]


def _rows(values: Array, size: int) -> Array:
    return values[: len(values) // size * size].reshape(-1, size)


def _moved(values: Array, by: int) -> Array:
    """Return what ``np.roll`` does, in a third of its time."""
    return np.concatenate((values[-by:], values[:-by]))


def _surroundings(reach: float) -> tuple[Array, Array]:
    """Return the cells around an occupied quarter, and their levels for a robot of a radius [cells].

    Returns:
        Rows and columns from the quarter's cell on, ``(2, n)``, and levels by the quarter's number, ``(4, n)``.
    """
    near, k = np.arange(-math.ceil(reach) - 1, math.ceil(reach) + 2), np.arange(4)[:, None]
    rows, columns = (part.reshape(-1) for part in np.meshgrid(near, near, indexing="ij"))
    dy, dx = np.abs(rows + 0.25 - 0.5 * (k >> 1)), np.abs(columns + 0.25 - 0.5 * (k & 1))
    levels = np.where(dx * dx + dy * dy < reach * reach, TIGHT, FREE).astype(np.uint8)
    # The farthest corner of the cell is within reach: so is every place in it.
    levels[(dx + 0.5) * (dx + 0.5) + (dy + 0.5) * (dy + 0.5) <= reach * reach] = BLOCKED
    levels[:, (rows == 0) & (columns == 0)] = BLOCKED
    is_near = levels.any(axis=0)
    return np.stack([rows, columns])[:, is_near], levels[:, is_near]


def _passed(eye: Array, ends: Array, size: Array, hits: Array) -> Array:
    """Return the quarters that beams pass, by their places in a flat map, without those in which they hit.

    Args:
        eye: Where they begin, x and y [quarters].
        ends: Where they end, ``(2, n_beams)``.
        size: Of the map, ``(2, 1)``.
        hits: Whether they hit something there.
    """
    far = ends - eye[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where((ends >= 0.0) & (ends < size), 1.0, (np.where(far > 0.0, size, 0.0) - eye[:, None]) / far)
    far = far * np.maximum(part.min(axis=0), 0.0)
    # Along the axis on which a beam goes farther, it passes the cells on both sides of each boundary.
    every, main = np.arange(far.shape[1]), (np.abs(far[1]) > np.abs(far[0])).astype(np.int64)
    wide = math.ceil(size[0, 0])  # quarters in a row of the map
    major, minor, ahead = eye[main], eye[1 - main], np.where(far[main, every] >= 0.0, 1, -1)
    long, side = far[main, every], far[1 - main, every]
    slope = np.divide(side, long, out=np.zeros_like(side), where=long != 0.0)
    begin, end, last = major.astype(np.int64), (major + long).astype(np.int64), (minor + side).astype(np.int64)
    meets, count = minor + (begin + (ahead > 0) - major) * slope, np.abs(end - begin)[:, None]
    n = np.arange(count.max(initial=0))
    across = (meets[:, None] + n * (ahead * slope)[:, None]).astype(np.int64)
    along_step, across_step = np.where(main == 1, wide, 1), np.where(main == 1, 1, wide)
    cells = (begin[:, None] + n * ahead[:, None]) * along_step[:, None] + across * across_step[:, None]
    passes = n < count
    hit_there = hits[:, None] & (n == count - 1) & (across == last[:, None])
    beyond = (cells + (ahead * along_step)[:, None])[passes & ~hit_there]
    return np.concatenate([(end * along_step + last * across_step)[~hits], cells[passes], beyond])
