"""Outcomes counted anew: from poses and outlines, with shapely, without the simulator's own contacts and arrivals."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from shapely import STRtree, affinity, box
from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from irsim_gym.bodies.shapes.circle import Circle
from irsim_gym.bodies.shapes.linestring import Linestring
from irsim_gym.bodies.shapes.rectangle import Rectangle
from irsim_gym.tasks import Episodes

Parts = list[tuple[BaseGeometry, float]]
"""What a body consists of: shapes, each grown by a radius [m]."""


def robot_parts(shape: Any, pose: NDArray[np.float64]) -> Parts:
    """Return where a robot of the file's own shape is, from its pose."""
    x, y, heading = (float(value) for value in pose)
    if isinstance(shape, Circle):
        return [(Point(x, y), shape.radius)]
    assert isinstance(shape, Rectangle)
    ahead = (shape.wheelbase or 0.0) / 2.0
    right, top = shape.length / 2.0, shape.width / 2.0
    outline = box(ahead - right, -top, ahead + right, top)
    return [(affinity.translate(affinity.rotate(outline, heading, (0.0, 0.0), use_radians=True), x, y), 0.0)]


def touch(one: Parts, other: Parts) -> bool:
    """Return whether two bodies have a point in common."""
    return any(a.distance(b) <= grown + by for a, grown in one for b, by in other)


def is_there(spec: Any, pose: NDArray[np.float64], goal: NDArray[np.float64]) -> bool:
    """Return whether a body is at its goal, with its heading where that counts (radians like metres)."""
    gap = goal - pose
    turn = math.remainder(float(gap[2]), 2.0 * math.pi) if spec.arrive_mode == "state" else 0.0
    return math.hypot(gap[0], gap[1], turn) < spec.goal_threshold


@dataclass
class Cells:
    """The map of a level: its occupied cells, or the discs that stand for them."""

    tree: STRtree
    radius: float

    @classmethod
    def of(cls, cells: Any, w: int) -> Cells:
        """Read the map of world w."""
        row = w if w < len(cells.n_boxes) else 0
        shapes = []
        for i, j in np.argwhere(cells.squares[row, 0] == 0).tolist():
            left, low = cells.x + i * cells.width, cells.y + j * cells.height
            if cells.radius:
                shapes.append(Point(left + cells.width / 2.0, low + cells.height / 2.0))
            else:
                shapes.append(box(left, low, left + cells.width, low + cells.height))
        return cls(STRtree(shapes), float(cells.radius))

    def touches(self, parts: Parts) -> bool:
        """Return whether a body touches the map."""
        return any(
            self.tree.query(shape, predicate="dwithin", distance=radius + self.radius).size for shape, radius in parts
        )


@dataclass
class Recount:
    """Notes how episodes end, by its own reckoning: a `Watcher` of evaluations.

    Attributes:
        arrived: Whether the agents arrived before they touched anything, by level's place, ``(n_agents,)``.
    """

    arrived: dict[int, NDArray[np.bool_]] = field(default_factory=dict)
    _over: dict[int, NDArray[np.bool_]] = field(default_factory=dict)
    _won: dict[int, NDArray[np.bool_]] = field(default_factory=dict)
    _cells: dict[int, Cells] = field(default_factory=dict)

    def began(self, episodes: Episodes, worlds: Any, indices: Any) -> None:
        """Begin to count in worlds."""
        cells = episodes.simulation.model.cells
        for w, index in zip(worlds.tolist(), indices.tolist(), strict=True):
            self._over[w], self._won[w] = np.zeros((2, episodes.n_agents), np.bool_)
            self.arrived[index] = self._won[w]
            if cells is not None:
                self._cells[w] = Cells.of(cells, w)

    def stepped(self, episodes: Episodes, worlds: Any) -> None:
        """Count who touches something, and who is at the goal."""
        simulation = episodes.simulation
        state, model, agents = simulation.state, simulation.model, simulation.agents
        for w in worlds.tolist():
            present = np.broadcast_to(model.present, (episodes.n_worlds, *model.present.shape[1:]))[w]
            bodies = [b for b in range(len(present)) if present[b]]
            parts = {b: self._parts(simulation, w, b) for b in bodies}
            for a in np.flatnonzero(~self._over[w]).tolist():
                own = int(agents[a])
                hit = any(touch(parts[own], parts[b]) for b in bodies if b != own)
                hit = hit or (w in self._cells and self._cells[w].touches(parts[own]))
                won = not hit and is_there(simulation.scenario.bodies[own], state.pose[w, own], state.goal[w, own])
                self._won[w][a], self._over[w][a] = won, hit or won

    @staticmethod
    def _parts(simulation: Any, w: int, b: int) -> Parts:
        """Return a body's parts: of robots from pose and file, of others their outline in the world."""
        state, model, spec = simulation.state, simulation.model, simulation.scenario.bodies[b]
        if b in simulation.agents:
            return robot_parts(spec.shape, state.pose[w, b])
        rows = slice(
            int(model.disc_start[b]), int(model.disc_start[b] + model.disc_count[w % len(model.disc_count), b])
        )
        parts: Parts = [(Point(x, y), float(radius)) for x, y, radius in state.discs[w, rows].tolist()]
        first = int(model.segment_start[b])
        lines = state.segments[w, first : first + int(model.segment_count[w % len(model.segment_count), b])]
        return [*parts, *_outline(lines, is_area=not isinstance(spec.shape, Linestring))]


def _outline(lines: NDArray[np.float64], is_area: bool) -> Parts:
    """Return segments as the polygon that they bound, or one by one."""
    if is_area and len(lines):
        return [(Polygon(lines[:, :2]), 0.0)]
    return [(LineString([line[:2], line[2:]]), 0.0) for line in lines]
