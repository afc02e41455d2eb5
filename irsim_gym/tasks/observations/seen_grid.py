"""What the scans of each learner have shown so far, in a grid of cells of its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.arraytypes import Bytes, Ints, Labels
from irsim_gym.engine import Simulation
from irsim_gym.engine.own_scans import own_scan
from irsim_gym.jit import kernel
from irsim_gym.paths.grid import Grid
from irsim_gym.paths.scan_marks import mark_hits, mark_passed, settle_doubts
from irsim_gym.scenario.options import option
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.observations.ranges import shared_sensors
from irsim_gym.tasks.term import Bound
from irsim_gym.world.own_scan import OwnScan
from irsim_gym.world.state import WorldState

FINEST = 64
"""Cells along the longer side of the world, unless a side is given."""

CELL = option(None, gt=0.0, unit="m", meaning="Cell size; default: a 64th of the world's longer side.")
EVERY = option(4, ge=1, unit="steps", meaning="Steps from one scan that is added to the next.")


@dataclass
class SeenGrid(Struct):
    """The latest scans, and what they and those before them have shown.

    Attributes:
        scan: The scans; member k is learner k.
        grid: The grid: the world, and one cell more on each side for what stands on its edge.
        cells: What each learner knows of each cell, see ``paths.scan_marks``, shape ``(n_worlds, n_agents, rows,
            columns)``.
        doubted: Scratch: cells that beams have passed although they were occupied, shape ``(n_slots, n_cells)``; none
            where nothing but the learner can move, as nothing that is occupied can become free there.
        fresh: Scratch: cells that are newly occupied, shape ``(n_slots, n_beams)``.
    """

    scan: OwnScan
    grid: Grid
    cells: Bytes
    doubted: Labels
    fresh: Labels

    @classmethod
    def over(cls, grid: Grid, simulation: Simulation, agents: Ints, name: str) -> Self:
        """Return maps without anything, for an observation of some name."""
        group, members = shared_sensors(simulation, agents, name)
        scan, slots = own_scan(group, members), simulation.shards.n_slots
        can_change = len(agents) > 1 or not np.delete(simulation.model.stands, agents).all()
        return cls(
            scan=scan,
            grid=grid,
            cells=np.zeros((simulation.n_worlds, len(agents), grid.rows, grid.columns), np.uint8),
            doubted=np.zeros((slots, grid.rows * grid.columns if can_change else 0), np.int32),
            fresh=np.zeros((slots, scan.ranges.shape[2]), np.int32),
        )


def world_grid(simulation: Simulation, cell: float | None) -> Grid:
    """Return a grid over the world with one cell more on each side, for a side of a cell [m] or for the usual one."""
    bounds = simulation.model.bounds
    side = max(float(bounds[2] - bounds[0]), float(bounds[3] - bounds[1]))
    inner = Grid.over(bounds, side / FINEST if cell is None else cell)
    wide = inner.cell
    return Grid(inner.origin_x - wide, inner.origin_y - wide, wide, inner.columns + 2, inner.rows + 2)


@kernel
def note_all(worlds: Ints, slot: int, term: Bound, seen: SeenGrid, state: WorldState, episode: EpisodeState) -> None:
    """Add the latest scans to the maps of learners, at the start and then every ``every`` steps.

    Reads: term (agents, options), seen (cells, doubted, grid, scan), state (pose), episode (steps).
    Writes: seen (cells, doubted, fresh).
    """
    grid, fresh, doubted = seen.grid, seen.fresh[slot], seen.doubted[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            if episode.steps[w, a] % term.options[0].every != 0:
                continue
            pose, cells = state.pose[w, term.agents[a]], seen.cells[w, a]
            count = mark_passed(seen.scan, w, a, pose, grid, cells, doubted)
            mark_hits(seen.scan, w, a, pose, grid, cells, fresh)
            settle_doubts(cells, doubted, count)
