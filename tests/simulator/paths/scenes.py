"""Scenes for the tests of paths, and what shapely says about them."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from irsim_gym.base.kernels.structs import Struct
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.paths.geodesic import distance_field, field_at, shortest_path
from irsim_gym.simulator.paths.grid import Grid, mark_blocked
from irsim_gym.simulator.paths.points import PointMap
from irsim_gym.simulator.paths.reachability import is_reachable
from tests.simulator.geometry.cell_maps import area as cell_area
from tests.simulator.geometry.cell_maps import cell_maps

Floats = NDArray[np.float64]


@dataclass
class Parts(Struct):
    """What paths read of model and state."""

    segments: Any
    segment_start: Any
    segment_count: Any
    discs: Any
    disc_start: Any
    disc_count: Any
    solid: Any
    pose: Any
    rigid: Any


def point(place: Any) -> tuple[float, float]:
    return float(place[0]), float(place[1])


@dataclass
class Scene:
    """Obstacles in a rectangle ``size`` x ``size`` [m] from the origin on."""

    size: float = 6.0
    parts: list[tuple[Floats, Floats, bool, Any]] = field(default_factory=list)
    cells: Any = None
    area: Any = None
    points: PointMap | None = None

    def polygon(self, vertices: Any) -> Scene:
        vertices = np.asarray(vertices, np.float64)
        rows = np.hstack([vertices, np.roll(vertices, -1, axis=0)])
        self.parts.append((rows, np.zeros((0, 3)), True, shapely.Polygon(vertices)))
        return self

    def chain(self, *vertices: tuple[float, float]) -> Scene:
        points = np.asarray(vertices, np.float64)
        rows = np.hstack([points[:-1], points[1:]])
        self.parts.append((rows, np.zeros((0, 3)), False, shapely.LineString(points)))
        return self

    def disc(self, x: float, y: float, radius: float) -> Scene:
        shape = shapely.Point(x, y).buffer(radius, quad_segs=64)
        self.parts.append((np.zeros((0, 4)), np.array([[x, y, radius]]), True, shape))
        return self

    def box(self, x0: float, y0: float, x1: float, y1: float) -> Scene:
        return self.polygon([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])

    def map(self, occupied: Any, radius: float = 0.0) -> Scene:
        """Stretch an occupancy map over the scene; with a radius there are discs in its cells."""
        columns, rows = np.shape(occupied)
        place = (0.0, 0.0, self.size / columns, self.size / rows)
        self.cells, self.area = cell_maps([occupied], *place, radius), cell_area(occupied, *place, radius)
        return self

    def walled(self) -> Scene:
        s = self.size
        return self.chain((0, 0), (s, 0), (s, s), (0, s), (0, 0))

    @property
    def obstacles(self) -> Obstacles:
        """All parts and the map, as one world."""
        segment_count = np.array([len(part[0]) for part in self.parts], np.int64)
        disc_count = np.array([len(part[1]) for part in self.parts], np.int64)
        world: Any = Parts(
            segments=np.vstack([np.zeros((0, 4)), *(part[0] for part in self.parts)])[None],
            segment_start=np.cumsum(segment_count) - segment_count,
            segment_count=segment_count[None],
            discs=np.vstack([np.zeros((0, 3)), *(part[1] for part in self.parts)])[None],
            disc_start=np.cumsum(disc_count) - disc_count,
            disc_count=disc_count[None],
            solid=np.array([part[2] for part in self.parts], np.bool_),
            pose=np.zeros((1, len(self.parts), 3)),
            rigid=np.ones(1, np.bool_),
        )
        return Obstacles(world, world, 0, np.ones(len(self.parts), np.bool_), self.cells, self.points)

    @property
    def shape(self) -> Any:
        return shapely.union_all([part[3] for part in self.parts] + ([] if self.area is None else [self.area]))

    def grid(self, cell: float) -> Grid:
        return Grid.over([0.0, 0.0, self.size, self.size], cell)

    def blocked(self, radius: float, cell: float) -> NDArray[np.uint8]:
        grid = self.grid(cell)
        found = grid.blocked()
        mark_blocked(self.obstacles, radius, grid, found)
        return found

    def reachable(self, radius: float, start: Any, goal: Any, cell: float = 0.1) -> bool:
        grid = self.grid(cell)
        return bool(is_reachable(self.obstacles, radius, point(start), point(goal), grid, grid.blocked(), grid.runs()))

    def path(self, radius: float, start: Any, goal: Any, cell: float = 0.05) -> Floats:
        grid = self.grid(cell)
        path = grid.path()
        count = shortest_path(self.obstacles, radius, point(start), point(goal), grid, grid.search(), path)
        return path[:count].copy()

    def length(self, radius: float, start: Any, goal: Any, cell: float = 0.05) -> float:
        path = self.path(radius, start, goal, cell)
        return float(np.sum(np.hypot(*np.diff(path, axis=0).T))) if len(path) else np.inf

    def field(self, radius: float, goal: Any, cell: float = 0.1) -> tuple[Floats, Any]:
        """Return the distance field and a function that reads it at a point."""
        grid = self.grid(cell)
        search = grid.search()
        distance_field(self.obstacles, radius, point(goal), grid, search)
        return search.field, lambda x, y: field_at(search.field, grid, float(x), float(y))

    def mirrored(self) -> Scene:
        """Return the scene seen in a mirror along x."""
        other = Scene(self.size)
        for rows, discs, solid, _ in self.parts:
            flipped = rows * [-1.0, 1.0, -1.0, 1.0] + [self.size, 0.0, self.size, 0.0]
            other.parts.append((flipped, discs * [-1.0, 1.0, 1.0] + [self.size, 0.0, 0.0], solid, None))
        return other


def random_scene(seed: int, n_parts: int = 7, *, walled: bool = True) -> Scene:
    rng = np.random.default_rng(seed)
    scene = Scene().walled() if walled else Scene()
    for k in range(n_parts):
        x, y = rng.uniform(0.5, 5.5, 2)
        if k % 3 == 0:
            scene.disc(x, y, rng.uniform(0.1, 0.6))
        elif k % 3 == 1:
            scene.chain(*[(x + dx, y + dy) for dx, dy in rng.uniform(-1.0, 1.0, (3, 2))])
        else:
            angles = 2.0 * np.pi * (np.arange(5) + rng.uniform(0.0, 0.8, 5)) / 5
            radii = rng.uniform(0.2, 0.9, 5)
            scene.polygon(np.stack([x + radii * np.cos(angles), y + radii * np.sin(angles)], axis=1))
    return scene


def random_points(seed: int, n: int) -> Floats:
    return np.random.default_rng(seed + 1_000_000).uniform(0.25, 5.75, (n, 2))


def grow(part: tuple[Floats, Floats, bool, Any], radius: float) -> Any:
    """Return the places of a disc's centre where it touches a part, with few and slightly cut corners."""
    if len(part[1]):
        x, y, own = part[1][0]
        return shapely.Point(x, y).buffer(own + radius, quad_segs=8)
    return part[3].buffer(radius, quad_segs=6)


def free_space(scene: Scene, radius: float) -> list[Any]:
    """Return the connected parts of where the centre of a disc may be, by shapely; a trifle too large at corners."""
    room = shapely.box(0.0, 0.0, scene.size, scene.size)
    grown = [grow(part, radius) for part in scene.parts]
    space = room.difference(shapely.union_all(grown))
    return [part for part in shapely.get_parts(space) if not part.is_empty]


def connected(scene: Scene, radius: float, start: Any, goal: Any) -> bool:
    """Return whether both points lie in one connected part of the free space."""
    ends = [shapely.Point(start), shapely.Point(goal)]
    return any(part.covers(ends[0]) and part.covers(ends[1]) for part in free_space(scene, radius))


def visibility_length(scene: Scene, radius: float, start: Any, goal: Any) -> float:
    """Return the length of the shortest path in shapely's free space: Dijkstra on its visibility graph."""
    ends = [shapely.Point(start), shapely.Point(goal)]
    parts = [part for part in free_space(scene, radius) if part.covers(ends[0]) and part.covers(ends[1])]
    if not parts:
        return np.inf
    nodes = np.vstack([start, goal, shapely.get_coordinates(parts[0])])
    n = len(nodes)
    i, j = np.triu_indices(n, 1)
    space = parts[0].buffer(1e-9)
    shapely.prepare(space)
    seen = shapely.covers(space, shapely.linestrings(np.stack([nodes[i], nodes[j]], axis=1)))
    costs = np.full((n, n), np.inf)
    costs[i[seen], j[seen]] = costs[j[seen], i[seen]] = np.hypot(*(nodes[i[seen]] - nodes[j[seen]]).T)
    best, heap = np.full(n, np.inf), [(0.0, 0)]
    best[0] = 0.0
    while heap:
        cost, here = heapq.heappop(heap)
        if here == 1:
            return cost
        for to in np.flatnonzero(cost + costs[here] < best):
            best[to] = cost + costs[here, to]
            heapq.heappush(heap, (float(best[to]), int(to)))
    return np.inf
