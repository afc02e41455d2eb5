"""The buckets that find bodies near a point (``simulator/geometry/buckets.py``), kept up to date as bodies move."""

import numpy as np

from irsim_gym.simulator.geometry.buckets import bucket_of, put
from irsim_gym.simulator.world.names import Flags, Ints, Model, Shard, State, kernel

FEWEST_BODIES = 64
"""Minimum number of bodies for buckets. With fewer, testing all of them is as fast."""

ROUNDING, TINY = 1.0 + 1e-9, 1e-9
"""Margin of searches beyond the greatest reach, so that rounding excludes no body."""


def lay_out(model: Model, is_random: Flags) -> None:
    """Choose the squares for a world with many bodies, and the bodies that are small enough for them."""
    n_bodies = len(model.role)
    if n_bodies < FEWEST_BODIES:
        return
    x0, y0, x1, y1 = model.bounds
    # One body per square, if they are spread evenly.
    side = float(np.sqrt((x1 - x0) * (y1 - y0) / n_bodies))
    # At most as many squares as bodies, however narrow the world is: ``n_buckets`` relies on it. Then the side grows
    # until these squares cover the world.
    rows = min(max(1, int((y1 - y0) / side)), n_bodies)
    columns = min(max(1, int((x1 - x0) / side)), n_bodies // rows)
    side = max((x1 - x0) / columns, (y1 - y0) / rows)
    # A larger body would make every search reach farther, and an outline that levels draw may become larger: these go
    # into the bucket that is always searched.
    reach = model.reach.max(axis=0)
    model.bucketed[:] = ~is_random & (reach <= side)
    greatest = float(np.max(reach, where=model.bucketed, initial=0.0))
    model.bucket_frame[0] = x0, y0, side, columns, rows, greatest * ROUNDING + TINY


def n_buckets(n_bodies: int) -> int:
    """Return an upper bound of the number of buckets that ``lay_out`` makes."""
    return 1 if n_bodies < FEWEST_BODIES else n_bodies + 1


def empty(model: Model, state: State, shard: Shard) -> None:
    """Remove all bodies from the buckets."""
    if model.bucket_frame[0].columns:
        empty_buckets(shard.worlds, state)


def refresh(bodies: Ints, model: Model, state: State, shard: Shard) -> None:
    """Put bodies into the buckets of their present positions."""
    if model.bucket_frame[0].columns:
        sort_bodies(shard.worlds, bodies, model, state)


@kernel
def empty_buckets(worlds: Ints, state: State) -> None:
    """Remove all bodies from the buckets.

    Writes: state (bucket, bucket_first, bucket_next).
    """
    for w in worlds:
        state.bucket[w, :], state.bucket_first[w, :], state.bucket_next[w, :] = -1, -1, -1


@kernel
def sort_bodies(worlds: Ints, bodies: Ints, model: Model, state: State) -> None:
    """Move each body whose square has changed from its old list to the head of its new one.

    Reads: model (bucket_frame, bucketed, present), state (bucket, bucket_first, bucket_next, pose).
    Writes: state (bucket, bucket_first, bucket_next).
    """
    for w in worlds:
        for b in bodies:
            place = (
                bucket_of(state.pose[w, b, 0], state.pose[w, b, 1], model.bucketed[b], model.bucket_frame[0])
                if model.present[w, b]
                else -1
            )
            put(b, place, state.bucket[w], state.bucket_first[w], state.bucket_next[w])
