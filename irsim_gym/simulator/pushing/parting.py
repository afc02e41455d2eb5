"""Takes bodies apart that overlap: who moves how far, who stalls, what is reported, and the velocities after it."""

import numpy as np

from irsim_gym.simulator.geometry.separation import Overlap
from irsim_gym.simulator.pushing.candidates import SLOP, find_pairs
from irsim_gym.simulator.pushing.matter import Matter, inverse_inertia
from irsim_gym.simulator.pushing.memory import BLOCKERS, BOUNCES, PAIRS, SEARCHES, Pushing
from irsim_gym.simulator.pushing.outcome import note_forces, note_times, write_motions
from irsim_gym.simulator.pushing.pieces import begin_motion, deepest, push_body
from irsim_gym.simulator.world.names import Cells, Ints, Model, State, Vector, kernel

SWEEPS = 32
TINY = 1e-12
SHORT = 1e-6
"""Shorter levers do not turn a body [m]."""


@kernel
def part_bodies(
    worlds: Ints, slot: int, push: Pushing, matter: Matter, cells: Cells, model: Model, state: State
) -> None:
    """Take all bodies apart, and note what they feel.

    Reads: push (blockers, bounces, boxes, corners, counts, drive, felt, items, margin, motions, n_reports, order,
        pairs, reports, sequence, spans), matter (centre, corners, edge_rank, first_corner, first_piece, inertia,
        map_box, n_corners, rounding, substance), model (disc_count, disc_start, local_discs, local_segments, map_frame,
        movable, present, segment_count, segment_start, solid, step_time, unobstructed, velocity_max), state (discs,
        pose, segments, twist, velocity).
    Writes: push (blockers, bounces, boxes, corners, counts, felt, items, margin, motions, n_reports, order, pairs,
        reports, sequence, spans), state (discs, pose, segments, twist, velocity).
    """
    for w in worlds:
        push.n_reports[w] = 0
        find_pairs(w, slot, push, matter, model, state)
        n_pairs = push.counts[slot, PAIRS]
        if n_pairs > 0:
            begin_motions(w, slot, push, matter, state)
            for _ in range(SWEEPS):
                if not sweep_once(w, slot, push, matter, cells, model, state):
                    break
            write_motions(w, slot, push, matter, model, state)
            note_forces(w, slot, push, matter, model, state)
        note_times(w, push, model)


@kernel
def begin_motions(w: int, slot: int, push: Pushing, matter: Matter, state: State) -> None:
    """Begin the motions of all bodies in pairs.

    Reads: push (counts, motions, pairs), matter (centre, corners, first_corner, first_piece, n_corners, rounding),
        state (pose).
    Writes: push (corners, counts, motions, spans).
    """
    motions, pairs = push.motions[slot], push.pairs[slot]
    push.counts[slot, BOUNCES], push.counts[slot, SEARCHES] = 0, 0
    for k in range(push.counts[slot, PAIRS]):
        motions[pairs[k].a].mark, motions[pairs[k].b].mark = -1, -1
    for k in range(push.counts[slot, PAIRS]):
        for b in (pairs[k].a, pairs[k].b):
            if motions[b].mark < 0:
                begin_motion(w, slot, b, push, matter, state.pose[w, b])


@kernel
def sweep_once(w: int, slot: int, push: Pushing, matter: Matter, cells: Cells, model: Model, state: State) -> bool:
    """Take the bodies of each pair apart, in order; return whether any has moved.

    Reads: push (blockers, bounces, boxes, corners, counts, margin, motions, n_reports, order, pairs, reports, sequence,
        spans), matter (corners, edge_rank, first_corner, first_piece, inertia, n_corners, rounding, substance), state
        (twist).
    Writes: push (blockers, bounces, corners, counts, motions, n_reports, order, pairs, reports, spans).
    """
    motions, pairs, n_pairs = push.motions[slot], push.pairs[slot], push.counts[slot, PAIRS]
    push.counts[slot, BLOCKERS] = 0
    drives = False
    for k in range(n_pairs):
        a, b = pairs[k].a, pairs[k].b
        motions[a].blocker, motions[b].blocker = -1, -1
        drives = drives or matter.substance[a].passive != matter.substance[b].passive
    for k in range(n_pairs if drives else 0):
        pair = pairs[k]
        one, other = matter.substance[pair.a], matter.substance[pair.b]
        pair.touches = False
        if one.passive and other.passive and one.inverse > 0.0 and other.inverse > 0.0:
            found = overlap_of(w, slot, k, push, matter, cells)
            pair.touches, pair.tx, pair.ty = found[0] > -np.inf, found[1], found[2]
    has_moved = False
    for k in range(n_pairs):
        p = push.sequence[slot, k]
        found = overlap_of(w, slot, p, push, matter, cells)
        if found[0] > -np.inf:
            has_moved = part_pair(w, slot, p, found, push, matter, state) or has_moved
    return has_moved


@kernel
def overlap_of(w: int, slot: int, p: int, push: Pushing, matter: Matter, cells: Cells) -> Overlap:
    """Return the deepest overlap of a pair, which is looked for again only if one of its bodies has moved since.

    Reads: push (boxes, corners, margin, motions, pairs, spans), matter (edge_rank, first_corner, first_piece,
        n_corners, rounding).
    Writes: push (corners, pairs, spans).
    """
    pair = push.pairs[slot, p]
    moves = push.motions[slot, pair.a].moves + push.motions[slot, pair.b].moves
    if pair.moves != moves:
        pair.moves = moves
        pair.depth, pair.nx, pair.ny, pair.x, pair.y = deepest(w, slot, pair.a, pair.b, push, matter, cells)
    return pair.depth, pair.nx, pair.ny, pair.x, pair.y


@kernel
def part_pair(w: int, slot: int, p: int, found: Overlap, push: Pushing, matter: Matter, state: State) -> bool:
    """Take the bodies of a pair apart; return whether they move.

    Reads: push (blockers, bounces, counts, motions, n_reports, order, pairs, reports), matter (corners, first_corner,
        first_piece, inertia, n_corners, rounding, substance), state (twist).
    Writes: push (blockers, bounces, corners, counts, motions, n_reports, order, pairs, reports, spans).
    """
    pair = push.pairs[slot, p]
    a, b = pair.a, pair.b
    one, other = matter.substance[a], matter.substance[b]
    nx, ny, depth = found[1], found[2], found[0] + SLOP
    ax, ay, gain_a = free_motion(slot, a, nx, ny, push, matter)
    bx, by, gain_b = free_motion(slot, b, -nx, -ny, push, matter)
    lever_a, lever_b = lever(slot, a, found, push), lever(slot, b, found, push)
    spin_a, spin_b = lever_a * inverse_inertia(matter, w, a), lever_b * inverse_inertia(matter, w, b)
    share_a, share_b = gain_a * one.inverse, gain_b * other.inverse
    turn_a, turn_b = lever_a * spin_a, lever_b * spin_b
    # Who drives pushes what it can, which keeps its way; else it stalls.
    if not one.passive and other.passive and other.inverse > 0.0:
        if one.grip >= load(slot, b, -nx, -ny, push, matter):
            if share_b > 0.0:
                share_a, turn_a = 0.0, 0.0
        else:
            share_b, turn_b = 0.0, 0.0
    if not other.passive and one.passive and one.inverse > 0.0:
        if other.grip >= load(slot, a, nx, ny, push, matter):
            if share_a > 0.0:
                share_b, turn_b = 0.0, 0.0
        else:
            share_a, turn_a = 0.0, 0.0
    total = share_a + turn_a + share_b + turn_b
    if total <= 0.0:
        return False
    if depth > 0.0:
        q = depth / total
        pair.impulse += q
        note_bounce(w, slot, p, (nx, ny), (share_a + turn_a > 0.0, share_b + turn_b > 0.0), push, matter, state)
        by_a, by_b = (q * one.inverse if share_a > 0.0 else 0.0), (q * other.inverse if share_b > 0.0 else 0.0)
        push_body(w, slot, a, (by_a * ax, by_a * ay), q * spin_a if turn_a > 0.0 else 0.0, push, matter)
        push_body(w, slot, b, (by_b * bx, by_b * by), -q * spin_b if turn_b > 0.0 else 0.0, push, matter)
    if share_b <= 0.0 and one.inverse > 0.0:
        block(slot, a, -nx, -ny, other.friction, push)
    if share_a <= 0.0 and other.inverse > 0.0:
        block(slot, b, nx, ny, one.friction, push)
    report_contact(w, p, slot, found, depth, push)
    return depth > 0.0


@kernel
def free_motion(slot: int, b: int, x: float, y: float, push: Pushing, matter: Matter) -> tuple[float, float, float]:
    """Return how a body moves that is pushed along a unit vector, past what blocks it, and how far along the vector.

    Reads: push (blockers, motions), matter (substance).
    """
    k, most, best = push.motions[slot, b].blocker, 0.0, -1
    while k >= 0:
        blocker = push.blockers[slot, k]
        into = x * blocker.nx + y * blocker.ny
        # They are in reverse order, so that the first of equal ones comes last.
        if into > 0.0 and into >= most:
            most, best = into, k
        k = blocker.next
    if best < 0:
        return x, y, 1.0
    blocker, stuff = push.blockers[slot, best], matter.substance[b]
    mx, my = x - most * blocker.nx, y - most * blocker.ny
    gain = mx * x + my * y
    sticks = stuff.passive and np.sqrt(mx * mx + my * my) <= 0.5 * (stuff.friction + blocker.friction) * most
    return (0.0, 0.0, 0.0) if gain <= TINY or sticks else (mx, my, gain)


@kernel
def lever(slot: int, b: int, found: Overlap, push: Pushing) -> float:
    """Return the lever of a contact about a body's centre of mass [m].

    Reads: push (motions).
    """
    motion = push.motions[slot, b]
    x, y = found[3] - (motion.cx + motion.dx), found[4] - (motion.cy + motion.dy)
    arm = x * found[2] - y * found[1]
    return arm if abs(arm) > SHORT else 0.0


@kernel
def load(slot: int, b: int, x: float, y: float, push: Pushing, matter: Matter) -> float:
    """Return the friction [N] of a body that is pushed along a unit vector, and of all that it pushes in turn.

    Reads: push (counts, motions, order, pairs), matter (substance).
    Writes: push (counts, motions, order).
    """
    pairs, motions, queue = push.pairs[slot], push.motions[slot], push.order[slot, 2]
    push.counts[slot, SEARCHES] += 1
    search, total, n_found = push.counts[slot, SEARCHES], matter.substance[b].grip, 1
    queue[0], motions[b].mark = b, search
    first = 0
    while first < n_found:
        here = queue[first]
        first += 1
        for k in range(push.counts[slot, PAIRS]):
            pair = pairs[k]
            if not pair.touches or (pair.a != here and pair.b != here):
                continue
            other, sign = (pair.b, 1.0) if pair.a == here else (pair.a, -1.0)
            if motions[other].mark != search and sign * (x * pair.tx + y * pair.ty) < -TINY:
                motions[other].mark = search
                queue[n_found] = other
                n_found += 1
                total += matter.substance[other].grip
    return float(total)


@kernel
def note_bounce(
    w: int, slot: int, p: int, normal: Vector, frees: tuple[bool, bool], push: Pushing, matter: Matter, state: State
) -> None:
    """Note how fast the bodies of a pair should part, if they approach each other.

    Reads: push (bounces, counts, pairs), matter (substance), state (twist).
    Writes: push (bounces, counts).
    """
    a, b, (nx, ny) = push.pairs[slot, p].a, push.pairs[slot, p].b, normal
    restitution = 0.5 * (matter.substance[a].restitution + matter.substance[b].restitution)
    if restitution <= 0.0:
        return
    approach = (state.twist[w, a, 0] - state.twist[w, b, 0]) * nx + (state.twist[w, a, 1] - state.twist[w, b, 1]) * ny
    for k in range(push.counts[slot, BOUNCES]):
        if push.bounces[slot, k].a == a and push.bounces[slot, k].b == b:
            return
    if approach < 0.0:
        bounce = push.bounces[slot, push.counts[slot, BOUNCES]]
        push.counts[slot, BOUNCES] += 1
        bounce.a, bounce.b, bounce.nx, bounce.ny, bounce.speed = a, b, nx, ny, -restitution * approach
        bounce.frees_a, bounce.frees_b = frees[0], frees[1]


@kernel
def block(slot: int, b: int, nx: float, ny: float, friction: float, push: Pushing) -> None:
    """Note that a body cannot move along a unit vector for the rest of the sweep.

    Reads: push (counts, motions).
    Writes: push (blockers, counts, motions).
    """
    k, motion = push.counts[slot, BLOCKERS], push.motions[slot, b]
    push.counts[slot, BLOCKERS] += 1
    blocker = push.blockers[slot, k]
    blocker.nx, blocker.ny, blocker.friction, blocker.next = nx, ny, friction, motion.blocker
    motion.blocker = k


@kernel
def report_contact(w: int, p: int, slot: int, found: Overlap, depth: float, push: Pushing) -> None:
    """Report a contact, or that it is deeper than reported so far.

    Reads: push (n_reports, pairs, reports).
    Writes: push (n_reports, pairs, reports).
    """
    pair = push.pairs[slot, p]
    if pair.report < 0:
        pair.report = push.n_reports[w]
        push.n_reports[w] += 1
    elif depth <= push.reports[w, pair.report].depth:
        return
    told = push.reports[w, pair.report]
    told.a, told.b, told.nx, told.ny, told.depth = pair.a, pair.b, found[1], found[2], depth
    told.x, told.y, told.force = found[3], found[4], 0.0
