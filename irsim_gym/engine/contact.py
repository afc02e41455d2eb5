"""Who touches whom, and what that does."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import BodyOutline, CellMap, Flags, Floats, Ints
from irsim_gym.engine.cell_contact import find_cell_contacts, measure_cell_clearance
from irsim_gym.engine.crowd import find_near_contacts, measure_near_clearance
from irsim_gym.geometry.overlap import disc_meets_outline, disc_outline_distance, outline_distance, outlines_overlap
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard
from irsim_gym.world.model import ROBOT, STOP, UNOBSTRUCTED, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

NOBODY = -1

SURE = 1e-6
"""What is known of the room around a disc is taken for this much less [m]; rounding is far smaller."""

OutlineTables = tuple[Flags, Flags, Flags, Floats, Ints, Ints, Floats, Ints, Ints, Floats]


def find(movers: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``state.collided``, ``state.hit`` and ``state.stopped``."""
    begin_contacts(shard.worlds, model, state)
    _find_pairs(movers, model, state, shard, model.static_known[:0])
    stop(model, state, shard)


def stop(model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``state.stopped``: who is held in place, those that never move included, as in IR-SIM."""
    stop_bodies(shard.worlds, model, state)


def find_static(bodies: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``model.static_partner``: contacts between bodies that never move, once per level.

    Where they stand as they stood in the level before, what was found then is taken.
    """
    worlds, is_rigid, has_buckets = shard.worlds, bool(model.rigid[0]), model.bucket_frame[0].columns > 0
    may_recall = is_rigid and not has_buckets and model.cells is None
    recall_contacts(worlds, bodies, may_recall, model, state)
    _find_pairs(bodies, model, state, shard, model.static_known)
    note_partners(worlds, model, state)


def _find_pairs(bodies: Ints, model: WorldModel, state: WorldState, shard: Shard, known: Flags) -> None:
    """Write who touches whom: all pairs, or near ones through the buckets where there are any; then the map."""
    outline = _outline(model, state)
    if model.bucket_frame[0].columns:
        buckets = (model.bucket_frame, state.bucket_first, state.bucket_next, state.nearby)
        find_near_contacts(
            shard.worlds, bodies, model.movable, *outline, state.pose, *buckets, state.collided, state.hit
        )
    else:
        clear = state.pose, state.room, known
        find_contacts(shard.worlds, bodies, model.movable, *outline, *clear, state.collided, state.hit)
    if (cells := model.cells) is not None:
        touch_cells(bodies, cells, model, state, shard)


def touch_cells(bodies: Ints, cells: CellMap, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Add the contacts of ``bodies`` with the obstacle map."""
    find_cell_contacts(shard.worlds, bodies, cells, model, state)


def _outline(model: WorldModel, state: WorldState) -> OutlineTables:
    return (
        model.present,
        model.unobstructed,
        model.solid,
        model.reach,
        model.segment_start,
        model.segment_count,
        state.segments,
        model.disc_start,
        model.disc_count,
        state.discs,
    )


@kernel
def recall_contacts(worlds: Ints, bodies: Ints, may_recall: bool, model: WorldModel, state: WorldState) -> None:
    """Begin with the contacts of before where ``bodies`` have not moved since, else with nobody who touches anybody."""
    for w in worlds:
        is_known = model.static_known[w]
        for b in bodies:
            for axis in range(3):
                now = state.pose[w, b, axis] if model.present[w, b] else np.inf
                is_known = is_known and model.static_pose[w, b, axis] == now
                model.static_pose[w, b, axis] = now
        model.static_known[w] = is_known and may_recall
        for b in range(state.hit.shape[1]):
            state.hit[w, b] = model.static_partner[w, b] if model.static_known[w] else NOBODY
            state.collided[w, b] = state.collided[w, b] or state.hit[w, b] >= 0


@kernel
def note_partners(worlds: Ints, model: WorldModel, state: WorldState) -> None:
    """Keep the contacts that last through the level, and forget how much room there was in the one before."""
    for w in worlds:
        model.static_known[w] = True
        for b in range(state.hit.shape[1]):
            model.static_partner[w, b] = state.hit[w, b]
            state.room[w, b, 2] = 0.0


@kernel
def begin_contacts(worlds: Ints, model: WorldModel, state: WorldState) -> None:
    """Begin with the contacts that last through the level."""
    for w in worlds:
        for b in range(state.hit.shape[1]):
            state.hit[w, b] = model.static_partner[w, b]
            state.collided[w, b] = state.hit[w, b] >= 0


@kernel
def find_contacts(
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
    room: Floats,
    known: Flags,
    collided: Flags,
    hit: Ints,
) -> None:
    """Test each of ``bodies`` against every other body; pairs of listed bodies that can move alike are met once.

    Closed sets: touching counts. Bodies marked unobstructed touch nobody. Discs that ``room`` shows to be clear of
    everything are not tested, and nobody in worlds that are ``known``, if that says anything.
    """
    for w in worlds:
        if known.shape[0] > 0 and known[w]:
            continue
        reaches, rows, rounds, here, there = (
            reach[row_of(reach, w)],
            segments[w],
            discs[w],
            pose[w],
            present[w],
        )
        n_segments, n_discs = (
            segment_count[row_of(segment_count, w)],
            disc_count[row_of(disc_count, w)],
        )
        for b in bodies:
            if unobstructed[b] or not there[b]:
                continue
            x, y, own, moves, d = here[b, 0], here[b, 1], reaches[b], movable[b], disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            if is_disc and room[w, b, 2] > SURE and room_left(rounds[d], room[w, b]) > 0.0:
                continue
            for q in range(there.shape[0]):
                dx, dy, near = here[q, 0] - x, here[q, 1] - y, own + reaches[q]
                if dx * dx + dy * dy > near * near * (1.0 + 1e-12) or q == b or unobstructed[q] or not there[q]:
                    continue
                if (movable[q] == moves and q < b) or (movable[q] and not moves):
                    continue
                other = BodyOutline(rows, segment_start[q], n_segments[q], rounds, disc_start[q], n_discs[q], solid[q])
                if is_disc:
                    meets = disc_meets_outline(rounds[d, 0], rounds[d, 1], rounds[d, 2], other)
                else:
                    whole = BodyOutline(rows, segment_start[b], n_segments[b], rounds, d, n_discs[b], solid[b])
                    meets = outlines_overlap(whole, other)
                if meets:
                    collided[w, b], collided[w, q] = True, True
                    hit[w, b] = q if hit[w, b] < 0 else min(hit[w, b], q)
                    hit[w, q] = b if hit[w, q] < 0 else min(hit[w, q], b)


@kernel(inlined=True)
def room_left(disc: Floats, room: Floats) -> float:
    """Return the distance [m] within which a disc (x, y, radius) surely meets nothing; not above 0 if none is known.

    Args:
        disc: Where it is now.
        room: Where it was, and up to where [m] nothing was from its edge, while the others stand still.
    """
    dx, dy = disc[0] - room[0], disc[1] - room[1]
    return float(room[2] - SURE - np.sqrt(dx * dx + dy * dy))


@kernel
def stop_bodies(worlds: Ints, model: WorldModel, state: WorldState) -> None:
    """Hold collided bodies in place as the collision mode says."""
    mode = model.collision_mode[0]
    for w in worlds:
        for b in range(state.collided.shape[1]):
            holds = mode == STOP or (mode != UNOBSTRUCTED and model.role[b] == ROBOT)
            state.stopped[w, b] = state.collided[w, b] and holds


def clearance(
    bodies: Ints,
    limit: Floats,
    model: WorldModel,
    state: WorldState,
    shard: Shard,
    distance: Floats,
    only_mover: int = NOBODY,
) -> None:
    """Write the surface distance of ``bodies`` to the nearest other body.

    Args:
        bodies: The bodies to measure, shape ``(n_bodies,)``.
        limit: Distances above it [m] may be reported as it, shape ``(n_worlds, n_bodies)``; may be ``distance`` itself.
        model: The constants.
        state: The moment.
        shard: The worlds to treat.
        distance: Written, [m], shape ``(n_worlds, n_bodies)``; ``limit`` where nothing else is present.
        only_mover: The one body that moves: how much room is around it is kept for later steps.

    Where there are buckets they have to be up to date.
    """
    outline = _outline(model, state)
    if model.bucket_frame[0].columns:
        buckets = (model.bucket_frame, state.bucket_first, state.bucket_next, state.nearby)
        measure_near_clearance(shard.worlds, bodies, limit, *outline, state.pose, *buckets, distance)
    else:
        measure_clearance(shard.worlds, bodies, only_mover, limit, *outline, state.pose, state.room, distance)
    if (cells := model.cells) is not None:
        measure_cell_clearance(shard.worlds, bodies, cells, model, state, distance)


@kernel
def fill(worlds: Ints, value: float, distance: Floats) -> None:
    """Write one number [m] into the rows ``(n_worlds, n_bodies)`` of some worlds."""
    for i in range(worlds.shape[0]):
        distance[worlds[i], :] = value


@kernel
def measure_clearance(
    worlds: Ints,
    bodies: Ints,
    only_mover: int,
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
    room: Floats,
    distance: Floats,
) -> None:
    """Write exact surface distances, passing over bodies that cannot be the nearest.

    That of a disc that is the only body that moves is noted in ``room``: until it has moved as far it touches nothing.
    """
    for w in worlds:
        reaches, rows, rounds, here, there = (
            reach[row_of(reach, w)],
            segments[w],
            discs[w],
            pose[w],
            present[w],
        )
        n_segments, n_discs = (
            segment_count[row_of(segment_count, w)],
            disc_count[row_of(disc_count, w)],
        )
        for k in range(bodies.shape[0]):
            b, best = bodies[k], limit[w, k]
            x, y, own, d = here[b, 0], here[b, 1], reaches[b], disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            for q in range(there.shape[0]):
                dx, dy, near = here[q, 0] - x, here[q, 1] - y, best + own + reaches[q]
                if dx * dx + dy * dy >= near * near or q == b or unobstructed[q] or not there[q]:
                    continue
                other = BodyOutline(rows, segment_start[q], n_segments[q], rounds, disc_start[q], n_discs[q], solid[q])
                if is_disc:
                    best = disc_outline_distance(rounds[d, 0], rounds[d, 1], rounds[d, 2], other, best)
                else:
                    whole = BodyOutline(rows, segment_start[b], n_segments[b], rounds, d, n_discs[b], solid[b])
                    best = min(best, outline_distance(whole, other, best))
            distance[w, k] = best
            if is_disc and b == only_mover:
                room[w, b, 0], room[w, b, 1], room[w, b, 2] = rounds[d, 0], rounds[d, 1], best
