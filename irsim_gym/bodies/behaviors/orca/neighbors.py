"""Static obstacles of an ORCA body: walls and discs of bodies that never move."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.bodies.behaviors.shared.surroundings import find_around
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, State, Struct, kernel, row_of

FEW_WALLS = 64
"""Number of static bodies up to which they are searched one by one; more are looked up in the buckets."""


@dataclass
class OrcaObstacles(Struct):
    """The static obstacles, with scratch memory of one shard.

    Attributes:
        walls: Bodies that never move and must be avoided, shape ``(n_walls,)``.
        is_wall: Flags of these bodies, shape ``(body,)``.
        nearby: Scratch for a search of bodies, shape ``(body,)``.
        parts: Sides and discs in reach, nearest first: the row of a side in the table of segments, or that of a disc
            behind all of that table. Shape ``(segment + disc,)``.
        parts_gap: Their squared distances [m2].
        owners: The body of each segment and disc that was found, shape ``(segment + disc,)``.
        sides: x0, y0, x1, y1 of the walls of a map [m], shape ``(n_sides, 4)``.
        map_discs: x, y, radius of the discs of a map [m], shape ``(n_discs, 3)``.
        map_order: Those of either in reach, nearest first, shape ``(n_sides + n_discs,)``.
        map_gap: Their squared distances [m2].
    """

    walls: Ints
    is_wall: Flags
    nearby: Ints
    parts: Ints
    parts_gap: Floats
    owners: Ints
    sides: Floats
    map_discs: Floats
    map_order: Ints
    map_gap: Floats

    @classmethod
    def reserve(cls, is_wall: Flags, n_parts: int, n_sides: int, n_discs: int) -> Self:
        """Return memory for so many sides and discs of bodies, and so many walls and discs of a map."""
        return cls(
            walls=np.flatnonzero(is_wall),
            is_wall=is_wall,
            nearby=np.zeros(len(is_wall), np.int64),
            parts=np.zeros(n_parts, np.int64),
            parts_gap=np.zeros(n_parts),
            owners=np.zeros(n_parts, np.int64),
            sides=np.zeros((n_sides, 4)),
            map_discs=np.zeros((n_discs, 3)),
            map_order=np.zeros(n_sides + n_discs, np.int64),
            map_gap=np.zeros(n_sides + n_discs),
        )


@kernel
def put_in_order(item: int, key: float, items: Ints, keys: Floats, count: int) -> int:
    """Insert an item into a list sorted by key, then number, of which ``items`` holds the first; return its length."""
    if count < items.shape[0]:
        count += 1
    # The list is full: an item that comes after the last is left out.
    elif count == 0 or key > keys[count - 1] or (key == keys[count - 1] and item > items[count - 1]):
        return count
    k = count - 1
    while k > 0 and (keys[k - 1] > key or (keys[k - 1] == key and items[k - 1] > item)):
        items[k], keys[k] = items[k - 1], keys[k - 1]
        k -= 1
    items[k], keys[k] = item, key
    return count


@kernel
def find_walls(model: Model, state: State, w: int, b: int, within: float, obstacles: OrcaObstacles) -> int:
    """Write sides and discs of bodies that never move, nearest first, up to some distance; return their number.

    Reads: model (bucket_frame, disc_count, disc_start, present, reach, seen_row, segment_count, segment_start,
        watchers), state (bucket_first, bucket_next, discs, pose, segments), obstacles (is_wall, nearby, parts,
        parts_gap, walls).
    Writes: obstacles (nearby, owners, parts, parts_gap).

    Args:
        model: Constants of the worlds.
        state: Current state of the worlds.
        w: World.
        b: The body that looks.
        within: Sides this far away or farther are left out [m].
        obstacles: ``parts`` and ``owners`` are written.
    """
    x, y, pose = state.pose[w, b, 0], state.pose[w, b, 1], state.pose[w]
    segments, discs = state.segments[w], state.discs[w]
    segment_row, disc_row = row_of(model.segment_count, w), row_of(model.disc_count, w)
    parts, gap2, n_found = obstacles.parts, obstacles.parts_gap, obstacles.walls.shape[0]
    # Without columns there are no buckets.
    few = n_found <= FEW_WALLS or model.bucket_frame[0].columns == 0
    if not few:
        n_found = find_around(model, state, w, b, within, obstacles.nearby)
    count, limit2 = 0, within * within
    for i in range(n_found):
        q = obstacles.walls[i] if few else obstacles.nearby[i]
        dx, dy, far = pose[q, 0] - x, pose[q, 1] - y, within + model.reach[row_of(model.reach, w), q]
        if not model.watchers[model.seen_row[q], b]:
            continue
        if not obstacles.is_wall[q] or not model.present[w, q] or np.sqrt(dx * dx + dy * dy) >= far:
            continue
        start, first = model.segment_start[q], model.disc_start[q]
        for s in range(start, start + model.segment_count[segment_row, q]):
            distance2 = point_segment_distance2(x, y, segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3])
            if distance2 < limit2:
                obstacles.owners[s] = q
                count = put_in_order(s, distance2, parts, gap2, count)
        for d in range(first, first + model.disc_count[disc_row, q]):
            dx, dy = discs[d, 0] - x, discs[d, 1] - y
            gap = max(np.sqrt(dx * dx + dy * dy) - discs[d, 2], 0.0)
            if gap < within:
                # Discs are numbered behind all segments, so that one list holds both.
                row = segments.shape[0] + d
                obstacles.owners[row] = q
                count = put_in_order(row, gap * gap, parts, gap2, count)
    return count
