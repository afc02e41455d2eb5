"""Seen map image: the map from the learner's own scans as an image."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.cell_paths.scan_marks import OCCUPIED, UNKNOWN
from irsim_gym.simulator.world.names import Bytes, Ints, Labels, Model, Shard, State, Struct, kernel, kind
from irsim_gym.tasks.observations.images.occupancy_image import paint_goal, view_of
from irsim_gym.tasks.observations.images.painting import Paints, SquareImage
from irsim_gym.tasks.observations.images.scan_painting import UNKNOWN as NOT_SEEN
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_map import seen_grid
from irsim_gym.tasks.observations.seen_map.seen_grid import SeenGrid, cell_number, forget_seen, note_all, shared_map
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, Simulation, Term

SHADES = np.array([NOT_SEEN, *[255] * int(OCCUPIED), 0, *[255] * int(OCCUPIED)], np.uint8)
"""Value of a pixel by the state of its cell."""


@dataclass
class SeenPicture(Struct):
    """The maps, and memory for painting goals.

    Attributes:
        seen: The maps.
        paints: Memory for painting goals.
        places: Scratch: cell numbers of a row of pixels, shape ``(n_slots, pixels)``.
    """

    seen: SeenGrid
    paints: Paints
    places: Labels


@kind
class SeenMapImage(SquareImage):
    """A square image of what the agent's own scans have shown so far: 0 free, 255 hit, 127 not seen.

    It is uint8 ``(pixels, pixels, n_channels)`` with the agent in the middle; each pixel shows the cell at its centre.
    Cells are unknown until a beam passes them or hits something in them; space outside the world is unknown. Hits
    remain in the map. If other bodies can move, a beam clears them as far as the beams beside it reach, too. A cell is
    occupied as long as a quarter of it is. Observations with the same ``cell`` and ``every`` share one map.
    ``goal_channel`` adds a channel with a disc at the goal, or at the border if the goal is farther away.
    """

    needs: ClassVar[Needs] = ("scan", "odometry", "grid")

    cell: float | None = seen_grid.CELL
    every: int = seen_grid.EVERY
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    @property
    def image_shape(self) -> tuple[int, int, int]:
        """Height and width [pixels] and number of channels."""
        return self.pixels, self.pixels, 1 + self.goal_channel

    def arrays(self, simulation: Simulation, agents: Ints) -> SeenPicture:
        """Return the maps, and memory for painting goals."""
        seen = SeenGrid.over(self, simulation, agents, "seen_map_image", follows=True)
        paints = Paints.of(simulation, self.pixels, self.pixels, [[0.0, 1.0], [255.0, 1.0]])
        return SeenPicture(seen, paints, np.zeros((simulation.shards.n_slots, self.pixels), np.int32))

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Share the map of an earlier observation, if possible."""
        term.arrays.seen = shared_map(term.arrays.seen, earlier)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the channels."""
        channels = [Columns("what its scans have shown so far", "0 free, 127 not seen, 255 hit")]
        if self.goal_channel:
            channels.append(Columns("the next goal", "255 where it is, at the border where it is farther away"))
        return channels

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps."""
        forget_seen(shard.worlds, term.arrays.seen, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, and paint the image."""
        worlds, slot, tools, image = shard.worlds, shard.slot, term.arrays, term.image
        note_all(worlds, slot, term.bound, tools.seen, state, episode)
        paint_seen(worlds, slot, term.bound, tools, state, image)
        if term.options.goal_channel:
            paint_goal(worlds, slot, term.bound, tools.paints, model, state, image)


@kernel
def paint_seen(worlds: Ints, slot: int, term: Bound, tools: SeenPicture, state: State, image: Bytes) -> None:
    """Write the state of the cell at each pixel's centre into the first channel, and clear the others.

    Reads: term (agents, options), tools (places, seen), state (pose).
    Writes: tools (places), image.
    """
    grid, places = tools.seen.grid, tools.places[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, view = image[w, a], view_of(term, state.pose[w, term.agents[a]])
            cells, size = tools.seen.cells[w, a].reshape(-1), 1.0 / (view.scale * grid.cell)
            x, y = (view.x - grid.origin_x) / grid.cell, (view.y - grid.origin_y) / grid.cell
            for i in range(picture.shape[0]):
                up = (view.middle_y - i - 0.5) * size
                for j in range(places.shape[0]):
                    right = (j + 0.5 - view.middle_x) * size
                    across = x + right * view.up_y + up * view.up_x
                    places[j] = cell_number(y - right * view.up_x + up * view.up_y, across, grid)
                for j in range(places.shape[0]):
                    picture[i, j, 0] = SHADES[cells[places[j]] if places[j] >= 0 else UNKNOWN]
                for channel in range(1, picture.shape[2]):
                    picture[i, :, channel] = 0
