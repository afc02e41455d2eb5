"""Buckets: which bodies may be near a point, without looking at all of them.

A square grid lies over the world; each bucket holds a linked list of the bodies whose origin lies in its square. What
lies outside of the grid is put into the nearest square at its border, so nothing is ever missed. Bodies that are too
large to be found by their origin are in one more bucket, behind the last square, and are always found.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Ints, Record
from irsim_gym.jit import kernel


@kernel
def square_of(value: float, low: float, side: float, count: int) -> int:
    """Return the index of the square that a coordinate [m] lies in; those outside, and NaN, count to the border."""
    place = np.floor((value - low) / side)
    if not place > 0.0:
        return 0
    return int(min(place, count - 1.0))


@kernel
def bucket_of(x: float, y: float, is_small: bool, frame: Record) -> int:
    """Return the bucket for a body with its origin at a point [m]: the last one if it is too large for the squares."""
    columns, rows = int(frame.columns), int(frame.rows)
    if not is_small:
        return columns * rows
    return square_of(y, frame.y, frame.side, rows) * columns + square_of(x, frame.x, frame.side, columns)


@kernel
def put(b: int, place: int, bucket: Ints, first: Ints, following: Ints) -> None:
    """Move body b of one world to the head of a bucket's list, if it is not in that bucket; -1: into none."""
    if place == bucket[b]:
        return
    if bucket[b] >= 0:
        unlink(b, bucket[b], first, following)
    bucket[b] = place
    if place >= 0:
        following[b] = first[place]
        first[place] = b


@kernel
def unlink(b: int, place: int, first: Ints, following: Ints) -> None:
    """Take body b out of a bucket's list."""
    if first[place] == b:
        first[place] = following[b]
        return
    earlier = first[place]
    while following[earlier] != b:
        earlier = following[earlier]
    following[earlier] = following[b]


@kernel
def find_nearby(x: float, y: float, radius: float, frame: Record, first: Ints, following: Ints, found: Ints) -> int:
    """Write the numbers of the bodies that may lie near a point, ascending; return how many there are.

    All bodies whose origin is within ``radius`` are among them, and all that are too large for the buckets; others
    may be. Without buckets they are simply all bodies.

    Args:
        x: The point [m].
        y: The point [m].
        radius: Distance [m]; add ``frame.reach`` to find bodies that reach into it.
        frame: Where the squares lie, see ``BUCKET_FRAME``.
        first: First body of each bucket, -1 for none, shape ``(bucket,)``.
        following: Next body of the same bucket, -1 for none, shape ``(body,)``.
        found: Written, shape ``(body,)``.
    """
    count = gather_nearby(x, y, radius, frame, first, following, found)
    if frame.columns > 0:
        put_in_order(found, count)
    return count


@kernel
def put_in_order(numbers: Ints, count: int) -> None:
    """Sort the first ``count`` numbers, ascending, in their place, with Knuth's steps for Shell's method.

    Short lists are what it is for; the compiler's own sort allocates.
    """
    gap = 1
    while gap < count // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(gap, count):
            number, k = numbers[i], i
            while k >= gap and numbers[k - gap] > number:
                numbers[k] = numbers[k - gap]
                k -= gap
            numbers[k] = number
        gap //= 3


@kernel
def gather_nearby(x: float, y: float, radius: float, frame: Record, first: Ints, following: Ints, found: Ints) -> int:
    """Write the same numbers as ``find_nearby``, in any order: half of the time goes into sorting them."""
    columns, rows = frame.columns, frame.rows
    if columns == 0:
        for b in range(following.shape[0]):
            found[b] = b
        return int(following.shape[0])
    count = 0
    b = first[columns * rows]
    while b >= 0:
        found[count] = b
        count += 1
        b = following[b]
    low = square_of(x - radius, frame.x, frame.side, columns)
    high = square_of(x + radius, frame.x, frame.side, columns)
    bottom = square_of(y - radius, frame.y, frame.side, rows)
    top = square_of(y + radius, frame.y, frame.side, rows)
    for row in range(bottom, top + 1):
        for column in range(low, high + 1):
            b = first[row * columns + column]
            while b >= 0:
                found[count] = b
                count += 1
                b = following[b]
    return count
