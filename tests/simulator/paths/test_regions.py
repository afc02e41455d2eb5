"""Ways that are looked up: the answers of ``is_reachable``, and those of a flood fill in plain Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from irsim_gym.simulator.paths.grid import CELL_MARGIN
from irsim_gym.simulator.paths.regions import LABELLED, SEEN, label_regions, of_slot, way_exists, way_tables
from tests.simulator.paths.scenes import Scene, point, random_points, random_scene

RADIUS, CELL = 0.2, 0.1


class Asked:
    """A scene that is asked again and again; its bodies stand at the origin, so that poses only name arrangements."""

    def __init__(self, scene: Scene, rigid: bool = True) -> None:
        self.scene, self.obstacles = scene, scene.obstacles
        self.obstacles.model.rigid[0] = rigid
        self.tables = of_slot(way_tables(scene.grid(CELL), 2, len(scene.parts)), 1)

    def __call__(self, start: Any, goal: Any, radius: float = RADIUS) -> bool:
        return bool(way_exists(self.obstacles, radius, point(start), point(goal), self.tables))

    @property
    def stage(self) -> float:
        return float(self.tables.known[0, 0])


@pytest.mark.parametrize("seed", range(12))
def test_every_answer_is_that_of_the_plain_search(seed: int) -> None:
    asked = Asked(random_scene(seed, 9, walled=seed % 2 == 0))
    if seed % 3 == 0:
        asked = Asked(asked.scene.map(np.random.default_rng(seed).random((12, 12)) < 0.15))
    points = random_points(seed, 40)
    found = [asked(a, b) for a, b in zip(points[::2], points[1::2], strict=True)]
    plain = [asked.scene.reachable(RADIUS, a, b, CELL) for a, b in zip(points[::2], points[1::2], strict=True)]
    assert found == plain
    assert asked.stage == LABELLED


def test_labels_are_those_of_a_flood_fill() -> None:
    for seed in (3, 5, 8):
        asked = Asked(random_scene(seed, 12, walled=True))
        labels = asked.tables.labels
        label_regions(asked.obstacles, RADIUS, asked.tables)
        rows, columns = labels.shape
        centres = np.meshgrid((np.arange(columns) + 0.5) * CELL, (np.arange(rows) + 0.5) * CELL)
        room = shapely.distance(shapely.points(*centres), asked.scene.shape)
        free = room > np.sqrt(RADIUS * RADIUS + 0.5 * CELL * CELL) + CELL_MARGIN
        # Discs are polygons in shapely: cells so near the edge that this decides may be either.
        sure = np.abs(room - np.sqrt(RADIUS * RADIUS + 0.5 * CELL * CELL)) > 1e-3
        assert np.array_equal((labels != 0)[sure], free[sure])
        wide = RADIUS + np.sqrt(0.5) * CELL
        sure = np.abs(room - wide) > 1e-3
        assert np.array_equal((labels > 0)[sure], (room > wide)[sure])
        partner: dict[int, int] = {}
        for number, cells in enumerate(flooded(labels != 0)):
            regions = {abs(int(labels[cell])) for cell in cells}
            assert len(regions) == 1
            assert partner.setdefault(regions.pop(), number) == number


def flooded(free: Any) -> list[list[tuple[int, int]]]:
    """Return the cells of each region, corners joined."""
    left = {(int(i), int(j)) for i, j in np.argwhere(free)}
    found = []
    while left:
        cells, open_cells = [], [left.pop()]
        while open_cells:
            i, j = open_cells.pop()
            cells.append((i, j))
            beside = {(i + a, j + b) for a in (-1, 0, 1) for b in (-1, 0, 1)} & left
            left -= beside
            open_cells.extend(beside)
        found.append(cells)
    return found


def test_bodies_that_moved_are_asked_about_anew() -> None:
    wall, gap = Scene().chain((3, -1), (3, 7)), Scene().chain((3, -1), (3, 2))
    asked = Asked(wall)
    ends = (1, 1), (5, 1)
    assert [asked(*ends) for _ in range(3)] == [False] * 3
    assert asked.stage == LABELLED
    asked.obstacles = gap.obstacles
    asked.obstacles.state.pose[0, 0, 1] = -4.0
    assert asked(*ends)
    assert asked.stage == SEEN
    assert asked(*ends)
    assert asked(*ends, radius=0.25)
    assert asked.stage == SEEN
    asked.obstacles.blocks[0] = False
    assert asked(*ends, radius=0.25)
    assert asked.stage == SEEN


def test_outlines_that_are_drawn_anew_are_never_remembered() -> None:
    asked = Asked(Scene().chain((3, -1), (3, 7)), rigid=False)
    assert not any(asked((1, 1), (5, 1)) for _ in range(3))
    asked.obstacles = Scene().chain((3, -1), (3, 2)).obstacles
    asked.obstacles.model.rigid[0] = False
    assert asked((1, 1), (5, 1))
    assert asked.stage not in (SEEN, LABELLED)
