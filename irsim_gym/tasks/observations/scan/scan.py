"""Scan: the agent's range sensor, pooled into sectors."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, Words, kernel, kind, option
from irsim_gym.tasks.observations.scan import ranges as readings
from irsim_gym.tasks.observations.scan.ranges import EncodesDepths, RangeCode, encode, encoded, range_code
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, RobotValues, Simulation, Term, Value, coded
from irsim_gym.tasks.terms.mirrored import Mirrored, sectors_exchanged


@dataclass
class Sectors(Struct):
    """The tables for pooling a scan.

    Attributes:
        ranges: Live readings [m], shape ``(n_worlds, n_members, n_beams)``.
        members: Each agent's row in ``ranges``, shape ``(n_agents,)``.
        first: First beam of each sector, shape ``(n_sectors,)``; unsigned, which avoids a check for negative indices.
        last: One past the last beam of each sector, likewise.
        extent: Distance to the agent's own outline [m], shape ``(n_agents, n_beams)``.
        far: Maximum range of each agent's sensor [m], shape ``(n_agents,)``.
        angles: Directions of the beams [rad], shape ``(n_beams,)``.
        turns: Heading of each agent's sensor in the body frame [rad], shape ``(n_agents,)``.
    """

    ranges: Rays
    members: Ints
    first: Words
    last: Words
    extent: Rays
    far: Rays
    angles: Floats
    turns: Floats


@kind
class Scan(EncodesDepths):
    """Free depth in sectors of equal angle: the encoded minimum range beyond the agent's own outline.

    For the depth ``m`` of a sector, ``inverse`` is ``(1 / (m + near) - zero) / (1 / near - zero)``: 1 in contact, steep
    at small depths, and about 0 at ``1 / zero``. ``linear`` is ``1 - m / range_max``: 1 in contact.
    """

    needs: ClassVar[Needs] = ("scan",)

    sectors: int = option(36, ge=1, meaning="Number of sectors; at most the number of beams.")
    without_sensor: str | tuple[str, ...] = readings.WITHOUT_SENSOR

    problems = readings.code_problems

    def arrays(self, simulation: Simulation, agents: Ints) -> Sectors:
        """Return the live ranges with each agent's row, the sectors' beams and the agents' own extents."""
        group, members = readings.shared_sensors(simulation, agents, "scan")
        table = group.arrays
        first, last = sector_beams(table["angles"], self.sectors)
        return Sectors(
            ranges=table["ranges"],
            members=members,
            first=first.astype(np.uint64),
            last=last.astype(np.uint64),
            extent=np.ascontiguousarray(table["footprint"][members]),
            far=np.array([group.options[k].range_max for k in members], np.float32),
            angles=table["angles"],
            turns=np.array([group.options[k].offset[2] for k in members]),
        )

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the codes of the maximum depth of each sector, and of contact."""
        sectors: Sectors = term.arrays
        first, last, far = sectors.first, sectors.last, sectors.far
        farthest, most = far[:, None] - sectors.extent, float(far.max())
        pairs = [farthest[:, int(i) : int(j)].min(axis=1, initial=most) for i, j in zip(first, last, strict=True)]
        low = np.stack(pairs, axis=1)
        low, high = np.maximum(low, np.float32(0.0)), np.zeros_like(low)
        for a in range(len(far)):
            for values in (low[a], high[a]):
                encode(values, RangeCode.of(self, far[a]))
        return low.min(axis=0), high.max(axis=0)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns; sectors extend half a beam beyond their outer beams."""
        table: Sectors = term.arrays
        edges = sector_edges(table.angles, len(table.first)) + table.turns[agent]
        far = float(table.far[agent])
        scale = f"d = free depth beyond its own outline, as {coded(self, 'd', far)}"
        sectors = tuple(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))
        return [Columns("least range of a sector of the scan", scale, len(sectors), sectors)]

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the sectors from right to left; a reason if a beam on a border belongs to one side alone."""
        first, last = term.arrays.first.astype(np.int64), term.arrays.last.astype(np.int64)
        if not np.array_equal(first, len(term.arrays.angles) - last[::-1]):
            return "has beams on the borders of its sectors: choose 'sectors' that divide the number of beams"
        return sectors_exchanged(len(first))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        sectors: Sectors = term.arrays
        first, last = sectors.first.astype(np.int64), sectors.last.astype(np.int64)
        # Sectors with fewer beams than others name their last one again.
        beams = np.minimum(first[:, None] + np.arange((last - first).max()), last[:, None] - 1)
        depths, far = (robot.ranges - sectors.extent[agent]).take(beams).smallest(2), sectors.far[agent]
        return self.coded_graph(far, depths.between(0.0, far))

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the sectors' codes."""
        pool(shard.worlds, term.bound, term.arrays, episode)


def half_beam(angles: Floats) -> float:
    """Return half the angle between two neighbouring beams [rad]; 0 for one beam or none."""
    return 0.5 * float(angles[-1] - angles[0]) / (len(angles) - 1) if len(angles) > 1 else 0.0


def sector_edges(angles: Floats, count: int) -> Floats:
    """Return the edges of sectors of equal angle [rad], shape ``(count + 1,)``; of a full turn without beams."""
    if len(angles) == 0:
        return np.linspace(-np.pi, np.pi, count + 1)
    half = half_beam(angles)
    return np.linspace(angles[0] - half, angles[-1] + half, count + 1)


def sector_beams(angles: Floats, sectors: int) -> tuple[Ints, Ints]:
    """Return the first and one past the last beam of each sector; sectors of equal angle cover all beams.

    The sectors span the beams' angles (ascending [rad]) and half a beam more at both ends. A sector without a beam gets
    the one nearest to its middle. If all beams have the same direction, they belong to the first sector. Without beams,
    there are as many sectors as asked for, and all are empty.

    Args:
        angles: Beam directions, shape ``(n_beams,)``.
        sectors: Maximum number of sectors.
    """
    n_beams = len(angles)
    if n_beams == 0:
        return np.zeros(sectors, np.int64), np.zeros(sectors, np.int64)
    count = min(sectors, n_beams)
    if n_beams == 1:
        return np.zeros(1, np.int64), np.ones(1, np.int64)
    half = half_beam(angles)
    width = (angles[-1] - angles[0] + 2.0 * half) / count
    place = (angles - angles[0] + half) / width if width > 0.0 else np.zeros(n_beams)
    # A beam on the border of two sectors belongs to the second one, whatever is rounded.
    sector = np.floor(place + 1e-9).astype(np.int64).clip(0, count - 1)
    first = np.searchsorted(sector, np.arange(count), side="left").astype(np.int64)
    last = np.searchsorted(sector, np.arange(count), side="right").astype(np.int64)
    for s in np.flatnonzero(first == last):
        middle = angles[0] - half + (s + 0.5) * width
        first[s] = np.argmin(np.abs(angles - middle))
        last[s] = first[s] + 1
    return first, last


@kernel
def pool(worlds: Ints, term: Bound, sectors: Sectors, episode: EpisodeState) -> None:
    """Write each sector's encoded minimum depth beyond the own outline.

    Reads: term (column, options), sectors (extent, far, first, last, members, ranges), episode (observation).
    Writes: episode (observation).
    """
    options, first, last = term.options[0], sectors.first, sectors.last
    n_sectors, column = first.shape[0], term.column
    for w in worlds:
        for a in range(sectors.members.shape[0]):
            scan, extent, far = sectors.ranges[w, sectors.members[a]], sectors.extent[a], sectors.far[a]
            row, code = episode.observation[w, a, column : column + n_sectors], range_code(options, far)
            if n_sectors == extent.shape[0]:
                write_depths(code, extent, scan, row)
                continue
            for s in range(n_sectors):
                least = far
                for k in range(first[s], last[s]):
                    depth = scan[k] - extent[k]
                    least = depth if depth < least else least
                row[s] = least if least > np.float32(0.0) else np.float32(0.0)
            encode(row, code)


@kernel(inlined=True)
def write_depths(code: RangeCode, extent: Rays, scan: Rays, row: Rays) -> None:
    """Write the code of each beam's depth beyond the own outline, for sectors of one beam."""
    for k in range(row.shape[0]):
        depth = scan[k] - extent[k]
        depth = depth if depth < code.far else code.far
        row[k] = encoded(depth if depth > np.float32(0.0) else np.float32(0.0), code)
