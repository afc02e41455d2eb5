"""Contacts and clearances in a crowd: each body is compared with those near it, found through the buckets."""

from irsim_gym.simulator.contact.pairs import note_contact
from irsim_gym.simulator.geometry.buckets import gather_nearby, square_of
from irsim_gym.simulator.geometry.overlap import disc_outline_distance, outline_distance, outlines_overlap
from irsim_gym.simulator.world.names import Floats, Ints, Model, Record, State, kernel, outline_of, row_of

ROUNDING = 1.0 + 1e-9


@kernel
def find_near_contacts(worlds: Ints, bodies: Ints, model: Model, state: State) -> None:
    """Write the same flags as ``contact.find_contacts``, in time linear in the number of bodies.

    Bodies in the buckets reach no farther than ``model.bucket_frame[0].reach``.

    Reads: model (bucket_frame, disc_count, disc_start, movable, present, reach, segment_count, segment_start, solid,
        unobstructed), state (bucket_first, bucket_next, discs, hit, nearby, pose, segments).
    Writes: state (collided, hit, nearby).
    """
    frame = model.bucket_frame[0]
    for w in worlds:
        nearby, first, following = state.nearby[w], state.bucket_first[w], state.bucket_next[w]
        poses, there = state.pose[w], model.present[w]
        reaches = model.reach[row_of(model.reach, w)]
        for b in bodies:
            if model.unobstructed[b] or not there[b]:
                continue
            moves = model.movable[b]
            x, y, within = poses[b, 0], poses[b, 1], reaches[b] * ROUNDING + frame.reach
            for j in range(gather_nearby(x, y, within, frame, first, following, nearby)):
                q = nearby[j]
                if q == b or model.unobstructed[q] or not there[q]:
                    continue
                # One test for each pair, see ``contact.find_contacts``.
                if (model.movable[q] == moves and q < b) or (model.movable[q] and not moves):
                    continue
                dx, dy, near = poses[q, 0] - x, poses[q, 1] - y, reaches[b] + reaches[q]
                if dx * dx + dy * dy > near * near * (1.0 + 1e-12):
                    continue
                whole = outline_of(model, state, w, b)
                other = outline_of(model, state, w, q)
                if outlines_overlap(whole, other):
                    note_contact(w, b, q, state)


@kernel
def measure_near_clearance(
    worlds: Ints, bodies: Ints, limit: Floats, model: Model, state: State, distance: Floats
) -> None:
    """Write the same distances as ``contact.measure_clearance``.

    The search radius grows until no closer body can be outside.

    Reads: model (bucket_frame, disc_count, disc_start, present, reach, segment_count, segment_start, solid,
        unobstructed), state (bucket_first, bucket_next, discs, nearby, pose, segments).
    Writes: state (nearby), distance.
    """
    frame = model.bucket_frame[0]
    for w in worlds:
        nearby, first, following = state.nearby[w], state.bucket_first[w], state.bucket_next[w]
        poses, there, discs = state.pose[w], model.present[w], state.discs[w]
        reaches = model.reach[row_of(model.reach, w)]
        n_segments = model.segment_count[row_of(model.segment_count, w)]
        n_discs = model.disc_count[row_of(model.disc_count, w)]
        for k in range(bodies.shape[0]):
            b, best = bodies[k], limit[w, k]
            x, y, radius, d = poses[b, 0], poses[b, 1], reaches[b], model.disc_start[b]
            is_disc = n_segments[b] == 0 and n_discs[b] == 1
            # The first search finds every body whose outline is less than the side of a square away.
            within, is_open = radius + frame.reach + frame.side, True
            while is_open:
                for j in range(gather_nearby(x, y, within, frame, first, following, nearby)):
                    q = nearby[j]
                    dx, dy, near = poses[q, 0] - x, poses[q, 1] - y, best + radius + reaches[q]
                    if dx * dx + dy * dy >= near * near or q == b or model.unobstructed[q] or not there[q]:
                        continue
                    other = outline_of(model, state, w, q)
                    if is_disc:
                        best = disc_outline_distance((discs[d, 0], discs[d, 1]), discs[d, 2], other, best)
                    else:
                        whole = outline_of(model, state, w, b)
                        best = min(best, outline_distance(whole, other, best))
                # A body that the search missed has its origin beyond ``within``, so its outline is farther than
                # ``within`` - own - frame.reach. Once ``best`` is no more than that, nothing nearer can be outside.
                is_open = best + radius + frame.reach > within and not holds_all(x, y, within, frame)
                within *= 2.0
            distance[w, k] = best


@kernel
def holds_all(x: float, y: float, within: float, frame: Record) -> bool:
    """Return whether a search within a distance [m] of a point covers all squares."""
    columns, rows = frame.columns, frame.rows
    return bool(
        square_of(x - within, frame.x, frame.side, columns) == 0
        and square_of(x + within, frame.x, frame.side, columns) == columns - 1
        and square_of(y - within, frame.y, frame.side, rows) == 0
        and square_of(y + within, frame.y, frame.side, rows) == rows - 1
    )
