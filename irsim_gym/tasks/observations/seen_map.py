"""Seen map: the map from the learner's own scans, pooled into rings and sectors around it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Labels, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.paths.scan_marks import OCCUPIED, UNKNOWN
from irsim_gym.scenario.options import kind, option
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import Mirrored, sectors_exchanged
from irsim_gym.tasks.observations.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_grid import CELL, EVERY, SeenGrid, cell_number, forget_seen, note_all, shared_map
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns, evenly
from irsim_gym.world.model import Model
from irsim_gym.world.state import State

APART = 2.0
"""Maximum distance between neighbouring samples [cells]."""


@dataclass
class SeenBins(Struct):
    """The maps, and the points at which they are sampled.

    Attributes:
        seen: The maps.
        samples: The samples in the body frame [m], bin by bin, shape ``(2, n_samples)``.
        ends: One past the last sample of each bin, ring by ring, shape ``(n_rings * sectors,)``.
        places: Scratch: cell numbers of the samples, shape ``(n_slots, n_samples)``.
    """

    seen: SeenGrid
    samples: Floats
    ends: Ints
    places: Labels


@kind
class SeenMap:
    """The map of what the agent's own scans have shown so far, by rings and sectors around it.

    For each ring, from the inside out, the columns are the occupied share of each sector, then the unknown share of
    each. Cells are unknown until a beam passes them or hits something in them; space outside the world is unknown. Hits
    remain in the map. If other bodies can move, a beam clears them as far as the beams beside it reach, too. A cell is
    occupied as long as a quarter of it is. Observations with the same ``cell`` and ``every`` share one map.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = True

    sectors: int = option(16, ge=1, le=360, meaning="Number of sectors; the first begins straight behind.")
    rings: tuple[float, ...] = option((1.0, 2.0, 4.0), unit="m", meaning="Outer radii of the rings, growing.")
    cell: float | None = CELL
    every: int = EVERY
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def problems(self) -> list[tuple[str, str]]:
        """Return key and message of conflicting options."""
        if not self.rings or not all(a < b for a, b in zip((0.0, *self.rings), self.rings, strict=False)):
            return [("rings", f"must be growing numbers > 0, got {list(self.rings)}")]
        return []

    def arrays(self, simulation: Simulation, agents: Ints) -> SeenBins:
        """Return the maps, and the points at which they are sampled."""
        seen = SeenGrid.over(self, simulation, agents, "seen_map", follows=True)
        bins = bin_samples(self.rings, self.sectors, APART * seen.grid.cell)
        return SeenBins(
            seen=seen,
            samples=np.ascontiguousarray(np.concatenate(bins).T),
            ends=np.cumsum([len(one) for one in bins]),
            places=np.zeros((simulation.shards.n_slots, sum(len(one) for one in bins)), np.int32),
        )

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Share the map of an earlier observation, if possible."""
        term.arrays.seen = shared_map(term.arrays.seen, earlier)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the shares."""
        width = 2 * self.sectors * len(self.rings)
        return np.zeros(width, np.float32), np.ones(width, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns."""
        sectors = evenly(self.sectors)
        rings = [f"between {a:g} m and {b:g} m away" for a, b in zip((0.0, *self.rings), self.rings, strict=False)]
        return [
            Columns(f"share of a sector, {ring}, that is {what}", "0 to 1", self.sectors, sectors)
            for ring in rings
            for what in ("occupied as far as its scans have shown", "unknown")
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the sectors from right to left."""
        return sectors_exchanged(self.sectors, 2 * len(self.rings))

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps."""
        forget_seen(shard.worlds, term.arrays.seen, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, and write the shares."""
        note_all(shard.worlds, shard.slot, term.bound, term.arrays.seen, state, episode)
        write_seen(shard.worlds, shard.slot, term.bound, term.arrays, state, episode)


def bin_samples(rings: Sequence[float], sectors: int, apart: float) -> list[Floats]:
    """Return evenly spaced points of each bin [m], ring by ring, shape ``(n_samples, 2)`` each."""
    bins = []
    for low, high in zip((0.0, *rings), rings, strict=False):
        along, across = int(np.ceil((high - low) / apart)), int(np.ceil(2.0 * np.pi * high / sectors / apart))
        radii = low + (high - low) * (np.arange(along) + 0.5) / along
        for sector in range(sectors):
            angles = 2.0 * np.pi * (sector + (np.arange(across) + 0.5) / across) / sectors - np.pi
            x, y = np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))
            bins.append(np.stack([x.reshape(-1), y.reshape(-1)], axis=1))
    return bins


@kernel
def write_seen(worlds: Ints, slot: int, term: Bound, bins: SeenBins, state: State, episode: EpisodeState) -> None:
    """Write the occupied and the unknown share of each bin.

    Reads: term (agents, column, options), bins (ends, places, samples, seen), state (pose).
    Writes: bins (places), episode (observation).
    """
    grid, sectors, samples, ends = bins.seen.grid, term.options[0].sectors, bins.samples, bins.ends
    places = bins.places[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            pose, cells = state.pose[w, term.agents[a]], bins.seen.cells[w, a].reshape(-1)
            ahead, aside = np.cos(pose[2]) / grid.cell, np.sin(pose[2]) / grid.cell
            x, y = (pose[0] - grid.origin_x) / grid.cell, (pose[1] - grid.origin_y) / grid.cell
            for n in range(places.shape[0]):
                across = x + ahead * samples[0, n] - aside * samples[1, n]
                up = y + aside * samples[0, n] + ahead * samples[1, n]
                places[n] = cell_number(up, across, grid)
            n = 0
            for k in range(ends.shape[0]):
                first, occupied, unknown = n, 0, 0
                while n < ends[k]:
                    known = cells[places[n]] if places[n] >= 0 else UNKNOWN
                    occupied += 1 if known & OCCUPIED != 0 else 0
                    unknown += 1 if known == UNKNOWN else 0
                    n += 1
                # Bin k is sector k % sectors of ring k // sectors. A ring's occupied shares come before its unknown
                # ones.
                place = term.column + 2 * sectors * (k // sectors) + k % sectors
                episode.observation[w, a, place] = np.float32(occupied / (n - first))
                episode.observation[w, a, place + sectors] = np.float32(unknown / (n - first))
