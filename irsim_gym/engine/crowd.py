"""Contacts and clearances in a crowd: each body is compared with those near it, found through the buckets."""

from __future__ import annotations

from irsim_gym.arraytypes import BodyOutline, Flags, Floats, Ints, Record, Records
from irsim_gym.geometry.buckets import gather_nearby, square_of
from irsim_gym.geometry.overlap import disc_outline_distance, outline_distance, outlines_overlap
from irsim_gym.jit import kernel
from irsim_gym.world.rows import row_of

ROUNDING = 1.0 + 1e-9


@kernel
def find_near_contacts(
    worlds: Ints,
    bodies: Ints,
    movable: Flags,
    present: Flags,
    unobstructed: Flags,
    solid: Flags,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    pose: Floats,
    bucket_frame: Records,
    bucket_first: Ints,
    bucket_next: Ints,
    nearby: Ints,
    collided: Flags,
    hit: Ints,
) -> None:
    """Write the same flags as ``contact.find_contacts``, in time that grows with the bodies and not with their pairs.

    Bodies in the buckets reach no farther than ``frame.reach``.
    """
    frame = bucket_frame[0]
    for w in worlds:
        found = nearby[w]
        reaches, rows, rounds = reach[row_of(reach, w)], segments[w], discs[w]
        n_segments, n_discs = segment_count[row_of(segment_count, w)], disc_count[row_of(disc_count, w)]
        for b in bodies:
            if unobstructed[b] or not present[w, b]:
                continue
            x, y, within = pose[w, b, 0], pose[w, b, 1], reaches[b] * ROUNDING + frame.reach
            for j in range(gather_nearby(x, y, within, frame, bucket_first[w], bucket_next[w], found)):
                q = found[j]
                if q == b or unobstructed[q] or not present[w, q]:
                    continue
                if (movable[q] == movable[b] and q < b) or (movable[q] and not movable[b]):
                    continue
                dx, dy = pose[w, q, 0] - x, pose[w, q, 1] - y
                near = reaches[b] + reaches[q]
                if dx * dx + dy * dy > near * near * (1.0 + 1e-12):
                    continue
                whole = BodyOutline(rows, segment_start[b], n_segments[b], rounds, disc_start[b], n_discs[b], solid[b])
                other = BodyOutline(rows, segment_start[q], n_segments[q], rounds, disc_start[q], n_discs[q], solid[q])
                if outlines_overlap(whole, other):
                    collided[w, b], collided[w, q] = True, True
                    hit[w, b] = q if hit[w, b] < 0 else min(hit[w, b], q)
                    hit[w, q] = b if hit[w, q] < 0 else min(hit[w, q], b)


@kernel
def measure_near_clearance(
    worlds: Ints,
    bodies: Ints,
    limit: Floats,
    present: Flags,
    unobstructed: Flags,
    solid: Flags,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    pose: Floats,
    bucket_frame: Records,
    bucket_first: Ints,
    bucket_next: Ints,
    nearby: Ints,
    distance: Floats,
) -> None:
    """Write the same distances as ``contact.measure_clearance``: the search grows until nobody nearer can be left."""
    frame = bucket_frame[0]
    for w in worlds:
        found, first, following = nearby[w], bucket_first[w], bucket_next[w]
        reaches, rows, rounds, here, there = reach[row_of(reach, w)], segments[w], discs[w], pose[w], present[w]
        n_segments, n_discs = segment_count[row_of(segment_count, w)], disc_count[row_of(disc_count, w)]
        for k in range(bodies.shape[0]):
            b, best = bodies[k], limit[w, k]
            x, y, own, d = here[b, 0], here[b, 1], reaches[b], disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            within, is_open = own + frame.reach + frame.side, True
            while is_open:
                for j in range(gather_nearby(x, y, within, frame, first, following, found)):
                    q = found[j]
                    dx, dy, near = here[q, 0] - x, here[q, 1] - y, best + own + reaches[q]
                    if dx * dx + dy * dy >= near * near or q == b or unobstructed[q] or not there[q]:
                        continue
                    other = BodyOutline(
                        rows, segment_start[q], n_segments[q], rounds, disc_start[q], n_discs[q], solid[q]
                    )
                    if is_disc:
                        best = disc_outline_distance(rounds[d, 0], rounds[d, 1], rounds[d, 2], other, best)
                    else:
                        whole = BodyOutline(rows, segment_start[b], n_segments[b], rounds, d, n_discs[b], solid[b])
                        best = min(best, outline_distance(whole, other, best))
                is_open = best + own + frame.reach > within and not holds_all(x, y, within, frame)
                within *= 2.0
            distance[w, k] = best


@kernel
def holds_all(x: float, y: float, within: float, frame: Record) -> bool:
    """Return whether a search up to a distance [m] of a point looks at all squares."""
    columns, rows = frame.columns, frame.rows
    return bool(
        square_of(x - within, frame.x, frame.side, columns) == 0
        and square_of(x + within, frame.x, frame.side, columns) == columns - 1
        and square_of(y - within, frame.y, frame.side, rows) == 0
        and square_of(y + within, frame.y, frame.side, rows) == rows - 1
    )
