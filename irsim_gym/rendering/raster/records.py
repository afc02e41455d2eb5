"""Records for kernels that draw a world: items, sensors, canvas, arrays of the simulation, and scratch memory.

A *plan* is made once for a simulation: rows of items to draw, the lowest first. Positions are read from the
simulation's arrays for each picture.
"""

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Ints, Rays
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State

FOOTPRINT, SHADOW, HEADING, FIELD, GHOSTS, GOAL_CIRCLE, GOAL_MARKS, PATH = range(8)
SCAN, HITS, IMPACT, LABEL, GOAL_LABEL, IMAGE, FOG, SHAPE = range(8, 16)
"""Kinds of items."""
WEDGE, WINDSCREEN, ARROW = 0, 1, 2
"""Marks that show a heading."""
AT_BODY, AT_GOAL = 0, 1
"""Anchors of shapes."""
OWN, CIRCLE, RECTANGLE, CURVE = 0, 1, 2, 3
"""Forms of past outlines: the body's own, a shape around it, its own as a mere line."""
WORLD, WALLS, PLOT, WHOLE, MARKS = 0, 1, 2, 3, 4
"""Boxes: the world, the world with the full lines of its walls, the plot area, the picture, the world and its rim."""
AREA, EDGE, OTHER = 0, 1, 2
"""Rows of an item's colours: of its area, of its edge, and of whatever else it has."""


def _fields(kind: Any, *names: str) -> list[tuple[str, Any]]:
    return [(name, kind) for name in names]


_COUNTS = _fields(np.int64, "kind", "body", "row", "box", "style", "form", "every", "length")
_FLAGS = _fields(np.bool_, "snapped", "turns", "filled", "in_metres")
_NUMBERS = _fields(np.float64, "width", "other_width", "x", "y", "half", "foot", "filled_radius")

ITEM = np.dtype((np.record, [*_COUNTS, *_FLAGS, ("colours", np.float64, (3, 4)), *_NUMBERS]))
"""One item to draw; lengths in pixels unless ``in_metres``, colours [0, 255] with an opacity [0, 1]."""

_PLACES = [*_fields(np.int64, "body", "first", "count"), *_fields(np.bool_, "surrounds", "coloured")]
_MEASURES = _fields(np.float64, "x", "y", "heading", "range_min", "range_max", "full_speed", "mark", "mark_edge")
_INKS = _fields(np.dtype((np.float64, 4)), "rest", "away", "nearer", "rim")

BEAMS = np.dtype((np.record, [*_PLACES, *_MEASURES, *_INKS]))
"""One sensor: its body, its beams in the tables of readings, its pose on the body, and the colours of velocities."""


class RasterCanvas(NamedTuple):
    """A picture to paint on.

    Attributes:
        picture: uint8, shape ``(height, width, n_channels)``.
        sheet: An empty sheet for a picture of this size; empty again afterwards.
        box: Part of the picture that may change.
    """

    picture: Bytes
    sheet: Rays
    box: Ints


class Mark(NamedTuple):
    """A mark that shows a heading: its form, and length and width of an arrow [m]."""

    form: int
    x: float
    y: float


class RasterOutline(NamedTuple):
    """The outline of a body.

    Attributes:
        segments: x0, y0, x1, y1 [m], shape ``(n_segments, 4)``.
        segment_rows: First row and number of the body's segments.
        discs: x, y, radius [m], shape ``(n_discs, 3)``.
        disc_rows: First row and number of the body's discs.
    """

    segments: Floats
    segment_rows: tuple[int, int]
    discs: Floats
    disc_rows: tuple[int, int]


class Readings(NamedTuple):
    """Readings of sensors, and the explored cells.

    Attributes:
        angles: Directions of all beams of all sensors [rad], shape ``(n_beams,)``.
        ranges: Ranges of the beams in the worlds that are drawn [m], shape ``(n, n_beams)``.
        speeds: Radial velocities at the points they hit [m/s], shape ``(n, n_beams)``, or ``(n, 0)`` if there are none.
        explored: Whether each cell is explored, shape ``(n_worlds, n_columns, n_rows)``; empty without fog.
    """

    angles: Floats
    ranges: Rays
    speeds: Floats
    explored: Flags


class Past(NamedTuple):
    """Past poses of bodies; see ``simulator.readings.trails.Trails``.

    Attributes:
        poses: Poses by world, slot and followed body, shape ``(n_worlds, n_slots, n_followed, 3)``.
        noted: Step of each slot, -1 for none, shape ``(n_worlds, n_slots)``.
        latest: Latest step of each world, -1 for none.
    """

    poses: Floats
    noted: Ints
    latest: Ints


class Prints(NamedTuple):
    """Precomputed masks, images and shapes; see ``masks``.

    Attributes:
        masks: Opacities of masks.
        mask_rows: First entry, size and offset of each mask, shape ``(n_masks, 5)``.
        pixels: Colours of images.
        image_rows: First entry and size of each image, shape ``(n_images, 3)``.
        corners: Corners of shapes in the frame of the shape: x, y [m], what to add for each metre of a goal's
            tolerance, and an offset [pixel], shape ``(n_corners, 6)``.
    """

    masks: Bytes
    mask_rows: Ints
    pixels: Bytes
    image_rows: Ints
    corners: Floats


class RasterSource(NamedTuple):
    """Data of a simulation that kernels read.

    Attributes:
        scans: The sensors to draw, as ``BEAMS``.
        model: Constants of the simulation.
        state: Current state.
        readings: Readings of sensors; the rows of ``ranges`` and ``speeds`` belong to pictures.
        past: Past poses of bodies.
        prints: Masks, images and shapes.
    """

    scans: Any
    model: Model
    state: State
    readings: Readings
    past: Past
    prints: Prints


class Scratch(NamedTuple):
    """Scratch memory for drawing; each thread has its own.

    Attributes:
        sheet: See ``sheets``.
        points: Vertices.
        place: Transform of an outline to pixels; see ``ways.paint_outline``.
        colour: A mixed colour.
        cells: Cover of cells by fog.
        struck: Whether each body takes part in a robot's collision.
    """

    sheet: Rays
    points: Floats
    place: Floats
    colour: Floats
    cells: Rays
    struck: Flags


class Look(NamedTuple):
    """Position of the world on the pictures.

    Attributes:
        views: Column and row of the world's origin [pixel], and pixels per metre; shape ``(n, 3)``.
        boxes: The boxes ``WORLD`` to ``MARKS``, shape ``(n, 5, 4)``.
        bounds: The world's rectangle [m]: x_min, y_min, x_max, y_max.
        flag: Width and height of a goal's flag, measured from its foot [pixel].
        flagged: Whether each body's goal is shown.
    """

    views: Floats
    boxes: Ints
    bounds: Floats
    flag: Floats
    flagged: Flags
