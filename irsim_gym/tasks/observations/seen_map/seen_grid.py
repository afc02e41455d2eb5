"""Grid maps of what each learner's scans have shown so far."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags, Ints, Labels
from irsim_gym.simulator.cell_paths.scan_marks import UNKNOWN, count_freed, free_passed, mark_hits, mark_passed
from irsim_gym.simulator.engine.own_scans import own_scan
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.tasks.observations.scan.ranges import shared_sensors
from irsim_gym.tasks.terms import Bound, EpisodeState, Simulation, State, Struct, Term, kernel, option

FINEST = 64
"""Default number of cells along the longer side of the world."""

CELL = option(None, gt=0.0, unit="m", meaning="Cell size; default: a 64th of the world's longer side.")
EVERY = option(4, ge=1, unit="steps", meaning="Steps from one scan that is added to the next.")

NOTHING = -1
"""Value of ``noted`` before the first scan is added."""


@dataclass
class SeenGrid(Struct):
    """The latest scans, and the maps of all scans so far. Observations of a task share it.

    Attributes:
        scan: The scans; member k is learner k.
        grid: The grid: the world, and one more cell on each side for obstacles on its edge.
        every: Number of steps between added scans.
        follows: Whether beams are traced, so that the cells that they pass become known.
        cells: State of each cell for each learner, see ``simulator.cell_paths.scan_marks``, shape ``(n_worlds,
            n_agents, rows, columns)``.
        noted: Step of the latest added scan, or ``NOTHING``, shape ``(n_worlds, n_agents)``.
        fresh: Quarters of cells that it newly showed to be occupied, shape ``(n_worlds, n_agents, n_beams)``.
        n_fresh: Number of these quarters, shape ``(n_worlds, n_agents)``.
        n_freed: Number of quarters that it showed to be no longer occupied, likewise.
        doubted: Scratch: occupied quarters that beams have passed, shape ``(n_slots, n_quarters)``; empty if only the
            learner can move, because occupied cells cannot become free then.
        skipped: Whether the hit of each beam is left out of the map, shape ``(n_worlds, n_agents, n_beams)``; no beams
            if no observation leaves any out.
    """

    scan: OwnScan
    grid: Grid
    every: int
    follows: bool
    cells: Bytes
    noted: Labels
    fresh: Labels
    n_fresh: Labels
    n_freed: Labels
    doubted: Ints
    skipped: Flags

    @classmethod
    def over(cls, term: Any, simulation: Simulation, agents: Ints, name: str, *, follows: bool) -> Self:
        """Return empty maps.

        Args:
            term: An observation with the options ``cell`` and ``every``.
            simulation: The simulation.
            agents: Body of each learner, shape ``(n_agents,)``.
            name: Name of the observation.
            follows: Whether the observation needs the cells that beams have passed.
        """
        group, members = shared_sensors(simulation, agents, name)
        scan, grid = own_scan(group, members), world_grid(simulation, term.cell)
        shape = simulation.n_worlds, len(agents)
        can_change = len(agents) > 1 or not np.delete(simulation.model.stands, agents).all()
        return cls(
            scan=scan,
            grid=grid,
            every=term.every,
            follows=follows,
            cells=np.zeros((*shape, grid.rows, grid.columns), np.uint8),
            noted=np.full(shape, NOTHING, np.int32),
            fresh=np.zeros((*shape, scan.ranges.shape[2]), np.int32),
            n_fresh=np.zeros(shape, np.int32),
            n_freed=np.zeros(shape, np.int32),
            doubted=np.zeros((simulation.shards.n_slots, 4 * grid.rows * grid.columns if can_change else 0), np.int64),
            skipped=np.zeros((*shape, 0), np.bool_),
        )


def shared_map(seen_map: SeenGrid, earlier: Sequence[Term]) -> SeenGrid:
    """Return the map of an earlier term of the task with the same cells and scans, to share it; else the own map."""
    for term in earlier:
        other = getattr(term.arrays, "seen", None)
        if isinstance(other, SeenGrid) and (other.grid, other.every) == (seen_map.grid, seen_map.every):
            other.follows = other.follows or seen_map.follows
            return other
    return seen_map


def world_grid(simulation: Simulation, cell: float | None) -> Grid:
    """Return a grid over the world with one more cell on each side, for a cell size [m] or the default one."""
    bounds = simulation.model.bounds
    side = max(float(bounds[2] - bounds[0]), float(bounds[3] - bounds[1]))
    inner = Grid.over(bounds, side / FINEST if cell is None else cell)
    wide = inner.cell
    return Grid(inner.origin_x - wide, inner.origin_y - wide, wide, inner.columns + 2, inner.rows + 2)


@kernel(inlined=True)
def cell_number(up: float, across: float, grid: Grid) -> np.int32:
    """Return the number of the cell at a point [cells], -1 outside of the grid; loops over points are vectorised."""
    row, column = np.int32(np.floor(up)), np.int32(np.floor(across))
    is_inside = (row >= 0) & (row < np.int32(grid.rows)) & (column >= 0) & (column < np.int32(grid.columns))
    return np.int32(row * np.int32(grid.columns) + column) if is_inside else np.int32(-1)


@kernel
def forget_seen(worlds: Ints, seen: SeenGrid, episode: EpisodeState) -> None:
    """Clear the maps of agents whose episodes begin.

    Reads: seen (noted), episode (began).
    Writes: seen (cells, noted).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a] and seen.noted[w, a] != NOTHING:
                seen.cells[w, a, :, :] = UNKNOWN
                seen.noted[w, a] = NOTHING


@kernel
def note_all(worlds: Ints, slot: int, term: Bound, seen: SeenGrid, state: State, episode: EpisodeState) -> None:
    """Add the latest scans to the learners' maps, at the start and then every ``every`` steps, unless already added.

    Reads: term (agents), seen (cells, doubted, every, follows, grid, noted, scan, skipped), state (pose), episode
        (steps).
    Writes: seen (cells, doubted, fresh, n_freed, n_fresh, noted).
    """
    doubted = seen.doubted[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            steps = episode.steps[w, a]
            if steps % seen.every != 0 or steps == seen.noted[w, a]:
                continue
            pose, cells, count = state.pose[w, term.agents[a]], seen.cells[w, a], 0
            # The order matters: what beams have passed becomes known and free first, then what they hit becomes
            # occupied.
            if seen.follows:
                mark_passed(seen.scan, w, a, pose, seen.grid, cells)
            if doubted.shape[0] > 0:
                count = free_passed(seen.scan, w, a, pose, seen.grid, cells, doubted)
            seen.n_fresh[w, a] = mark_hits(
                seen.scan, w, a, pose, seen.grid, cells, seen.fresh[w, a], seen.skipped[w, a]
            )
            seen.n_freed[w, a] = count_freed(cells, doubted, count)
            seen.noted[w, a] = steps
