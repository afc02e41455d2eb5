"""What a picture of a world consists of, as records that kernels read.

A *plan* is made once for a simulation: rows that say what is drawn, lowest first. Where things are is read from the
simulation's arrays for each picture.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags, Floats, Ints, Rays

(
    FOOTPRINT,
    SHADOW,
    HEADING,
    FIELD,
    GHOSTS,
    GOAL_CIRCLE,
    GOAL_MARKS,
    PATH,
    SCAN,
    HITS,
    IMPACT,
    LABEL,
    GOAL_LABEL,
    IMAGE,
    FOG,
    SHAPE,
) = range(16)
"""Kinds of what is drawn."""
WEDGE, WINDSCREEN, ARROW = 0, 1, 2
AT_BODY, AT_GOAL = 0, 1
"""Where a shape stands."""
OWN, CIRCLE, RECTANGLE, CURVE = 0, 1, 2, 3
WORLD, WALLS, PLOT, WHOLE, MARKS = 0, 1, 2, 3, 4
"""Boxes: the world, the same and its walls' whole lines, the drawing area, the picture, the world and its rim."""
AREA, EDGE, OTHER, LAST = 0, 1, 2, 3

ITEM = np.dtype(
    (
        np.record,
        [
            ("kind", np.int64),
            ("body", np.int64),
            ("row", np.int64),
            ("box", np.int64),
            ("style", np.int64),
            ("form", np.int64),
            ("every", np.int64),
            ("length", np.int64),
            ("snapped", np.bool_),
            ("turns", np.bool_),
            ("filled", np.bool_),
            ("in_metres", np.bool_),
            ("colours", np.float64, (4, 4)),
            ("width", np.float64),
            ("other_width", np.float64),
            ("x", np.float64),
            ("y", np.float64),
            ("half", np.float64),
            ("foot", np.float64),
            ("filled_radius", np.float64),
        ],
    )
)
"""One thing that is drawn; lengths in pixels unless ``in_metres``, colours [0, 255] with an opacity [0, 1]."""

BEAMS = np.dtype(
    (
        np.record,
        [
            ("body", np.int64),
            ("first", np.int64),
            ("count", np.int64),
            ("x", np.float64),
            ("y", np.float64),
            ("heading", np.float64),
            ("range_min", np.float64),
            ("range_max", np.float64),
            ("surrounds", np.bool_),
            ("coloured", np.bool_),
            ("full_speed", np.float64),
            ("mark", np.float64),
            ("mark_edge", np.float64),
            ("rest", np.float64, (4,)),
            ("away", np.float64, (4,)),
            ("nearer", np.float64, (4,)),
            ("rim", np.float64, (4,)),
        ],
    )
)
"""One sensor: its body, its beams in the tables of readings, its place on the body, and how velocities look."""


class RasterCanvas(NamedTuple):
    """Where something is painted.

    Attributes:
        picture: uint8, shape ``(height, width, n_channels)``.
        sheet: An empty sheet of its size, left empty.
        box: Which part of the picture may change.
    """

    picture: Bytes
    sheet: Rays
    box: Ints


class RasterOutline(NamedTuple):
    """The outline of a body.

    Attributes:
        segments: x0, y0, x1, y1 [m], shape ``(n_segments, 4)``.
        segment_rows: First row and number of its segments.
        discs: x, y, radius [m], shape ``(n_discs, 3)``.
        disc_rows: First row and number of its discs.
    """

    segments: Floats
    segment_rows: tuple[int, int]
    discs: Floats
    disc_rows: tuple[int, int]


class Model(NamedTuple):
    """Arrays of ``WorldModel``."""

    role: Ints
    solid: Flags
    drive: Ints
    has_goal: Flags
    goal_threshold: Floats
    arrive_mode: Ints
    segment_start: Ints
    segment_count: Ints
    local_segments: Floats
    disc_start: Ints
    disc_count: Ints
    local_discs: Floats
    present: Flags
    waypoints: Floats
    waypoint_count: Ints


class State(NamedTuple):
    """Arrays of ``WorldState``."""

    pose: Floats
    twist: Floats
    segments: Floats
    discs: Floats
    goal: Floats
    waypoint: Ints
    arrived: Flags
    collided: Flags
    hit: Ints


class Readings(NamedTuple):
    """What sensors and robots have seen.

    Attributes:
        angles: Directions of all beams of all sensors [rad], shape ``(n_beams,)``.
        ranges: Their ranges in the worlds that are drawn [m], shape ``(n, n_beams)``.
        speeds: Radial velocities of what they hit [m/s], shape ``(n, n_beams)`` or ``(n, 0)`` without any.
        explored: Which cells were seen, shape ``(n_worlds, n_columns, n_rows)``; nothing where there is no fog.
    """

    angles: Floats
    ranges: Rays
    speeds: Floats
    explored: Flags


class Past(NamedTuple):
    """Where bodies have been, see ``world.trails.Trails``.

    Attributes:
        poses: Poses by world, slot and body that is followed, shape ``(n_worlds, n_slots, n_followed, 3)``.
        noted: The step of each slot, -1 for none, shape ``(n_worlds, n_slots)``.
        latest: The latest step of each world, -1 for none.
    """

    poses: Floats
    noted: Ints
    latest: Ints


class Prints(NamedTuple):
    """Ready-made masks, images and shapes, see ``masks``.

    Attributes:
        masks: Opacities of masks.
        mask_rows: Their places, shape ``(n_masks, 5)``.
        pixels: Colours of images.
        image_rows: Their places, shape ``(n_images, 3)``.
        corners: Corners of shapes in a frame of their own: x, y [m], the same for each metre of a goal's tolerance, and
            what is added to both [pixel], shape ``(n_corners, 6)``.
    """

    masks: Bytes
    mask_rows: Ints
    pixels: Bytes
    image_rows: Ints
    corners: Floats


class RasterSource(NamedTuple):
    """What is read of a simulation.

    Attributes:
        scans: Its sensors, ``BEAMS``.
        model: Its constants.
        state: Its present state.
        readings: What its sensors have read; rows go by picture.
        past: Where its bodies have been.
        prints: Masks, images and shapes.
    """

    scans: Any
    model: Model
    state: State
    readings: Readings
    past: Past
    prints: Prints


class Scratch(NamedTuple):
    """Memory to draw with, one for each thread.

    Attributes:
        sheet: See ``sheets``.
        points: Room for vertices.
        place: Where an outline is, see ``ways.paint_outline``.
        colour: A colour that was mixed.
        cells: Room for fog.
        struck: Which bodies take part in a robot's collision.
    """

    sheet: Rays
    points: Floats
    place: Floats
    colour: Floats
    cells: Rays
    struck: Flags


class Look(NamedTuple):
    """Where the world is on a picture.

    Attributes:
        views: Column and row of the world's origin [pixel], pixels per metre; shape ``(n, 3)``.
        boxes: The boxes ``WORLD`` to ``MARKS``, shape ``(n, 5, 4)``.
        bounds: The world's rectangle [m]: x_min, y_min, x_max, y_max.
        flag: Width and height of a goal's flag, from its foot [pixel].
        flagged: Which bodies' goals are shown.
    """

    views: Floats
    boxes: Ints
    bounds: Floats
    flag: Floats
    flagged: Flags
