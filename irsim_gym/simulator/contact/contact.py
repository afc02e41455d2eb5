"""Contacts between bodies, and their effects."""

import numpy as np

from irsim_gym.simulator.contact import body_buckets
from irsim_gym.simulator.contact.cell_contact import find_cell_contacts, measure_cell_clearance
from irsim_gym.simulator.contact.crowd import find_near_contacts, measure_near_clearance
from irsim_gym.simulator.contact.pairs import note_contact
from irsim_gym.simulator.contact.swept import SweptMotion, sweep_bodies
from irsim_gym.simulator.geometry.overlap import (
    disc_meets_outline,
    disc_outline_distance,
    outline_distance,
    outlines_overlap,
)
from irsim_gym.simulator.world.model import ROBOT, STOP, UNOBSTRUCTED_OBSTACLES, Model
from irsim_gym.simulator.world.names import Floats, Ints, Record, Shard, State, kernel, outline_of, row_of

NOBODY = -1

SURE = 1e-6
"""Safety margin by which the ``room`` of a disc is reduced [m]. Rounding errors are far smaller."""


def find(movers: Ints, model: Model, state: State, shard: Shard, sweep: SweptMotion | None = None) -> None:
    """Write ``state.collided``, ``state.hit`` and ``state.stopped``, with ``sweep`` of contacts within a step too."""
    begin_contacts(shard.worlds, model, state)
    if sweep is not None:
        sweep_bodies(sweep, model, state, shard)
        body_buckets.refresh(movers, model, state, shard)
    _find_pairs(movers, False, model, state, shard)
    stop_bodies(shard.worlds, model, state)


def find_static(bodies: Ints, model: Model, state: State, shard: Shard) -> None:
    """Write ``model.static_partner``: contacts between bodies that never move, once per level.

    Contacts of the previous level are reused if these bodies have the same poses.
    """
    worlds, is_rigid, has_buckets = shard.worlds, bool(model.rigid[0]), model.bucket_frame[0].columns > 0
    # With buckets or a map all contacts are searched anyway: only ``find_contacts`` skips worlds that are known.
    may_recall = is_rigid and not has_buckets and model.cells is None
    recall_contacts(worlds, bodies, may_recall, model, state)
    _find_pairs(bodies, True, model, state, shard)
    note_partners(worlds, model, state)


def _find_pairs(bodies: Ints, is_static: bool, model: Model, state: State, shard: Shard) -> None:
    """Write which bodies touch: tests all pairs, or near ones if there are buckets; then the map."""
    if model.bucket_frame[0].columns:
        find_near_contacts(shard.worlds, bodies, model, state)
    else:
        find_contacts(shard.worlds, bodies, is_static, model, state)
    if (cells := model.cells) is not None:
        find_cell_contacts(shard.worlds, bodies, cells, model, state)


@kernel
def recall_contacts(worlds: Ints, bodies: Ints, may_recall: bool, model: Model, state: State) -> None:
    """Start from the previous contacts where ``bodies`` have not moved since, else from none.

    Reads: model (present, static_known, static_partner, static_pose), state (collided, hit, pose).
    Writes: model (static_known, static_pose), state (collided, hit).
    """
    for w in worlds:
        is_known = model.static_known[w]
        for b in bodies:
            for axis in range(3):
                # An absent body is compared as if at infinity, so that one that comes or goes counts as moved.
                now = state.pose[w, b, axis] if model.present[w, b] else np.inf
                is_known = is_known and model.static_pose[w, b, axis] == now
                model.static_pose[w, b, axis] = now
        model.static_known[w] = is_known and may_recall
        for b in range(state.hit.shape[1]):
            state.hit[w, b] = model.static_partner[w, b] if model.static_known[w] else NOBODY
            state.collided[w, b] = state.collided[w, b] or state.hit[w, b] >= 0


@kernel
def note_partners(worlds: Ints, model: Model, state: State) -> None:
    """Keep the contacts that last throughout the level, and discard distances measured in the previous level.

    Reads: state (hit).
    Writes: model (static_known, static_partner), state (room).
    """
    for w in worlds:
        model.static_known[w] = True
        for b in range(state.hit.shape[1]):
            model.static_partner[w, b] = state.hit[w, b]
            state.room[w, b].gap = 0.0


@kernel
def begin_contacts(worlds: Ints, model: Model, state: State) -> None:
    """Start from the contacts that last throughout the level.

    Reads: model (static_partner), state (hit).
    Writes: state (collided, hit).
    """
    for w in worlds:
        for b in range(state.hit.shape[1]):
            state.hit[w, b] = model.static_partner[w, b]
            state.collided[w, b] = state.hit[w, b] >= 0


@kernel
def find_contacts(worlds: Ints, bodies: Ints, is_static: bool, model: Model, state: State) -> None:
    """Test each of ``bodies`` against every other body.

    Sets are closed: touching counts. Unobstructed bodies touch nobody. Skips discs whose ``room`` rules out contact.

    Reads: model (disc_count, disc_start, movable, present, reach, segment_count, segment_start, solid, static_known,
        unobstructed), state (discs, hit, pose, room, segments).
    Writes: state (collided, hit).

    Args:
        worlds: The worlds to treat.
        bodies: The bodies to test; a pair of them that both can move, or both cannot, is tested once.
        is_static: Skip worlds whose static contacts are known.
    """
    for w in worlds:
        if is_static and model.static_known[w]:
            continue
        poses, there, discs = state.pose[w], model.present[w], state.discs[w]
        reaches = model.reach[row_of(model.reach, w)]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        n_discs = model.disc_count[row_of(model.disc_count, w)]
        for b in bodies:
            if model.unobstructed[b] or not there[b]:
                continue
            x, y, radius, moves, d = poses[b, 0], poses[b, 1], reaches[b], model.movable[b], model.disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            # A gap of 0 means unknown; asking for it first saves the square root of ``room_left``.
            if is_disc and state.room[w, b].gap > SURE and room_left(discs[d], state.room[w, b]) > 0.0:
                continue
            for q in range(there.shape[0]):
                dx, dy, near = poses[q, 0] - x, poses[q, 1] - y, radius + reaches[q]
                # Farther apart than both reaches: no contact. The factor keeps pairs that just touch despite rounding.
                if dx * dx + dy * dy > near * near * (1.0 + 1e-12) or q == b or model.unobstructed[q] or not there[q]:
                    continue
                # One test for each pair: of two movers, or of two fixed bodies, the one with the lower number makes it;
                # of a mover and a fixed body, the mover.
                if (model.movable[q] == moves and q < b) or (model.movable[q] and not moves):
                    continue
                other = outline_of(model, state, w, q)
                if is_disc:
                    meets = disc_meets_outline((discs[d, 0], discs[d, 1]), discs[d, 2], other)
                else:
                    whole = outline_of(model, state, w, b)
                    meets = outlines_overlap(whole, other)
                if meets:
                    note_contact(w, b, q, state)


@kernel(inlined=True)
def room_left(disc: Floats, room: Record) -> float:
    """Return the distance [m] within which a disc (x, y, radius) certainly touches nothing; at most 0 if unknown.

    Args:
        disc: Where it is now.
        room: Its record in ``state.room``; the other bodies have not moved since.
    """
    dx, dy = disc[0] - room.x, disc[1] - room.y
    return float(room.gap - SURE - np.sqrt(dx * dx + dy * dy))


@kernel
def stop_bodies(worlds: Ints, model: Model, state: State) -> None:
    """Write ``state.stopped``: the bodies that collisions hold in place, including those that never move, as in IR-SIM.

    Reads: model (collision_mode, role), state (collided).
    Writes: state (stopped).
    """
    mode = model.collision_mode[0]
    for w in worlds:
        for b in range(state.collided.shape[1]):
            holds = mode == STOP or (mode == UNOBSTRUCTED_OBSTACLES and model.role[b] == ROBOT)
            state.stopped[w, b] = state.collided[w, b] and holds


def clearance(
    bodies: Ints, limit: Floats, model: Model, state: State, shard: Shard, distance: Floats, only_mover: int = NOBODY
) -> None:
    """Write the surface distance of ``bodies`` to the nearest other body.

    Args:
        bodies: The bodies to measure, shape ``(n_bodies,)``.
        limit: Distances above it [m] may be reported as it, shape ``(n_worlds, n_bodies)``; may be ``distance`` itself.
        model: Constants of the worlds.
        state: State of the worlds.
        shard: The worlds to treat.
        distance: Written, [m], shape ``(n_worlds, n_bodies)``; ``limit`` where nothing else is present.
        only_mover: The one body that moves: how much room is around it is kept for later steps.

    Where there are buckets they have to be up to date.
    """
    if model.bucket_frame[0].columns:
        measure_near_clearance(shard.worlds, bodies, limit, model, state, distance)
    else:
        measure_clearance(shard.worlds, bodies, only_mover, limit, model, state, distance)
    if (cells := model.cells) is not None:
        measure_cell_clearance(shard.worlds, bodies, cells, model, state, distance)


@kernel
def fill(worlds: Ints, value: float, distance: Floats) -> None:
    """Write a number [m] into the rows ``(n_worlds, n_bodies)`` of some worlds."""
    for w in worlds:
        distance[w, :] = value


@kernel
def measure_clearance(
    worlds: Ints, bodies: Ints, only_mover: int, limit: Floats, model: Model, state: State, distance: Floats
) -> None:
    """Write exact surface distances. Skips bodies that cannot be the nearest.

    If the only moving body is a disc, its distance is stored in ``state.room``: it touches nothing before it has moved
    that far.

    Reads: model (disc_count, disc_start, present, reach, segment_count, segment_start, solid, unobstructed), state
        (discs, pose, segments).
    Writes: state (room), distance.
    """
    for w in worlds:
        poses, there, discs = state.pose[w], model.present[w], state.discs[w]
        reaches = model.reach[row_of(model.reach, w)]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        n_discs = model.disc_count[row_of(model.disc_count, w)]
        for k in range(bodies.shape[0]):
            # ``limit`` may be ``distance`` itself: an entry is read here and overwritten below.
            b, best = bodies[k], limit[w, k]
            x, y, radius, d = poses[b, 0], poses[b, 1], reaches[b], model.disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            for q in range(there.shape[0]):
                dx, dy, near = poses[q, 0] - x, poses[q, 1] - y, best + radius + reaches[q]
                # Even if both outlines reach towards each other as far as they can, q is not nearer than ``best``.
                if dx * dx + dy * dy >= near * near or q == b or model.unobstructed[q] or not there[q]:
                    continue
                other = outline_of(model, state, w, q)
                if is_disc:
                    best = disc_outline_distance((discs[d, 0], discs[d, 1]), discs[d, 2], other, best)
                else:
                    whole = outline_of(model, state, w, b)
                    best = min(best, outline_distance(whole, other, best))
            distance[w, k] = best
            # With a second body that moves, the distance would hold for no later step.
            if is_disc and b == only_mover:
                room = state.room[w, b]
                room.x, room.y, room.gap = discs[d, 0], discs[d, 1], best
