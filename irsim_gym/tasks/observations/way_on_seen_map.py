"""Way on the seen map: the shortest path to the goal on the map from the learner's own scans."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Ints, Point, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.geometry.angles import turned
from irsim_gym.jit import kernel
from irsim_gym.paths.cell_lines import is_clear
from irsim_gym.paths.grid import centre
from irsim_gym.paths.wavefront import STRAIGHT
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import Mirrored, signed
from irsim_gym.tasks.observations.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_grid import EVERY, SeenGrid, forget_seen, note_all, shared_map
from irsim_gym.tasks.observations.seen_ways import (
    SeenWays,
    clear_levels,
    find_way,
    last_in_sight,
    narrow_ways,
)
from irsim_gym.tasks.scaling import unit
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@kind
class WayOnSeenMap:
    """Direction and length of the shortest path to the next goal on the map from the agent's own scans.

    Unknown space counts as free (Koenig and Smirnov 1996). The direction, as cosine and sine, is that of the last point
    of the path that can be reached straight. The length is divided by the world's diagonal and clipped to 1. Cells in
    which the agent fits, but not at their centre, cost eight times as much. Without a path, the direction is that of
    the goal, and the length is 1. If other bodies can move, a beam clears earlier hits as far as the beams beside it
    reach, too.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = True
    needs_scan: ClassVar[bool] = True

    cell: float | None = option(
        None,
        gt=0.0,
        unit="m",
        meaning="Cell size; default: a 64th of the world's longer side.",
        consequence="Cells wider than the agent close gaps that it fits through.",
    )
    every: int = EVERY
    clearance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Distance that the path keeps from obstacles.",
        consequence="The way leads through gaps that the agent fits through by millimetres.",
    )
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def arrays(self, simulation: Simulation, agents: Ints) -> SeenWays:
        """Return the maps, the paths, and scratch memory."""
        seen = SeenGrid.over(self, simulation, agents, "way_on_seen_map", follows=False)
        return SeenWays.over(seen, simulation.shards.n_slots, self.clearance)

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Share the map of an earlier observation, if possible."""
        term.arrays.seen = shared_map(term.arrays.seen, earlier)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the three elements."""
        return np.array([-1.0, -1.0, 0.0], np.float32), np.ones(3, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns."""
        full = float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
        point = "of the direction of the shortest way to the next goal on what its scans have shown"
        return [
            Columns(f"cosine {point}", "1 straight ahead, -1 straight behind"),
            Columns(f"sine {point}", "1 to the left, -1 to the right"),
            Columns("length s of that way", f"s / {full:.3g} m, at most 1; 1 where there is none"),
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps and paths."""
        ways = term.arrays
        forget_seen(shard.worlds, ways.seen, episode)
        clear_levels(shard.worlds, ways, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, and write the three elements."""
        note_all(shard.worlds, shard.slot, term.bound, term.arrays.seen, state, episode)
        narrow_ways(shard.worlds, term.bound, term.arrays, model, episode)
        write_ways_seen(shard.worlds, shard.slot, term.bound, term.arrays, model, state, episode)


@kernel
def write_ways_seen(
    worlds: Ints, slot: int, term: Bound, ways: SeenWays, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write cosine and sine of the path's direction, (1, 0) at the goal itself, and its length over the diagonal.

    Reads: term (agents, column), ways (least, levels, queues, seen, target, way), model (bounds), state (direction,
        goal, pose).
    Writes: ways (least, queues, target, way), episode (observation).
    """
    grid, way = ways.seen.grid, ways.way[slot]
    width, height = model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]
    full = np.sqrt(width * width + height * height)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b, levels = term.agents[a], ways.levels[w, a]
            here, there = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            rest = 0.0
            if not is_clear(here, there, grid, levels):
                count = find_way(ways, slot, w, a, here, there)
                if count == 0:
                    rest = np.inf
                else:
                    place = last_in_sight(here, grid, levels, way, count)
                    # Costs are whole numbers, STRAIGHT for a step of one cell.
                    rest = ways.least[w, a].reshape(-1)[place] * (grid.cell / STRAIGHT)
                    if rest > 0.0:
                        there = centre(grid, place // grid.columns, place % grid.columns)
            row = episode.observation[w, a, term.column : term.column + 3]
            write_way(row, here, turned(state.pose[w, b, 2], state.direction[w, b]), there, rest, full)


@kernel
def write_way(row: Rays, here: Point, facing: Point, there: Point, rest: float, full: float) -> None:
    """Write cosine and sine of the direction from ``here`` to ``there``, and the length of the way over the diagonal.

    Args:
        row: The three elements, shape ``(3,)``.
        here: Where the agent is [m].
        facing: Cosine and sine of its heading.
        there: The last point that can be reached straight [m]. The direction is (1, 0) if it is ``here``.
        rest: Length of the way from there on [m].
        full: Diagonal of the world [m].

    Writes: row.
    """
    dx, dy = there[0] - here[0], there[1] - here[1]
    far = np.sqrt(dx * dx + dy * dy)
    row[0] = unit((dx * facing[0] + dy * facing[1]) / far if far > 0.0 else 1.0)
    row[1] = unit((dy * facing[0] - dx * facing[1]) / far if far > 0.0 else 0.0)
    row[2] = unit((far + rest) / full)
