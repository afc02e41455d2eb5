"""Collect the surroundings that a body sees: moving discs, standing walls, and the walls of an occupancy map."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Point, Record, Records
from irsim_gym.bodies.behaviors.shared.map_parts import map_discs, map_walls
from irsim_gym.simulator.geometry.buckets import find_nearby
from irsim_gym.simulator.geometry.overlap import point_outline_distance
from irsim_gym.simulator.world.names import Model, State, Struct, kernel, outline_of, record_type, row_of

MARGIN = 0.1
"""Added to the radius of every disc [m], as in IR-SIM."""

SLACK = 1.0 + 1e-12
"""What is farther away than a limit times this is certainly beyond it, whatever the rounding."""

NOTHING, CHAIN, STANDING, ROUND = 0, 1, 2, 3
"""How a body looks: not at all, as segments without area, as its outline, as the disc around its centroid."""

ALL_ROLES = 0
"""``target_roles: all``; the role r alone is r + 1."""

DISC = record_type("x y vx vy radius touch_way")
"""A disc that is seen: centre [m], velocity [m/s], radius with MARGIN [m]; how far ahead a touch is [m]."""


class Ego(NamedTuple):
    """The body that decides, as a disc.

    Attributes:
        x: X coordinate of the centre [m].
        y: Y coordinate of the centre [m].
        vx: X component of the velocity [m/s].
        vy: Y component of the velocity [m/s].
        radius: Radius with any margin [m].
    """

    x: float
    y: float
    vx: float
    vy: float
    radius: float


@dataclass
class Surroundings(Struct):
    """Discs and walls that one body sees; each shard has its own.

    Attributes:
        lines: Bodies that are chains of segments, shape ``(n_lines,)``.
        nearby: Scratch for a search of bodies, shape ``(body,)``.
        rounds: Discs, records of type ``DISC``.
        sides: x0, y0, x1, y1 of walls [m], shape ``(n, 4)``.
        discs: Scratch for the discs of a map: x, y, radius [m], shape ``(n, 3)``.
    """

    lines: Ints
    nearby: Ints
    rounds: Records
    sides: Floats
    discs: Floats

    @classmethod
    def reserve(cls, model: Model, n_rounds: int, n_sides: int, n_discs: int) -> Self:
        """Allocate memory for the given numbers of discs and walls of bodies and a map, and of discs of a map."""
        nearby, rounds = np.zeros(len(model.role), np.int64), np.zeros(n_rounds + n_discs, DISC)
        return cls(wall_bodies(model), nearby, rounds, np.zeros((n_sides, 4)), np.zeros((n_discs, 3)))


def wall_bodies(model: Model) -> Ints:
    """Return the bodies that are chains of segments without an area."""
    return np.flatnonzero(~model.solid & (model.segment_count.max(axis=0) > 0))


@kernel
def is_seen(model: Model, w: int, b: int, q: int, target_roles: int) -> bool:
    """Return whether body b takes body q into account, whether or not it is hidden behind others.

    It does if q is another body that is present, has the target role, and is visible to b. A body that ignores moving
    bodies only sees those that never move.

    Reads: model (heedless, movable, present, role, seen_row, watchers).
    """
    if q == b or not model.present[w, q] or not model.watchers[model.seen_row[q], b]:
        return False
    if model.movable[q] and model.heedless[row_of(model.heedless, w), b]:
        return False
    # Choices count from "all" = 0, roles from 0.
    return bool(target_roles == ALL_ROLES or model.role[q] == target_roles - 1)


@kernel
def is_map_seen(model: Model, w: int, target_roles: int) -> bool:
    """Return whether there is an occupancy map to take into account; the map's body has no outline.

    Reads: model (map_frame, present, role).
    """
    chart = model.map_frame[0].body
    return bool(
        chart >= 0 and model.present[w, chart] and (target_roles == ALL_ROLES or model.role[chart] == target_roles - 1)
    )


@kernel
def look_of(model: Model, w: int, q: int) -> int:
    """Return how others see a body; one that never moves and is more than a disc shows its outline.

    Reads: model (disc_count, movable, segment_count, solid).
    """
    n_segments = model.segment_count[row_of(model.segment_count, w), q]
    n_discs = model.disc_count[row_of(model.disc_count, w), q]
    if n_segments + n_discs == 0:
        return NOTHING
    if n_segments > 0 and not model.solid[q]:
        return CHAIN
    return STANDING if not model.movable[q] and (n_segments > 0 or n_discs > 1) else ROUND


@kernel
def centroid_of(model: Model, state: State, w: int, q: int) -> Point:
    """Return the centre of a body's area in the world frame [m].

    Reads: model (centroid), state (pose).
    """
    pose, centroid = state.pose[w, q], model.centroid[row_of(model.centroid, w), q]
    x, y = centroid[0], centroid[1]
    if x == 0.0 and y == 0.0:
        return pose[0], pose[1]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    return pose[0] + (cosine * x - sine * y), pose[1] + (sine * x + cosine * y)


@kernel
def find_around(model: Model, state: State, w: int, b: int, radius: float, nearby: Ints) -> int:
    """Write the bodies that may reach into a circle around a body, in ascending order; return their number.

    Reads: model (bucket_frame), state (bucket_first, bucket_next, pose).
    Writes: nearby.

    Args:
        model: Constants of the worlds.
        state: Current state of the worlds.
        w: World.
        b: Body at the centre of the circle.
        radius: Radius of the circle [m].
        nearby: Numbers of bodies to write, shape ``(body,)``.
    """
    x, y, frame = state.pose[w, b, 0], state.pose[w, b, 1], model.bucket_frame[0]
    # Buckets hold bodies by their origins; the farthest-reaching body found through them reaches `frame.reach`.
    return find_nearby(x, y, radius + frame.reach, frame, state.bucket_first[w], state.bucket_next[w], nearby)


@kernel
def is_far(model: Model, state: State, w: int, b: int, q: int, radius: float) -> bool:
    """Return whether body q certainly does not reach into a circle of the radius [m] around body b.

    Reads: model (reach), state (pose).
    """
    dx, dy = state.pose[w, q, 0] - state.pose[w, b, 0], state.pose[w, q, 1] - state.pose[w, b, 1]
    far = radius + model.reach[row_of(model.reach, w), q]
    return bool(dx * dx + dy * dy > far * far * SLACK)


@kernel
def look_around(
    model: Model, state: State, w: int, b: int, target_roles: int, sight: float, seen: Surroundings
) -> tuple[int, int]:
    """Write the discs and segments that a body avoids; return the number of each.

    Most bodies count as the disc around their centroid, and are seen if the centroid is closer than ``sight`` [m].
    Bodies that never move and have sides count as their outline, and are seen if any part of it is closer. Chains of
    segments are always seen, the walls of a map only nearby. Discs of a map count as standing discs.

    Reads: model (bucket_frame, centroid, disc_count, disc_start, heedless, map_disc, map_frame, map_squares, movable,
        present, radius, reach, role, seen_row, segment_count, segment_start, solid, watchers), state (bucket_first,
        bucket_next, discs, pose, segments, twist), seen (discs, lines, nearby).
    Writes: seen (discs, nearby, rounds, sides).

    Args:
        model: Constants of the worlds.
        state: Current state of the worlds.
        w: World.
        b: Body that looks.
        target_roles: ALL_ROLES, or the role that the body sees plus 1.
        sight: Range of sight [m].
        seen: Surroundings; ``rounds`` and ``sides`` are written.
    """
    x, y, rounds = state.pose[w, b, 0], state.pose[w, b, 1], seen.rounds
    n_rounds, n_sides = 0, 0
    for k in range(find_around(model, state, w, b, sight, seen.nearby)):
        q = seen.nearby[k]
        if is_far(model, state, w, b, q, sight) or not is_seen(model, w, b, q, target_roles):
            continue
        look = look_of(model, w, q)
        if look == STANDING and point_outline_distance((x, y), outline_of(model, state, w, q)) < sight:
            n_sides = copy_sides(model, state, w, q, seen.sides, n_sides)
            n_rounds = copy_discs(model, state, w, q, rounds, n_rounds)
        if look == ROUND:
            cx, cy = centroid_of(model, state, w, q)
            if (x - cx) * (x - cx) + (y - cy) * (y - cy) < sight * sight:
                radius = model.radius[row_of(model.radius, w), q] + MARGIN
                write_disc(rounds[n_rounds], cx, cy, state.twist[w, q, 0], state.twist[w, q, 1], radius)
                n_rounds += 1
    for q in seen.lines:
        if is_seen(model, w, b, q, target_roles):
            n_sides = copy_sides(model, state, w, q, seen.sides, n_sides)
    if is_map_seen(model, w, target_roles):
        n_sides = map_walls(model, w, x, y, sight, seen.sides, n_sides)
        for d in range(map_discs(model, w, x, y, sight, seen.discs)):
            disc = seen.discs[d]
            write_disc(rounds[n_rounds], disc[0], disc[1], 0.0, 0.0, disc[2] + MARGIN)
            n_rounds += 1
    return n_rounds, n_sides


@kernel
def write_disc(disc: Record, x: float, y: float, vx: float, vy: float, radius: float) -> None:
    """Write a visible disc; the arguments are the fields of ``DISC``."""
    disc.x, disc.y, disc.vx, disc.vy, disc.radius = x, y, vx, vy, radius


@kernel
def copy_discs(model: Model, state: State, w: int, q: int, rounds: Records, n_rounds: int) -> int:
    """Append the discs of a standing body to ``rounds``; return the new number of discs.

    Reads: model (disc_count, disc_start), state (discs).
    """
    start, discs = model.disc_start[q], state.discs[w]
    for d in range(start, start + model.disc_count[row_of(model.disc_count, w), q]):
        write_disc(rounds[n_rounds], discs[d, 0], discs[d, 1], 0.0, 0.0, discs[d, 2] + MARGIN)
        n_rounds += 1
    return n_rounds


@kernel
def copy_sides(model: Model, state: State, w: int, q: int, sides: Floats, n_sides: int) -> int:
    """Append the segments of a body to ``sides``; return the new number of segments.

    Reads: model (segment_count, segment_start), state (segments).
    Writes: sides.
    """
    start = model.segment_start[q]
    for s in range(start, start + model.segment_count[row_of(model.segment_count, w), q]):
        for column in range(4):
            sides[n_sides, column] = state.segments[w, s, column]
        n_sides += 1
    return n_sides
