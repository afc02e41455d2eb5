"""Outlines of rigid bodies in the world frame: one kernel serves every footprint."""

from irsim_gym.simulator.world.names import Ints, Model, Shard, State, kernel, place_outline


def place(bodies: Ints, model: Model, state: State, shard: Shard) -> None:
    """Write ``state.segments`` and ``state.discs`` of the given bodies from their poses."""
    place_bodies(shard.worlds, bodies, model, state)


@kernel
def place_bodies(worlds: Ints, bodies: Ints, model: Model, state: State) -> None:
    """Turn and shift the bodies' outlines into the world frame.

    Reads: model (disc_count, disc_start, local_discs, local_segments, segment_count, segment_start, solid), state
        (discs, pose, segments).
    Writes: state (discs, segments).
    """
    for w in worlds:
        for b in bodies:
            place_outline(model, state, w, b)
