"""Buckets: find the bodies near a point without looking at all of them.

A square grid covers the world. Each bucket holds a linked list of the bodies whose origin lies in its square. Points
outside the grid belong to the nearest square at its border, so no body is missed. Bodies too large to be found by their
origin are in one more bucket, behind the last square, and are always found.
"""

import numpy as np

from irsim_gym.base.arraytypes import Ints, Record
from irsim_gym.base.kernels import kernel


@kernel
def square_of(value: float, low: float, side: float, count: int) -> int:
    """Return the index of the square that holds a coordinate [m]. Outside, and for NaN, it is one at the border."""
    place = np.floor((value - low) / side)
    # NaN fails every comparison, so it ends here, too.
    if not place > 0.0:
        return 0
    return int(min(place, count - 1.0))


@kernel
def bucket_of(x: float, y: float, is_small: bool, frame: Record) -> int:
    """Return the bucket of a body with its origin at a point [m]; the last one if it is too large for the squares."""
    columns, rows = int(frame.columns), int(frame.rows)
    if not is_small:
        return columns * rows
    return square_of(y, frame.y, frame.side, rows) * columns + square_of(x, frame.x, frame.side, columns)


@kernel
def put(b: int, place: int, bucket: Ints, first: Ints, following: Ints) -> None:
    """Move body b of one world to the head of the list of a bucket, unless it is in that bucket; -1 removes it."""
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
    """Remove body b from the list of a bucket."""
    if first[place] == b:
        first[place] = following[b]
        return
    earlier = first[place]
    while following[earlier] != b:
        earlier = following[earlier]
    following[earlier] = following[b]


@kernel
def find_nearby(x: float, y: float, radius: float, frame: Record, first: Ints, following: Ints, nearby: Ints) -> int:
    """Write the indices of the bodies that may lie near a point in ascending order, and return their number.

    All bodies whose origin is within ``radius`` are included, and all that are too large for the buckets. Others may be
    included, too. Without buckets, all bodies are.

    Args:
        x: The point [m].
        y: The point [m].
        radius: Distance [m]; add ``frame.reach`` to find bodies that reach into it.
        frame: Where the squares lie, see ``BUCKET_FRAME``.
        first: First body of each bucket, -1 for none, shape ``(bucket,)``.
        following: Next body of the same bucket, -1 for none, shape ``(body,)``.
        nearby: Written, shape ``(body,)``.
    """
    count = gather_nearby(x, y, radius, frame, first, following, nearby)
    if frame.columns > 0:
        put_in_order(nearby, count)
    return count


@kernel
def put_in_order(numbers: Ints, count: int) -> None:
    """Sort the first ``count`` numbers in place, in ascending order, by Shell's method with Knuth's gaps.

    It is meant for short lists. NumPy's sort would allocate memory, which kernels do not.
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
def gather_nearby(x: float, y: float, radius: float, frame: Record, first: Ints, following: Ints, nearby: Ints) -> int:
    """Write what ``find_nearby`` writes, in any order. Sorting takes half of the time of ``find_nearby``."""
    columns, rows = frame.columns, frame.rows
    if columns == 0:
        for b in range(following.shape[0]):
            nearby[b] = b
        return int(following.shape[0])
    count = 0
    # The bucket behind the last square holds the large bodies.
    b = first[columns * rows]
    while b >= 0:
        nearby[count] = b
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
                nearby[count] = b
                count += 1
                b = following[b]
    return count
