"""Contacts in a crowd: each body is tested against those near it, found through the buckets."""

from __future__ import annotations

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.geometry.buckets import gather_nearby
from irsim_gym.geometry.overlap import outlines_overlap
from irsim_gym.jit import kernel

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
    frame: Floats,
    bucket_first: Ints,
    bucket_next: Ints,
    nearby: Ints,
    collided: Flags,
    hit: Ints,
) -> None:
    """Write the same flags as ``contact.find_contacts``, in time that grows with the bodies and not with their pairs.

    Bodies in the buckets reach no farther than ``frame[5]``.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        found = nearby[w]
        reaches, rows, rounds = reach[w % reach.shape[0]], segments[w], discs[w]
        n_segments, n_discs = segment_count[w % segment_count.shape[0]], disc_count[w % disc_count.shape[0]]
        for k in range(bodies.shape[0]):
            b = bodies[k]
            if unobstructed[b] or not present[w, b]:
                continue
            x, y, within = pose[w, b, 0], pose[w, b, 1], reaches[b] * ROUNDING + frame[5]
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
                if outlines_overlap(
                    rows, segment_start[b], n_segments[b], rounds, disc_start[b], n_discs[b], solid[b],
                    rows, segment_start[q], n_segments[q], rounds, disc_start[q], n_discs[q], solid[q],
                ):  # fmt: skip
                    collided[w, b], collided[w, q] = True, True
                    hit[w, b] = q if hit[w, b] < 0 else min(hit[w, b], q)
                    hit[w, q] = b if hit[w, q] < 0 else min(hit[w, q], b)
