"""Occupancy image: the obstacles around the agent as an image."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Cells, Floats, Ints
from irsim_gym.rendering.raster.areas import add_disc
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.world.names import ROBOT, Model, Shard, State, Struct, kernel, kind, option, row_of
from irsim_gym.tasks.observations.images.painting import (
    Canvas,
    Paints,
    SquareImage,
    View,
    add_body,
    add_cells,
    add_outside,
    clear,
    image_column,
    image_row,
    view_from,
)
from irsim_gym.tasks.observations.images.scan_painting import ScanBeams, beams_of, paint_scan
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, Simulation, Term
from irsim_gym.tasks.terms.targets import pushable, without_contacts

LEAST_GOAL = 1.5
"""Minimum radius of the goal's disc [pixel]."""


@dataclass
class Tools(Struct):
    """Memory for painting an occupancy image, the scans if it shows them, and the channel of each body."""

    paints: Paints
    channel: Ints
    beams: ScanBeams | None


@kind
class OccupancyImage(SquareImage):
    """A square image with the agent in the middle: 0 for free space, 255 for obstacles, with smooth edges.

    It is uint8 ``(pixels, pixels, n_channels)``. The first channel shows occupied space, or, with ``from_scan``, the
    lidar's latest scan: 0 free, 255 hit, 127 not seen. ``robot_channel`` adds a channel for other robots,
    ``movable_channel`` one for obstacles that can be pushed, and ``goal_channel`` one with a disc at the goal, or at
    the border if the goal is farther away.
    """

    bodies: bool = option(True, meaning="Show other bodies.")
    map: bool = option(True, meaning="Show the occupied cells of an obstacle map.")
    edge: bool = option(True, meaning="Space outside the world counts as occupied.")
    robot_channel: bool = option(False, meaning="Show other robots in a separate channel instead of the first.")
    movable_channel: bool = option(False, meaning="Show obstacles that can be pushed in a channel of their own.")
    from_scan: bool = option(False, meaning="Show the latest scan of the range sensor instead of the actual obstacles.")
    without_sensor: str | tuple[str, ...] = option("", meaning="With from_scan, as without_sensor of scan.")

    @property
    def needs(self) -> Needs:
        """What a robot must have: scans if it shows them, else the true state of all bodies."""
        kinds: Needs = ("scan", "odometry") if self.from_scan else ("odometry", "bodies")
        return (*kinds, "bodies") if self.from_scan and (self.robot_channel or self.movable_channel) else kinds

    @property
    def image_shape(self) -> tuple[int, int, int]:
        """Height and width [pixels] and number of channels."""
        return self.pixels, self.pixels, 1 + self.robot_channel + self.movable_channel + self.goal_channel

    def misfit(self, scenario: Scenario) -> str | None:
        """Return what the scenario lacks, as text."""
        return without_contacts(scenario) if self.movable_channel else None

    def arrays(self, simulation: Simulation, agents: Ints) -> Tools:
        """Return the memory for painting, the scans if it shows them, and the channel of each body."""
        paints = Paints.of(simulation, self.pixels, self.pixels, [[0.0, 1.0], [255.0, 1.0]])
        channel = np.where(simulation.model.role == ROBOT, int(self.robot_channel), 0)
        if self.movable_channel:
            channel[pushable(simulation.scenario)] = 1 + self.robot_channel
        return Tools(paints, channel, beams_of(simulation, agents, "occupancy_image") if self.from_scan else None)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the channels."""
        seen = "the scan: 0 free, 127 not seen, 255 hit" if self.from_scan else "0 free, 255 occupied"
        channels = [Columns("obstacles around the robot", seen)]
        if self.robot_channel:
            channels.append(Columns("other robots", "255 where one is"))
        if self.movable_channel:
            channels.append(Columns("obstacles that can be pushed", "255 where one is"))
        if self.goal_channel:
            channels.append(Columns("the next goal", "255 where it is, at the border where it is farther away"))
        return channels

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Paint the image."""
        options, tools, bound, image = term.options, term.arrays, term.bound, term.image
        worlds, slot, paints = shard.worlds, shard.slot, tools.paints
        if tools.beams is not None:
            paint_scan(worlds, slot, bound, tools.beams, paints, state, image)
        else:
            cells = model.cells if options.map else None
            paint_occupied(worlds, slot, bound, tools, model, cells, state, image)
        for channel in range(1, 1 + options.robot_channel + options.movable_channel):
            paint_apart(worlds, slot, bound, tools, channel, model, state, image)
        if options.goal_channel:
            paint_goal(worlds, slot, bound, paints, model, state, image)


@kernel
def paint_occupied(
    worlds: Ints, slot: int, term: Bound, tools: Tools, model: Model, cells: Cells, state: State, image: Bytes
) -> None:
    """Clear the images, and paint occupied space into their first channel.

    Reads: term (agents, options), tools (channel, paints), model (bounds, disc_count, disc_start, present, reach,
        segment_count, segment_start, solid, unobstructed), state (discs, pose, segments).
    Writes: tools (paints), image.

    Args:
        worlds: The worlds to treat.
        slot: Slot of the calling thread.
        term: An ``OccupancyImage``.
        tools: The colours free and occupied, in this order, and the channel of each body.
        model: Constants of the simulation.
        cells: The map, or None.
        state: Its present state.
        image: Output, ``(n_worlds, n_agents, pixels, pixels, n_channels)``.
    """
    options, channel, paints = term.options[0], tools.channel, tools.paints
    box, sheet = paints.box, paints.sheets[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, body = image[w, a], term.agents[a]
            clear(picture, 0)
            canvas = Canvas(sheet, box, view_of(term, state.pose[w, body]))
            if options.bodies != 0:
                for b in range(channel.shape[0]):
                    if model.present[w, b] and channel[b] == 0 and b != body and not model.unobstructed[b]:
                        add_body(canvas, model, state, w, b)
            if options.edge != 0:
                add_outside(canvas, model.bounds)
            add_cells(canvas, cells, w)
            paint(picture[:, :, :1], sheet, box, paints.colours[1], False)


@kernel(inlined=True)
def view_of(term: Bound, pose: Floats) -> View:
    """Return the view of an agent at a pose.

    Reads: term (options).
    """
    options = term.options[0]
    return view_from(pose, options.rotated != 0, options.pixels / options.metres, options.pixels)


@kernel
def paint_apart(
    worlds: Ints, slot: int, term: Bound, tools: Tools, channel: int, model: Model, state: State, image: Bytes
) -> None:
    """Paint the bodies of another channel than the first into it; see ``paint_occupied``.

    Reads: term (agents, options), tools (channel, paints), model (disc_count, disc_start, present, reach,
        segment_count, segment_start, solid, unobstructed), state (discs, pose, segments).
    Writes: tools (paints).
    """
    paints = tools.paints
    box, sheet = paints.box, paints.sheets[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, body = image[w, a], term.agents[a]
            canvas = Canvas(sheet, box, view_of(term, state.pose[w, body]))
            for b in range(tools.channel.shape[0]):
                if tools.channel[b] == channel and b != body and model.present[w, b] and not model.unobstructed[b]:
                    add_body(canvas, model, state, w, b)
            paint(picture[:, :, channel : channel + 1], sheet, box, paints.colours[1], False)


@kernel
def paint_goal(worlds: Ints, slot: int, term: Bound, paints: Paints, model: Model, state: State, image: Bytes) -> None:
    """Paint the goal into the last channel; see ``paint_occupied``.

    The radius of its disc is the goal threshold, at least ``LEAST_GOAL``. A disc that would not lie completely in the
    image touches the border instead, in the direction of the goal.

    Reads: term (agents, options), paints (box, colours, sheets), model (goal_threshold, has_goal), state (goal, pose).
    Writes: paints (sheets).
    """
    box, sheet = paints.box, paints.sheets[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, body = image[w, a], term.agents[a]
            if not model.has_goal[body]:
                continue
            view, half = view_of(term, state.pose[w, body]), 0.5 * picture.shape[0]
            x, y = state.goal[w, body, 0], state.goal[w, body, 1]
            aside, below = image_column(view, x, y) - half, image_row(view, x, y) - half
            radius = max(model.goal_threshold[row_of(model.goal_threshold, w), body] * view.scale, LEAST_GOAL)
            away = max(np.abs(aside), np.abs(below))
            # A goal beyond the image is drawn towards the middle until its disc touches the border from within.
            share = max(half - radius, 0.0) / away if away > half - radius else 1.0
            add_disc(sheet, box, half + share * aside, half + share * below, radius, 1.0)
            last = picture.shape[2] - 1
            paint(picture[:, :, last:], sheet, box, paints.colours[1], False)
