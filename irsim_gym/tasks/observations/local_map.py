"""Local map: the occupied share of each cell around the agent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Bytes, Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import IN_WORLD, Mirrored, sectors_exchanged
from irsim_gym.tasks.observations.occupancy_image import OccupancyImage, paint_occupied
from irsim_gym.tasks.observations.painting import Paints
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.arrays import aligned
from irsim_gym.world.group import records
from irsim_gym.world.model import Model
from irsim_gym.world.state import State


@dataclass
class CellPicture(Struct):
    """A small image for each agent, whose pixels are the cells.

    Attributes:
        painted: The term that ``paint_occupied`` reads: an ``OccupancyImage`` of that size.
        paints: Scratch memory and colours for painting.
        image: The images, ``(n_worlds, n_agents, cells, cells, 1)``.
    """

    painted: Bound
    paints: Paints
    image: Bytes


@kind
class LocalMap:
    """The occupied share of each square cell around the agent, row by row, from the actual obstacles.

    Space outside the world counts as occupied. No sensor shows all of this; it is meant for ``critic_observations``.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    cells: int = option(12, ge=8, le=256, meaning="Number of cells in a row, and of rows.")
    metres: float = option(6.0, gt=0.0, unit="m", meaning="Height and width of the area.")
    rotated: bool = option(True, meaning="The first row is ahead of the agent; otherwise it has the greatest y.")
    bodies: bool = option(True, meaning="Include other bodies.")

    def arrays(self, simulation: Simulation, agents: Ints) -> CellPicture:
        """Return the images, and the memory for painting them."""
        size: dict[str, Any] = {"pixels": self.cells, "metres": self.metres}
        painted = OccupancyImage(**size, rotated=self.rotated, bodies=self.bodies, goal_channel=False)
        paints = Paints.of(simulation, self.cells, self.cells, [[0.0, 1.0], [255.0, 1.0]])
        image = aligned((simulation.n_worlds, len(agents), self.cells, self.cells, 1), np.uint8)
        return CellPicture(Bound(agents, 0, records([painted])), paints, image)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the shares."""
        return np.zeros(self.cells**2, np.float32), np.ones(self.cells**2, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns."""
        side = self.metres / self.cells
        first = "from the row farthest ahead on, each from left to right" if self.rotated else "from the upper row on"
        return [Columns(f"occupied share of a cell of {side:.3g} m, {first}", "0 to 1", self.cells**2)]

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the cells of each row from right to left; a reason if the axes of the world point up and right."""
        return sectors_exchanged(self.cells, self.cells) if self.rotated else IN_WORLD

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Paint the cells, and write their occupied shares."""
        drawn = term.arrays
        cells = model.cells
        paint_occupied(shard.worlds, shard.slot, drawn.painted, drawn.paints, model, cells, state, drawn.image)
        write_shares(shard.worlds, term.bound, drawn.image, episode)


@kernel
def write_shares(worlds: Ints, term: Bound, image: Bytes, episode: EpisodeState) -> None:
    """Write the brightness of each pixel, from 0 to 1.

    Reads: term (column).
    Writes: episode (observation).
    """
    for w in worlds:
        for a in range(term.agents.shape[0]):
            pixels = image[w, a].reshape(-1)
            for k in range(pixels.shape[0]):
                episode.observation[w, a, term.column + k] = np.float32(pixels[k] / 255.0)
