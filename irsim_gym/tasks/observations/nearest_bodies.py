"""Nearest bodies: what stands or moves around an agent that has no range sensor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import CellMap, Flags, Floats, Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.geometry.cells import nearest_cell_point
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.scaling import unit
from irsim_gym.tasks.state import EpisodeState
from irsim_gym.tasks.term import Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

WIDTH = 6


@kind
class NearestBodies:
    """The nearest other bodies, nearest first, six numbers each; zeros for a body that is not there.

    x, y of the body's nearest part in the agent's frame (the centre of a disc, with its radius; the nearest point
    of an edge, with radius 0) over ``range``; relative velocity in the agent's frame over ``speed``; that radius
    over ``range``; and 1 for "there is one". Bodies whose surface is further away than ``range`` are not seen.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    count: int = option(6, ge=1, le=64, meaning="Number of bodies observed.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="How far it sees; none: the world's diagonal.")
    speed: float = option(2.0, gt=0.0, unit="m/s", meaning="Relative speed that counts as 1; faster is cut to it.")

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return scratch memory for the nearest bodies found so far, one row for each shard."""
        slots = simulation.shards.n_slots
        return {"distance": np.zeros((slots, self.count)), "found": np.zeros((slots, self.count, WIDTH))}

    def bounds(self, term: Term, model: WorldModel) -> tuple[Rays, Rays]:
        """Return the bounds, six for each body."""
        low = np.array([-1.0, -1.0, -1.0, -1.0, 0.0, 0.0], np.float32)
        return np.tile(low, self.count), np.ones(WIDTH * self.count, np.float32)

    def columns(self, term: Term, model: WorldModel, agent: int) -> Sequence[Columns]:
        """Return what the numbers of each body are."""
        words = (
            "its nearest part (the centre of a disc, else a point of its edge)",
            "radius of that disc, 0 for an edge",
        )
        return body_columns(self, model, "body", *words)

    @staticmethod
    def write(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Write the bodies' numbers."""
        given = term.options.range
        write_nearest(
            shard.worlds,
            term.agents,
            term.column,
            np.nan if given is None else given,
            term.options.speed,
            model.bounds,
            model.present,
            model.unobstructed,
            model.cells,
            model.reach,
            model.segment_start,
            model.segment_count,
            model.disc_start,
            model.disc_count,
            state.segments,
            state.discs,
            state.pose,
            state.twist,
            state.stopped,
            term.arrays["distance"][shard.slot],
            term.arrays["found"][shard.slot],
            episode.observation,
        )


def body_columns(options: Any, model: WorldModel, which: str, place: str, size: str) -> list[Columns]:
    """Return what the six numbers of the nearest bodies are.

    Args:
        options: Those of the kind: ``count``, ``range`` and ``speed``.
        model: The constants.
        which: What they are, e.g. ``"body"``.
        place: What of it the first two numbers tell.
        size: What the fifth tells.
    """
    far = options.range or float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
    over, pace = f"x / {far:.3g} m", f"v / {options.speed:g} m/s, relative to the robot"
    told = [
        Columns(f"nearest {which}: {place}, how far ahead", over),
        Columns(f"nearest {which}: how far to the left", over),
        Columns(f"nearest {which}: speed ahead", pace),
        Columns(f"nearest {which}: speed to the left", pace),
        Columns(f"nearest {which}: {size}", over),
        Columns(f"nearest {which}: 1 if there is one, else 0, and all its other numbers 0"),
    ]
    others = WIDTH * (options.count - 1)
    told += [Columns(f"the same six of each of the {options.count - 1} next nearest", count=others)] if others else []
    return told


@kernel
def write_nearest(
    worlds: Ints,
    agents: Ints,
    column: int,
    seen: float,
    speed: float,
    bounds: Floats,
    present: Flags,
    unobstructed: Flags,
    cells: CellMap | None,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    disc_start: Ints,
    disc_count: Ints,
    segments: Floats,
    discs: Floats,
    pose: Floats,
    twist: Floats,
    stopped: Flags,
    distance: Floats,
    found: Floats,
    out: Rays,
) -> None:
    """Write six numbers for each of the nearest bodies.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
        column: First column of ``out``.
        seen: How far bodies are seen [m]; NaN: the diagonal of ``bounds``.
        speed: Relative speed that counts as 1 [m/s].
        bounds: World rectangle [m].
        present: See WorldModel, as are the next arrays up to ``disc_count``.
        unobstructed: Bodies that are not seen.
        cells: The obstacle map, which counts as one body at its nearest point.
        reach: Bounding radius [m].
        segment_start: First segment of a body.
        segment_count: Number of its segments.
        disc_start: First disc of a body.
        disc_count: Number of its discs.
        segments: Outlines in the world frame [m], ``(n_worlds, n_segments, 4)``.
        discs: The same, ``(n_worlds, n_discs, 3)``.
        pose: ``(n_worlds, n_bodies, 3)`` [m, m, rad].
        twist: Velocities in the world frame [m/s].
        stopped: Bodies that are held in place.
        distance: Scratch, ``(count,)``.
        found: Scratch, ``(count, 6)``.
        out: Written, ``(n_worlds, n_agents, n_features)``.
    """
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    far = np.sqrt(width * width + height * height) if np.isnan(seen) else seen
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(agents.shape[0]):
            own = agents[a]
            x, y = pose[w, own, 0], pose[w, own, 1]
            distance[:], found[:] = far, 0.0
            for b in range(present.shape[1]):
                if b == own or unobstructed[b] or not present[w, b]:
                    continue
                dx, dy = pose[w, b, 0] - x, pose[w, b, 1] - y
                nearest_possible = np.sqrt(dx * dx + dy * dy) - reach[w % reach.shape[0], b]
                if nearest_possible >= distance[distance.shape[0] - 1]:
                    continue
                start, count = disc_start[b], disc_count[w % disc_count.shape[0], b]
                gap, px, py, radius = nearest_disc(discs[w], start, count, x, y)
                start, count = segment_start[b], segment_count[w % segment_count.shape[0], b]
                edge_gap, ex, ey = nearest_point(segments[w], start, count, x, y)
                if edge_gap < gap:
                    gap, px, py, radius = edge_gap, ex, ey, 0.0
                keep(gap, px - x, py - y, radius, b, distance, found)
            keep_cell(cells, x, y, distance, found)
            write_found(w, own, far, speed, pose, twist, stopped, found, column, out[w, a])


@kernel
def nearest_disc(discs: Floats, start: int, count: int, x: float, y: float) -> tuple[float, float, float, float]:
    """Return surface distance, centre and radius of the nearest disc [m]; infinity without one."""
    gap, cx, cy, radius = np.inf, 0.0, 0.0, 0.0
    for d in range(start, start + count):
        dx, dy = discs[d, 0] - x, discs[d, 1] - y
        here = np.sqrt(dx * dx + dy * dy) - discs[d, 2]
        if here < gap:
            gap, cx, cy, radius = here, discs[d, 0], discs[d, 1], discs[d, 2]
    return gap, cx, cy, radius


@kernel
def nearest_point(segments: Floats, start: int, count: int, x: float, y: float) -> tuple[float, float, float]:
    """Return distance and position of the nearest point of some segments [m]; infinity without one."""
    least, px, py = np.inf, 0.0, 0.0
    for s in range(start, start + count):
        ax, ay = segments[s, 0], segments[s, 1]
        ux, uy = segments[s, 2] - ax, segments[s, 3] - ay
        length2 = ux * ux + uy * uy
        along = ((x - ax) * ux + (y - ay) * uy) / length2 if length2 > 0.0 else 0.0
        along = min(max(along, 0.0), 1.0)
        qx, qy = ax + along * ux, ay + along * uy
        here = (qx - x) * (qx - x) + (qy - y) * (qy - y)
        if here < least:
            least, px, py = here, qx, qy
    return np.sqrt(least), px, py


@kernel
def keep(gap: float, dx: float, dy: float, radius: float, body: int, distance: Floats, found: Floats) -> None:
    """Insert a body into the sorted list of the nearest ones; column 3 of ``found`` holds its number."""
    k = distance.shape[0] - 1
    if gap >= distance[k]:
        return
    while k > 0 and gap < distance[k - 1]:
        distance[k] = distance[k - 1]
        for column in range(found.shape[1]):
            found[k, column] = found[k - 1, column]
        k -= 1
    distance[k] = gap
    found[k, 0], found[k, 1], found[k, 2], found[k, 3], found[k, 5] = dx, dy, radius, float(body), 1.0


@kernel
def keep_cell(cells: CellMap | None, x: float, y: float, distance: Floats, found: Floats) -> None:
    """Insert the nearest occupied cell of the map, at rest, if it is near enough."""
    if cells is None:
        return
    gap, px, py = nearest_cell_point(cells, x, y, distance[distance.shape[0] - 1])
    keep(gap, px - x, py - y, 0.0, int(cells[0][4]), distance, found)


@kernel
def write_found(
    w: int,
    own: int,
    far: float,
    speed: float,
    pose: Floats,
    twist: Floats,
    stopped: Flags,
    found: Floats,
    column: int,
    row: Rays,
) -> None:
    """Turn what was found into the agent's frame, scale it to [-1, 1] and write it."""
    cosine, sine = np.cos(pose[w, own, 2]), np.sin(pose[w, own, 2])
    for k in range(found.shape[0]):
        dx, dy, there = found[k, 0], found[k, 1], found[k, 5]
        b = int(found[k, 3])
        vx = moving(w, b, 0, twist, stopped) - moving(w, own, 0, twist, stopped)
        vy = moving(w, b, 1, twist, stopped) - moving(w, own, 1, twist, stopped)
        at = column + WIDTH * k
        row[at] = unit((dx * cosine + dy * sine) / far)
        row[at + 1] = unit((dy * cosine - dx * sine) / far)
        row[at + 2] = unit(there * (vx * cosine + vy * sine) / speed)
        row[at + 3] = unit(there * (vy * cosine - vx * sine) / speed)
        row[at + 4] = unit(found[k, 2] / far)
        row[at + 5] = np.float32(there)


@kernel
def moving(w: int, b: int, axis: int, twist: Floats, stopped: Flags) -> float:
    """Return a component of a body's velocity; 0 when it is held in place."""
    return 0.0 if stopped[w, b] else twist[w, b, axis]
