"""Outlines of rigid bodies in the world frame: one kernel serves every footprint."""

from __future__ import annotations

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.geometry.frames import place_outline
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


def place(bodies: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``state.segments`` and ``state.discs`` of the given bodies from their poses."""
    place_bodies(
        shard.worlds,
        bodies,
        model.segment_start,
        model.segment_count,
        model.local_segments,
        model.disc_start,
        model.disc_count,
        model.local_discs,
        state.pose,
        state.segments,
        state.discs,
    )


@kernel
def place_bodies(
    worlds: Ints,
    bodies: Ints,
    segment_start: Ints,
    segment_count: Ints,
    local_segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    local_discs: Floats,
    pose: Floats,
    segments: Floats,
    discs: Floats,
) -> None:
    """Turn and shift the bodies' outlines into the world frame."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(bodies.shape[0]):
            b = bodies[k]
            place_outline(
                local_segments[min(w, local_segments.shape[0] - 1)],
                local_discs[min(w, local_discs.shape[0] - 1)],
                segment_start[b],
                segment_count[min(w, segment_count.shape[0] - 1), b],
                disc_start[b],
                disc_count[min(w, disc_count.shape[0] - 1), b],
                pose[w, b, 0],
                pose[w, b, 1],
                pose[w, b, 2],
                segments[w],
                discs[w],
            )
