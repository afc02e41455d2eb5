"""The boundary of a footprint: as it is declared, and as the arrays hold it."""

import math
from dataclasses import dataclass, field

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Floats
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.simulator.world.state import State

CIRCLE_CORNERS = 64
"""Points that stand for the outline of a circle, where IR-SIM has them."""


@dataclass(frozen=True)
class Outline:
    """Segments and discs that make up a footprint.

    Attributes:
        segments: x0, y0, x1, y1 of each segment [m], shape ``(n_segments, 4)``.
        discs: x, y, radius of each disc [m], shape ``(n_discs, 3)``.
        solid: The segments are the closed boundary of an area, not a curve.
        centroid: Centre of the area [m], where parts that overlap would count twice; else it is worked out.
        parts: Corners of the polygons that it is the union of [m], ``(n, 2)`` each; empty for a simple outline.
    """

    segments: Floats = field(default_factory=lambda: np.zeros((0, 4)))
    discs: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    solid: bool = True
    centroid: tuple[float, float] | None = None
    parts: tuple[Floats, ...] = ()


def chain(vertices: Floats, *, closed: bool) -> Floats:
    """Return the segments that join vertices ``(n, 2)`` [m] in order, shape ``(n_segments, 4)``."""
    # A closed chain also joins the last vertex to the first one.
    ends = np.roll(vertices, -1, axis=0) if closed else vertices[1:]
    starts = vertices if closed else vertices[:-1]
    return np.hstack([starts, ends])


def outline_rows(model: Model, state: State, world: int, body: int, *, local: bool = False) -> tuple[Floats, Floats]:
    """Return a body's segments (x0, y0, x1, y1) and discs (x, y, radius) [m] in the world frame, or in its own."""
    segments, discs = (model.local_segments, model.local_discs) if local else (state.segments, state.discs)
    start, count = int(model.segment_start[body]), model.segment_count
    first, n_discs = int(model.disc_start[body]), model.disc_count
    return (
        segments[world % len(segments), start : start + count[world % len(count), body]],
        discs[world % len(discs), first : first + n_discs[world % len(n_discs), body]],
    )


def placed(segments: Floats, discs: Floats, pose: tuple[float, float, float]) -> tuple[Floats, Floats]:
    """Return an outline in its own frame as it stands at a pose x, y, heading [m, m, rad]."""
    x, y, heading = pose
    cosine, sine = math.cos(heading), math.sin(heading)
    # The transpose of the usual rotation matrix, because points are rows and stand on its left.
    turn, at = np.array([[cosine, sine], [-sine, cosine]]), np.array([x, y])
    ends = np.hstack([segments[:, :2] @ turn + at, segments[:, 2:] @ turn + at])
    return ends, np.column_stack([discs[:, :2] @ turn + at, discs[:, 2]])


def corner_points(segments: Floats, discs: Floats, heading: float, *, rounds: bool = False) -> Floats:
    """Return the corners of an outline [m], shape ``(n, 2)``; none of a circle.

    Args:
        segments: Its segments.
        discs: Its discs.
        heading: Heading of its body [rad].
        rounds: Return 64 corners of a circle, clockwise from the heading, as IR-SIM has them.
    """
    if rounds and len(discs) == 1 and not len(segments):
        turns = heading - np.linspace(0.0, 2.0 * np.pi, CIRCLE_CORNERS, endpoint=False)
        circle: Floats = discs[0, :2] + discs[0, 2] * np.column_stack([np.cos(turns), np.sin(turns)])
        return circle
    is_open = len(segments) > 0 and not np.array_equal(segments[-1, 2:], segments[0, :2])
    return np.vstack([segments[:, :2], segments[-1:, 2:]]) if is_open else segments[:, :2]


def extent(segments: Floats, discs: Floats) -> tuple[float, float]:
    """Return length and width of an outline along its axes [m]."""
    ends = [segments[:, :2], segments[:, 2:], discs[:, :2] - discs[:, 2:], discs[:, :2] + discs[:, 2:]]
    corners = np.vstack(ends)
    if not len(corners):
        return 0.0, 0.0
    length, width = corners.max(axis=0) - corners.min(axis=0)
    return float(length), float(width)


@kernel
def outline_of(model: Model, state: State, w: int, b: int) -> BodyOutline:
    """Return the outline of body b of world w in the world frame.

    Reads: model (disc_count, disc_start, segment_count, segment_start, solid), state (discs, segments).
    """
    return BodyOutline(
        state.segments[w], model.segment_start[b], model.segment_count[row_of(model.segment_count, w), b],
        state.discs[w], model.disc_start[b], model.disc_count[row_of(model.disc_count, w), b], model.solid[b],
    )  # fmt: skip


@kernel
def own_outline(model: Model, w: int, b: int) -> BodyOutline:
    """Return the outline of body b of world w in its own frame.

    Reads: model (disc_count, disc_start, local_discs, local_segments, segment_count, segment_start, solid).
    """
    return BodyOutline(
        model.local_segments[row_of(model.local_segments, w)], model.segment_start[b],
        model.segment_count[row_of(model.segment_count, w), b],
        model.local_discs[row_of(model.local_discs, w)], model.disc_start[b],
        model.disc_count[row_of(model.disc_count, w), b], model.solid[b],
    )  # fmt: skip


@kernel(inlined=True)
def place_outline(model: Model, state: State, w: int, b: int) -> None:
    """Write the outline of body b of world w at its pose.

    A vertex that two segments share in the body frame is shared bit for bit in the world frame.

    Reads: model (disc_count, disc_start, local_discs, local_segments, segment_count, segment_start, solid), state
        (discs, pose, segments).
    Writes: state (discs, segments).
    """
    local_segments = model.local_segments[row_of(model.local_segments, w)]
    local_discs = model.local_discs[row_of(model.local_discs, w)]
    x, y, heading = state.pose[w, b, 0], state.pose[w, b, 1], state.pose[w, b, 2]
    _, first_segment, n_segments, _, first_disc, n_discs, _ = outline_of(model, state, w, b)
    segments, discs = state.segments[w], state.discs[w]
    # A disc around the origin looks the same at any heading: the usual robot needs no cosine and no sine.
    is_turned = n_segments > 0
    for d in range(first_disc, first_disc + n_discs):
        is_turned = is_turned or local_discs[d, 0] != 0.0 or local_discs[d, 1] != 0.0
    cosine, sine = (np.cos(heading), np.sin(heading)) if is_turned else (1.0, 0.0)
    for s in range(first_segment, first_segment + n_segments):
        ax, ay, bx, by = local_segments[s, 0], local_segments[s, 1], local_segments[s, 2], local_segments[s, 3]
        segments[s, 0] = x + (cosine * ax - sine * ay)
        segments[s, 1] = y + (sine * ax + cosine * ay)
        segments[s, 2] = x + (cosine * bx - sine * by)
        segments[s, 3] = y + (sine * bx + cosine * by)
    for d in range(first_disc, first_disc + n_discs):
        cx, cy = local_discs[d, 0], local_discs[d, 1]
        discs[d, 0] = x + (cosine * cx - sine * cy)
        discs[d, 1] = y + (sine * cx + cosine * cy)
        discs[d, 2] = local_discs[d, 2]
