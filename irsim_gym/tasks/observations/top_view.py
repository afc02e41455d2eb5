"""Top view: the image of a camera above the agent, or above the whole world."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import ClassVar, Literal

import numpy as np

from irsim_gym.arraytypes import Bytes, CellMaps, Floats, Ints
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.raster.areas import add_disc
from irsim_gym.raster.sheets import paint
from irsim_gym.scenario.options import kind, option
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import IN_WORLD, Mirrored, sectors_exchanged
from irsim_gym.tasks.observations.painting import (
    Canvas,
    Paints,
    View,
    add_body,
    add_cells,
    add_outside,
    add_side,
    around,
    image_column,
    image_row,
    view_from,
)
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import OBSTACLE, ROBOT, Model
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import State

COLOURS = ("background", "outside", "obstacles", "goals", "robots", "itself", "headings")
BACKGROUND, OUTSIDE, OBSTACLES, GOALS, ROBOTS, ITSELF, HEADINGS = range(len(COLOURS))
WHOLE_WORLD = 1
"""The number of ``follow: world`` in the records of options."""
NOBODY = -1
"""Value for excluding no body."""


@kind
class TopView:
    """A square colour image, seen from above, with smooth edges.

    It is uint8 ``(pixels, pixels, 3)``: red, green, blue. The agent, other robots, obstacles and the agent's goal have
    different colours, and a triangle on each robot points ahead. ``follow: robot`` keeps the agent in the middle,
    ``follow: world`` shows the whole world.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = False

    pixels: int = option(
        64, ge=8, le=1024, unit="pixel", meaning="Height and width; Stable-Baselines3 needs at least 36."
    )
    follow: Literal["robot", "world"] = option("robot", meaning="What stays in the middle of the picture.")
    metres: float = option(8.0, gt=0.0, unit="m", meaning="Height and width of the area around a robot.")
    rotated: bool = option(True, meaning="Around a robot, its heading points up; otherwise the world's y axis does.")
    background: str = option("#f4f5f7", meaning="Colour of free ground, as #rrggbb like all others.")
    outside: str = option("#aab2bd", meaning="Colour of space outside the world.")
    obstacles: str = option("#3d4451", meaning="Colour of obstacles and maps.")
    goals: str = option("#2fb344", meaning="Colour of the agent's next goal.")
    robots: str = option("#f59f00", meaning="Colour of other robots.")
    itself: str = option("#1c6dd0", meaning="Colour of the agent.")
    headings: str = option("#ffffff", meaning="Colour of the triangle that points ahead.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid colours."""
        for name in COLOURS:
            if not re.fullmatch("#[0-9a-fA-F]{6}", getattr(self, name)):
                yield name, f"must be a colour such as '#1c6dd0', got '{getattr(self, name)}'"

    @property
    def image_shape(self) -> tuple[int, int, int]:
        """Height and width [pixels] and number of channels."""
        return self.pixels, self.pixels, 3

    def arrays(self, simulation: Simulation, agents: Ints) -> Paints:
        """Return memory for painting, with the colours and their opacity, ``(n_colours, 4)``."""
        colours = [[*bytes.fromhex(getattr(self, name)[1:]), 1.0] for name in COLOURS]
        return Paints.of(simulation, self.pixels, self.pixels, colours)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the channels."""
        return [Columns(f"{name} of the picture", "0 to 255") for name in ("red", "green", "blue")]

    @property
    def view(self) -> str:
        """Description of the image's area and orientation."""
        if self.follow == "world":
            return "all of the world; its y axis is up, x to the right"
        return around(self.metres, self.pixels, self.rotated)

    def mirrored(self, term: Term) -> Mirrored | str:
        """Return the columns of pixels from right to left; a reason if the axes of the world point up and right."""
        return sectors_exchanged(self.pixels) if self.follow == "robot" and self.rotated else IN_WORLD

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Paint the image."""
        worlds, slot, cells = shard.worlds, shard.slot, model.cells
        paint_view(worlds, slot, term.bound, term.arrays, model, cells, state, term.image)


@kernel
def paint_view(
    worlds: Ints,
    slot: int,
    term: Bound,
    paints: Paints,
    model: Model,
    cells: CellMaps | None,
    state: State,
    image: Bytes,
) -> None:
    """Paint the images.

    Reads: term (agents, options), paints (box, colours, sheets), model (bounds, disc_count, disc_start, goal_threshold,
        has_goal, present, reach, role, segment_count, segment_start, solid), state (discs, goal, pose, segments).
    Writes: paints (sheets), image.

    Args:
        worlds: The worlds to treat.
        slot: Slot of the calling thread.
        term: A ``TopView``.
        paints: The colours in the order of ``COLOURS``.
        model: Constants of the simulation.
        cells: The map, or None.
        state: Its present state.
        image: Output, ``(n_worlds, n_agents, pixels, pixels, 3)``.
    """
    options, box, sheet, colours = term.options[0], paints.box, paints.sheets[slot], paints.colours
    scale = options.pixels / options.metres
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, own = image[w, a], term.agents[a]
            view = view_from(state.pose[w, own], options.rotated != 0, scale, picture.shape[0])
            if options.follow == WHOLE_WORLD:
                view = view_of_all(model.bounds, picture.shape[0])
            canvas = Canvas(sheet, box, view)
            fill(picture, colours[BACKGROUND])
            add_outside(canvas, model.bounds)
            paint(picture, sheet, box, colours[OUTSIDE], False)
            if model.has_goal[own]:
                x, y = state.goal[w, own, 0], state.goal[w, own, 1]
                radius = max(model.goal_threshold[row_of(model.goal_threshold, w), own] * view.scale, 1.5)
                add_disc(sheet, box, image_column(view, x, y), image_row(view, x, y), radius, 1.0)
                paint(picture, sheet, box, colours[GOALS], False)
            add_cells(canvas, cells, w)
            add_bodies(canvas, model, state, w, OBSTACLE, NOBODY)
            paint(picture, sheet, box, colours[OBSTACLES], False)
            add_bodies(canvas, model, state, w, ROBOT, own)
            paint(picture, sheet, box, colours[ROBOTS], False)
            if model.present[w, own]:
                add_body(canvas, model, state, w, own)
                paint(picture, sheet, box, colours[ITSELF], False)
            add_headings(canvas, model, state, w)
            paint(picture, sheet, box, colours[HEADINGS], False)


@kernel
def view_of_all(bounds: Floats, pixels: int) -> View:
    """Return a view of the whole world, with its y axis up."""
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    x, y = bounds[0] + 0.5 * width, bounds[1] + 0.5 * height
    return View(x, y, 0.0, 1.0, pixels / max(width, height), 0.5 * pixels, 0.5 * pixels)


@kernel
def fill(picture: Bytes, colour: Floats) -> None:
    """Fill an image of three channels with a colour."""
    red, green, blue = int(colour[0]), int(colour[1]), int(colour[2])
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            picture[row, column, 0] = red
            picture[row, column, 1] = green
            picture[row, column, 2] = blue


@kernel
def add_bodies(canvas: Canvas, model: Model, state: State, w: int, role: int, but: int) -> None:
    """Add the present bodies of a role in a world to a sheet, except ``but``.

    Reads: model (disc_count, disc_start, present, reach, role, segment_count, segment_start, solid), state (discs,
        pose, segments).
    """
    for b in range(model.role.shape[0]):
        if model.role[b] == role and b != but and model.present[w, b]:
            add_body(canvas, model, state, w, b)


@kernel
def add_headings(canvas: Canvas, model: Model, state: State, w: int) -> None:
    """Add a triangle that points ahead on each robot to a sheet.

    Reads: model (present, reach, role), state (pose).
    """
    for b in range(model.role.shape[0]):
        if model.role[b] != ROBOT or not model.present[w, b]:
            continue
        size = model.reach[row_of(model.reach, w), b]
        x, y, heading = state.pose[w, b, 0], state.pose[w, b, 1], state.pose[w, b, 2]
        ahead_x, ahead_y = size * np.cos(heading), size * np.sin(heading)
        aside_x, aside_y = -0.5 * ahead_y, 0.5 * ahead_x
        tip = x + 0.9 * ahead_x, y + 0.9 * ahead_y
        left, right = (x + aside_x, y + aside_y), (x - aside_x, y - aside_y)
        add_side(canvas, tip, left)
        add_side(canvas, left, right)
        add_side(canvas, right, tip)
