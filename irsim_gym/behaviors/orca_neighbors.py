"""What stands in the way of an ORCA body: walls and discs of bodies that never move."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Record
from irsim_gym.geometry.buckets import find_nearby
from irsim_gym.geometry.segments import point_segment_distance2
from irsim_gym.jit import kernel

FEW_WALLS = 64
"""So many bodies without motion are looked through one by one; more are looked up in the buckets."""


@kernel
def put_in_order(item: int, key: float, items: Ints, keys: Floats, count: int, most: int) -> int:
    """Insert an item into a list sorted by key, then number, of at most so many items; return its new length."""
    if count < most:
        count += 1
    elif most == 0 or key > keys[count - 1] or (key == keys[count - 1] and item > items[count - 1]):
        return count
    k = count - 1
    while k > 0 and (keys[k - 1] > key or (keys[k - 1] == key and items[k - 1] > item)):
        items[k], keys[k] = items[k - 1], keys[k - 1]
        k -= 1
    items[k], keys[k] = item, key
    return count


@kernel
def find_walls(
    x: float,
    y: float,
    within: float,
    walls: Ints,
    is_wall: Flags,
    frame: Record,
    first: Ints,
    following: Ints,
    present: Flags,
    pose: Floats,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    found: Ints,
    gap2: Floats,
    parts: Ints,
    owners: Ints,
) -> int:
    """Write sides and discs of bodies that never move, nearest first, up to some distance; return their number.

    A side is written as its row of the segment table, a disc as its row behind all of that table.

    Args:
        x: Position of the body that looks [m].
        y: Position of the body that looks [m].
        within: Sides this far away or farther are left out [m].
        walls: Bodies that never move, shape ``(n_walls,)``.
        is_wall: The same as flags, shape ``(body,)``.
        frame: ``model.bucket_frame[0]``.
        first: First body of each bucket, shape ``(bucket,)``.
        following: Next body of the same bucket, shape ``(body,)``.
        present: Who exists, shape ``(body,)``.
        pose: x, y, heading [m, m, rad], shape ``(body, 3)``.
        reach: ``model.reach`` of the world [m], shape ``(body,)``.
        segment_start: First row of each body's segments, shape ``(body,)``.
        segment_count: Number of them, shape ``(body,)``.
        segments: x0, y0, x1, y1 [m], shape ``(segment, 4)``.
        disc_start: First row of each body's discs, shape ``(body,)``.
        disc_count: Number of them, shape ``(body,)``.
        discs: x, y, radius [m], shape ``(disc, 3)``.
        found: Scratch, shape ``(body,)``.
        gap2: Scratch, shape ``(segment + disc,)``.
        parts: Written, shape ``(segment + disc,)``.
        owners: Written: the body of each segment and disc that was found, shape ``(segment + disc,)``.
    """
    n_found = walls.shape[0]
    few = n_found <= FEW_WALLS or frame.columns == 0
    if not few:
        n_found = find_nearby(x, y, within + frame.reach, frame, first, following, found)
    count, most, limit2 = 0, parts.shape[0], within * within
    for i in range(n_found):
        q = walls[i] if few else found[i]
        dx, dy = pose[q, 0] - x, pose[q, 1] - y
        if not is_wall[q] or not present[q] or np.sqrt(dx * dx + dy * dy) >= within + reach[q]:
            continue
        for s in range(segment_start[q], segment_start[q] + segment_count[q]):
            distance2 = point_segment_distance2(x, y, segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3])
            if distance2 < limit2:
                owners[s] = q
                count = put_in_order(s, distance2, parts, gap2, count, most)
        for d in range(disc_start[q], disc_start[q] + disc_count[q]):
            dx, dy = discs[d, 0] - x, discs[d, 1] - y
            gap = max(np.sqrt(dx * dx + dy * dy) - discs[d, 2], 0.0)
            if gap < within:
                row = segments.shape[0] + d
                owners[row] = q
                count = put_in_order(row, gap * gap, parts, gap2, count, most)
    return count
