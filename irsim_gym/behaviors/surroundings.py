"""What a body sees of the others: discs that move, walls that stand, and the walls of an occupancy map."""

from __future__ import annotations

from operator import attrgetter
from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import BodyOutline, Bytes, Flags, Floats, Ints, Record, Records
from irsim_gym.geometry.buckets import find_nearby
from irsim_gym.geometry.overlap import point_outline_distance
from irsim_gym.jit import kernel
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

MARGIN = 0.1
"""Added to the radius of every disc [m], as in IR-SIM."""

SLACK = 1.0 + 1e-12
"""What is farther away than a limit times this is certainly beyond it, whatever the rounding."""

NOTHING, CHAIN, STANDING, ROUND = 0, 1, 2, 3
"""How a body looks: not at all, as segments without area, as its outline, as the disc around its centroid."""

ALL_ROLES = 0
"""``target_roles: all``; the role r alone is r + 1."""


class Scene(NamedTuple):
    """The arrays of all worlds that anyone reads who looks around: those of ``WorldModel``, then ``WorldState``'s.

    Kernels take their rows out of it once for each body: passing all of it on costs as much as looking at ten others.
    """

    role: Ints
    movable: Flags
    solid: Flags
    present: Flags
    radius: Floats
    centroid: Floats
    reach: Floats
    segment_start: Ints
    segment_count: Ints
    disc_start: Ints
    disc_count: Ints
    map_frame: Records
    map_squares: Bytes
    bucket_frame: Records
    bucket_first: Ints
    bucket_next: Ints
    segments: Floats
    discs: Floats
    pose: Floats
    twist: Floats


_OF_MODEL = attrgetter(*(name for name in Scene._fields if name in WorldModel.__dataclass_fields__))
_OF_STATE = attrgetter(*(name for name in Scene._fields if name in WorldState.__dataclass_fields__))


def scene_of(model: WorldModel, state: WorldState) -> Scene:
    """Return what anyone reads who looks around."""
    return Scene(*_OF_MODEL(model), *_OF_STATE(state))


def wall_bodies(model: WorldModel) -> Ints:
    """Return the bodies that are chains of segments without area."""
    return np.flatnonzero(~model.solid & (model.segment_count.max(axis=0) > 0))


def most_map_walls(model: WorldModel, threshold: float) -> int:
    """Return an upper bound of the number of map walls within ``threshold`` [m] of a point."""
    if (chart := model.cells) is None:
        return 0
    cells = [
        min(float(count), 2.0 * threshold / side + 2.0)
        for count, side in zip(chart.room.shape, (chart.width, chart.height), strict=True)
    ]
    return int(2.0 * (cells[0] + 1.0) * (cells[1] + 1.0)) + 1


@kernel
def is_seen(b: int, q: int, target_roles: int, role: Ints, present: Flags) -> bool:
    """Return whether body b pays heed to body q: another one that is there and has the role, unobstructed or not."""
    if q == b or not present[q]:
        return False
    return bool(target_roles == ALL_ROLES or role[q] == target_roles - 1)


@kernel
def is_map_seen(target_roles: int, frame: Record, role: Ints, present: Flags) -> bool:
    """Return whether there is an occupancy map to pay heed to; its body has no outline to look at."""
    chart = frame.body
    if chart < 0 or not present[chart]:
        return False
    return bool(target_roles == ALL_ROLES or role[chart] == target_roles - 1)


@kernel
def look_of(n_segments: int, n_discs: int, solid: bool, movable: bool) -> int:
    """Return how a body looks: one that never moves and is more than a disc shows its outline."""
    if n_segments + n_discs == 0:
        return NOTHING
    if n_segments > 0 and not solid:
        return CHAIN
    return STANDING if not movable and (n_segments > 0 or n_discs > 1) else ROUND


@kernel
def centroid_of(pose: Floats, centroid: Floats) -> tuple[float, float]:
    """Return the centre of a body's area in the world frame [m]."""
    x, y = centroid[0], centroid[1]
    if x == 0.0 and y == 0.0:
        return pose[0], pose[1]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + (cosine * x - sine * y), pose[1] + (sine * x + cosine * y)


@kernel
def look_around(
    scene: Scene,
    w: int,
    b: int,
    target_roles: int,
    sight: float,
    lines: Ints,
    nearby: Ints,
    rounds: Floats,
    sides: Floats,
) -> tuple[int, int]:
    """Write the discs and the segments that a body avoids; return how many of each.

    A body is the disc around its centroid, seen when that is nearer than ``sight`` [m]. One that stands and has sides
    is its outline, seen when any of that is nearer. A chain of segments is always seen, the walls of a map when near.

    Args:
        scene: What there is.
        w: The world.
        b: The body that looks.
        target_roles: ALL_ROLES, or the role that it sees plus 1.
        sight: How far it sees [m].
        lines: Bodies that are chains of segments.
        nearby: Scratch, shape ``(body,)``.
        rounds: Written: x, y, vx, vy, radius with MARGIN [m, m/s], shape ``(n, 5)`` or wider.
        sides: Written: x0, y0, x1, y1 [m], shape ``(n, 4)``.
    """
    pose, frame, role, present = scene.pose[w], scene.bucket_frame[0], scene.role, scene.present[w]
    n_segments, n_discs = (
        scene.segment_count[row_of(scene.segment_count, w)],
        scene.disc_count[row_of(scene.disc_count, w)],
    )
    centroid, radius = scene.centroid[row_of(scene.centroid, w)], scene.radius[row_of(scene.radius, w)]
    reach, segments, discs = scene.reach[row_of(scene.reach, w)], scene.segments[w], scene.discs[w]
    x, y = pose[b, 0], pose[b, 1]
    n_nearby = find_nearby(x, y, sight + frame.reach, frame, scene.bucket_first[w], scene.bucket_next[w], nearby)
    n_rounds, n_sides = 0, 0
    for k in range(n_nearby):
        q = nearby[k]
        dx, dy, far = pose[q, 0] - x, pose[q, 1] - y, sight + reach[q]
        if dx * dx + dy * dy > far * far * SLACK or not is_seen(b, q, target_roles, role, present):
            continue
        look = look_of(n_segments[q], n_discs[q], scene.solid[q], scene.movable[q])
        if look == STANDING:
            s, n, d, m = scene.segment_start[q], n_segments[q], scene.disc_start[q], n_discs[q]
            if point_outline_distance(x, y, BodyOutline(segments, s, n, discs, d, m, scene.solid[q])) < sight:
                n_sides = copy_sides(segments, s, n, sides, n_sides)
                n_rounds = copy_discs(discs, d, m, rounds, n_rounds)
        if look == ROUND:
            cx, cy = centroid_of(pose[q], centroid[q])
            if (x - cx) * (x - cx) + (y - cy) * (y - cy) < sight * sight:
                rounds[n_rounds, 0], rounds[n_rounds, 1] = cx, cy
                rounds[n_rounds, 2], rounds[n_rounds, 3] = scene.twist[w, q, 0], scene.twist[w, q, 1]
                rounds[n_rounds, 4] = radius[q] + MARGIN
                n_rounds += 1
    for q in lines:
        if is_seen(b, q, target_roles, role, present):
            n_sides = copy_sides(segments, scene.segment_start[q], n_segments[q], sides, n_sides)
    if is_map_seen(target_roles, scene.map_frame[0], role, present):
        n_sides = map_walls(x, y, sight, scene.map_frame[0], scene.map_squares, sides, n_sides)
    return n_rounds, n_sides


@kernel
def copy_discs(discs: Floats, start: int, count: int, rounds: Floats, n_rounds: int) -> int:
    """Append discs that stand to ``rounds``; return how many those are now."""
    for d in range(start, start + count):
        rounds[n_rounds, 0], rounds[n_rounds, 1] = discs[d, 0], discs[d, 1]
        rounds[n_rounds, 2], rounds[n_rounds, 3] = 0.0, 0.0
        rounds[n_rounds, 4] = discs[d, 2] + MARGIN
        n_rounds += 1
    return n_rounds


@kernel
def copy_sides(segments: Floats, start: int, count: int, sides: Floats, n_sides: int) -> int:
    """Append segments to ``sides``; return how many those are now."""
    for s in range(start, start + count):
        for column in range(4):
            sides[n_sides, column] = segments[s, column]
        n_sides += 1
    return n_sides


@kernel
def map_walls(x: float, y: float, threshold: float, frame: Record, squares: Bytes, sides: Floats, n_sides: int) -> int:
    """Append the borders between occupied and free cells near a point to ``sides``; return how many those are now.

    Borders in a line are one segment, with the free cells to its left. What lies outside of the map is free. Those for
    which ``sides`` has no more rows are left out.

    Args:
        x: The point [m].
        y: The point [m].
        threshold: Borders of cells that are nearer than this [m].
        frame: ``model.map_frame[0]``.
        squares: ``model.map_squares``.
        sides: Written, x0, y0, x1, y1 [m], shape ``(n, 4)``.
        n_sides: Number of rows in use.
    """
    for axis in range(2):
        low, across = (frame.y, frame.x) if axis == 0 else (frame.x, frame.y)
        pitch, width = (frame.height, frame.width) if axis == 0 else (frame.width, frame.height)
        height, place = (y, x) if axis == 0 else (x, y)
        lines, cells = squares.shape[2 - axis], squares.shape[1 + axis]
        first = int(max(np.ceil((height - threshold - low) / pitch), 0.0))
        last = int(min(np.floor((height + threshold - low) / pitch), float(lines)))
        for line in range(first, last + 1):
            level = low + line * pitch
            half = np.sqrt(max(threshold * threshold - (level - height) * (level - height), 0.0))
            begin = int(max(np.floor((place - half - across) / width), 0.0))
            end = int(min(np.floor((place + half - across) / width), cells - 1.0))
            start, going = begin, 0
            for cell in range(begin, end + 2):
                border = 0
                if cell <= end:
                    border = int(is_occupied(squares, axis, cell, line)) - int(
                        is_occupied(squares, axis, cell, line - 1)
                    )
                if border == going:
                    continue
                if going != 0:
                    if n_sides == sides.shape[0]:
                        return n_sides
                    along0, along1 = across + start * width, across + cell * width
                    if (going > 0) == (axis == 0):
                        along0, along1 = along1, along0
                    sides[n_sides, axis], sides[n_sides, 1 - axis] = along0, level
                    sides[n_sides, 2 + axis], sides[n_sides, 3 - axis] = along1, level
                    n_sides += 1
                start, going = cell, border
    return n_sides


@kernel
def is_occupied(squares: Bytes, axis: int, cell: int, line: int) -> bool:
    """Return whether a cell is occupied, given by its place along a row (axis 0) or column (axis 1) and the line's."""
    if line < 0 or line >= squares.shape[2 - axis]:
        return False
    return bool((squares[0, cell, line] if axis == 0 else squares[0, line, cell]) == 0)
