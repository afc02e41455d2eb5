"""``collision_check: swept``: contacts are found all along the way of a step, not only where it ends.

Within a step, poses go straight from the one before to the one after it, with an even turn. Bodies that a contact stops
stay where it happens, and later contacts of the step are looked for from there.
"""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.errors import ScenarioError
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.cell_maps.world_maps import capsule_meets_map, outline_map_distance
from irsim_gym.simulator.contact.pairs import note_contact
from irsim_gym.simulator.geometry.angles import wrap, wrap_from
from irsim_gym.simulator.geometry.overlap import capsule_meets_outline, outline_distance
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.world.model import ROBOT, STOP, UNOBSTRUCTED_OBSTACLES, Model
from irsim_gym.simulator.world.names import Cells, Flags, Floats, Ints, Shard, State, Struct, kernel, row_of
from irsim_gym.simulator.world.outline import outline_of, place_outline

HALVINGS = 53
"""Halvings that find the time of a contact to the last bit."""
DEPTH = 1e-9
"""How far a disc is put beyond the first contact [m], so that rounding does not undo it."""
FINEST, MOST = 1e-3, 1000
"""Outlines that turn or are no discs are tested along their way every so many metres, or so often in all."""
NEVER = 2.0
EXTERNAL = "swept needs step_mode: internal; with external, bodies move between the steps"


@dataclass(repr=False)
class SweptMotion(Struct):
    """The ways of all bodies within a step.

    Attributes:
        movers: Bodies that can move, shape ``(n,)``.
        start: Poses at the step's start; where a contact has stopped a body, its pose since then, shape ``(n_worlds,
            n_bodies, 3)`` [m, m, rad]; NaN for those that were absent.
        end: Poses at the step's end, likewise.
        change: Difference between both, likewise; zeros for a body that a contact has stopped.
        since: Share of the step after which a body stands, shape ``(n_worlds, n_bodies)``; 0 for those that go on.
        goes: Whether the outline of a body still moves, shape ``(n_worlds, n_bodies)``.
        free: Whether bodies that can move do not stop a body, likewise, see ``simulator.step.patience``.
    """

    movers: Ints
    start: Floats
    end: Floats
    change: Floats
    since: Floats
    goes: Flags
    free: Flags


def lay_sweep(scenario: Scenario, model: Model, movers: Ints, free: Flags | None) -> SweptMotion | None:
    """Return memory for the ways of a step; None where only its end is tested.

    Raises:
        ScenarioError: Bodies move between the steps.
    """
    if scenario.world.collision_check != "swept":
        return None
    if scenario.world.step_mode == "external":
        problem = scenario.problem(("world", "collision_check"), EXTERNAL)
        raise ScenarioError(scenario.file or scenario.name, [problem])
    shape = model.present.shape
    start, end, change = np.zeros((3, *shape, 3))
    goes = np.zeros(shape, np.bool_)
    free = np.zeros_like(goes) if free is None else free
    return SweptMotion(movers, start, end, change, np.zeros(shape), goes, free)


def sweep_bodies(sweep: SweptMotion, model: Model, state: State, shard: Shard) -> None:
    """Note contacts within the step, and put bodies that they stop where they happen."""
    sweep_worlds(shard.worlds, sweep, model.cells, model, state)


@kernel
def note_starts(worlds: Ints, sweep: SweptMotion, model: Model, state: State) -> None:
    """Keep the poses of a step's start.

    Reads: sweep (movers), model (present), state (pose).
    Writes: sweep (start).
    """
    for w in worlds:
        for b in sweep.movers:
            for axis in range(3):
                sweep.start[w, b, axis] = state.pose[w, b, axis] if model.present[w, b] else np.nan


@kernel
def sweep_worlds(worlds: Ints, sweep: SweptMotion, cells: Cells, model: Model, state: State) -> None:
    """Stop bodies at their first contacts, in the order of time; then note contacts that stop nobody who moves.

    Reads: sweep (change, end, free, goes, movers, since, start), model (collision_mode, disc_count, disc_start,
        heading_low, local_discs, local_segments, map_frame, movable, present, reach, role, segment_count,
        segment_start, solid, unobstructed), state (discs, hit, pose, segments).
    Writes: sweep (change, end, goes, since, start), state (collided, discs, hit, pose, segments).
    """
    for w in worlds:
        begin_sweep(w, sweep, model, state)
        while True:
            time, b, q = next_contact(w, True, sweep, cells, model, state)
            if b < 0:
                break
            note_contact(w, b, q, state)
            if stops_at(w, b, q, sweep, model):
                halt(w, b, time, sweep, model, state)
            if stops_at(w, q, b, sweep, model):
                halt(w, q, time, sweep, model, state)
        next_contact(w, False, sweep, cells, model, state)
        for b in sweep.movers:
            change = sweep.change[w, b]
            is_held = change[0] == 0.0 and change[1] == 0.0 and change[2] == 0.0
            for axis in range(3):
                state.pose[w, b, axis] = sweep.start[w, b, axis] if is_held else sweep.end[w, b, axis]
            place_outline(model, state, w, b)


@kernel
def begin_sweep(w: int, sweep: SweptMotion, model: Model, state: State) -> None:
    """Write the ways of world w, and put its bodies back to the start.

    Reads: sweep (change, end, goes, movers, start), model (disc_count, disc_start, local_discs, local_segments,
        movable, present, segment_count, segment_start, solid), state (discs, pose, segments).
    Writes: sweep (change, end, goes, since, start), state (discs, pose, segments).
    """
    sweep.goes[w, :], sweep.since[w, :] = False, 0.0
    for b in range(sweep.since.shape[1]):
        for axis in range(3):
            sweep.end[w, b, axis] = state.pose[w, b, axis]
            # Bodies that cannot move have no other start.
            if not model.movable[b] or np.isnan(sweep.start[w, b, axis]):
                sweep.start[w, b, axis] = state.pose[w, b, axis]
    for b in sweep.movers:
        start, end, change = sweep.start[w, b], sweep.end[w, b], sweep.change[w, b]
        for axis in range(3):
            change[axis] = end[axis] - start[axis]
        change[2] = wrap(change[2])
        is_turned = change[2] != 0.0 and not is_centred(w, b, model)
        sweep.goes[w, b] = model.present[w, b] and (change[0] != 0.0 or change[1] != 0.0 or is_turned)
        put(w, b, 0.0, sweep, model, state)


@kernel
def put(w: int, b: int, time: float, sweep: SweptMotion, model: Model, state: State) -> None:
    """Write pose and outline of body b at a share of the step.

    Reads: sweep (change, goes, start), model (disc_count, disc_start, local_discs, local_segments, segment_count,
        segment_start, solid), state (discs, pose, segments).
    Writes: state (discs, pose, segments).
    """
    if sweep.goes[w, b]:
        for axis in range(3):
            state.pose[w, b, axis] = sweep.start[w, b, axis] + time * sweep.change[w, b, axis]
        place_outline(model, state, w, b)


@kernel
def halt(w: int, b: int, time: float, sweep: SweptMotion, model: Model, state: State) -> None:
    """Let body b stand from a share of the step on.

    Reads: sweep (change, goes, start), model (disc_count, disc_start, heading_low, local_discs, local_segments,
        segment_count, segment_start, solid), state (discs, pose, segments).
    Writes: sweep (change, goes, since, start), state (discs, pose, segments).
    """
    put(w, b, time, sweep, model, state)
    state.pose[w, b, 2] = wrap_from(state.pose[w, b, 2], model.heading_low[b])
    for axis in range(3):
        sweep.start[w, b, axis], sweep.change[w, b, axis] = state.pose[w, b, axis], 0.0
    sweep.since[w, b], sweep.goes[w, b] = time, False


@kernel
def stops_at(w: int, b: int, q: int, sweep: SweptMotion, model: Model) -> bool:
    """Return whether body b moves, and a contact with body q would stop it.

    Reads: sweep (free, goes), model (collision_mode, movable, role).
    """
    mode = model.collision_mode[0]
    holds = mode == STOP or (mode == UNOBSTRUCTED_OBSTACLES and model.role[b] == ROBOT)
    return bool(holds and sweep.goes[w, b] and not (sweep.free[w, b] and model.movable[q]))


@kernel
def next_contact(
    w: int, stopping: bool, sweep: SweptMotion, cells: Cells, model: Model, state: State
) -> tuple[float, int, int]:
    """Return time and bodies of the first contact that stops one of them, -1 if there is none.

    With ``stopping`` False: note all contacts that stop neither.

    Reads: sweep (change, free, goes, movers, since, start), model (collision_mode, disc_count, disc_start, local_discs,
        local_segments, map_frame, movable, present, reach, role, segment_count, segment_start, solid, unobstructed),
        state (discs, hit, pose, segments).
    Writes: state (collided, discs, hit, pose, segments).
    """
    best, first, second, map_body = NEVER, -1, -1, model.map_frame[0].body
    start, change, reaches = sweep.start[w], sweep.change[w], model.reach[row_of(model.reach, w)]
    for b in sweep.movers:
        if not sweep.goes[w, b] or model.unobstructed[b]:
            continue
        for q in range(start.shape[0]):
            near = reaches[b] + reaches[q] + DEPTH
            x, dx = start[b, 0] - start[q, 0], change[b, 0] - change[q, 0]
            y, dy = start[b, 1] - start[q, 1], change[b, 1] - change[q, 1]
            # Origins whose distance exceeds both reaches, all along the way. The boxes tell most of them.
            is_far = max(abs(x) - abs(dx), abs(y) - abs(dy)) > near
            if q != map_body and (is_far or point_segment_distance2(0.0, 0.0, x, y, x + dx, y + dy) > near * near):
                continue
            if q == b or not model.present[w, q] or (model.unobstructed[q] and q != map_body):
                continue
            # One test for each pair: of two that move, the one with the lower number makes it.
            if sweep.goes[w, q] and q < b:
                continue
            if (stops_at(w, b, q, sweep, model) or stops_at(w, q, b, sweep, model)) != stopping:
                continue
            time = contact_time(w, b, q, sweep, cells, model, state)
            if time < best and stopping:
                best, first, second = time, b, q
            elif time < NEVER and not stopping:
                note_contact(w, b, q, state)
    return best, first, second


@kernel
def is_centred(w: int, b: int, model: Model) -> bool:
    """Return whether body b is a disc about its origin, which looks the same at any heading.

    Reads: model (disc_count, disc_start, local_discs, segment_count).
    """
    n_discs = model.disc_count[row_of(model.disc_count, w), b]
    if model.segment_count[row_of(model.segment_count, w), b] != 0 or n_discs != 1:
        return False
    disc = model.local_discs[row_of(model.local_discs, w), model.disc_start[b]]
    return bool(disc[0] == 0.0 and disc[1] == 0.0)


@kernel
def contact_time(w: int, b: int, q: int, sweep: SweptMotion, cells: Cells, model: Model, state: State) -> float:
    """Return the share of the step after which bodies b and q touch, ``NEVER`` if they do not.

    Exact if one of them is a disc about its origin and the other does not turn.

    Reads: sweep (change, goes, since, start), model (disc_count, disc_start, local_discs, local_segments, map_frame,
        reach, segment_count, segment_start, solid), state (discs, pose, segments).
    Writes: state (discs, pose, segments).
    """
    turns_b = sweep.goes[w, b] and sweep.change[w, b, 2] != 0.0
    turns_q = sweep.goes[w, q] and sweep.change[w, q, 2] != 0.0
    if is_centred(w, b, model) and (not turns_q or is_centred(w, q, model)):
        return float(disc_time(w, b, q, sweep, cells, model, state))
    if is_centred(w, q, model) and not turns_b:
        return float(disc_time(w, q, b, sweep, cells, model, state))
    return float(outline_time(w, b, q, sweep, cells, model, state))


@kernel
def disc_time(w: int, b: int, q: int, sweep: SweptMotion, cells: Cells, model: Model, state: State) -> float:
    """Return ``contact_time`` for a disc b, from the area that it sweeps as body q sees it.

    Reads: sweep (change, since), model (disc_count, disc_start, map_frame, segment_count, segment_start, solid), state
        (discs, segments).
    """
    x, y, radius = state.discs[w, model.disc_start[b]]
    dx, dy = sweep.change[w, b, 0] - sweep.change[w, q, 0], sweep.change[w, b, 1] - sweep.change[w, q, 1]
    outline, is_map = outline_of(model, state, w, q), q == model.map_frame[0].body
    begin = max(sweep.since[w, b], sweep.since[w, q])
    low, high, ax, ay = begin, 1.0, x + begin * dx, y + begin * dy
    for k in range(HALVINGS):
        # First the whole way, then the start alone, then halves of what is left.
        time = 1.0 if k == 0 else low if k == 1 else 0.5 * (low + high)
        bx, by = x + time * dx, y + time * dy
        if is_map:
            meets = capsule_meets_map(cells, w, ax, ay, bx, by, radius)
        else:
            meets = capsule_meets_outline((ax, ay), (bx, by), radius, outline)
        if k == 0 and not meets:
            return NEVER
        if k == 1 and meets:
            return float(begin)
        if meets:
            high = time
        else:
            low = time
    return float(min(high + DEPTH / max(np.sqrt(dx * dx + dy * dy), DEPTH), 1.0))


@kernel
def outline_time(w: int, b: int, q: int, sweep: SweptMotion, cells: Cells, model: Model, state: State) -> float:
    """Return ``contact_time`` for any outlines: tests them at times between which they cannot come to touch.

    Where they are nearer than ``FINEST`` to each other, a shorter touch may be missed.

    Reads: sweep (change, goes, since, start), model (disc_count, disc_start, local_discs, local_segments, map_frame,
        reach, segment_count, segment_start, solid), state (discs, pose, segments).
    Writes: state (discs, pose, segments).
    """
    reaches, is_map = model.reach[row_of(model.reach, w)], q == model.map_frame[0].body
    change, other = sweep.change[w, b], sweep.change[w, q]
    dx, dy = change[0] - other[0], change[1] - other[1]
    # No two points of the outlines come nearer to each other than by this in a whole step.
    most = np.sqrt(dx * dx + dy * dy) + abs(change[2]) * reaches[b] + abs(other[2]) * reaches[q]
    time, touch = max(sweep.since[w, b], sweep.since[w, q]), NEVER
    while time <= 1.0:
        put(w, b, time, sweep, model, state)
        put(w, q, time, sweep, model, state)
        outline = outline_of(model, state, w, b)
        if is_map:
            gap = outline_map_distance(cells, w, outline, np.inf)
        else:
            gap = outline_distance(outline, outline_of(model, state, w, q), np.inf)
        if gap <= 0.0:
            touch = time
            break
        time += max(gap, FINEST, most / MOST) / most
    put(w, b, 0.0, sweep, model, state)
    put(w, q, 0.0, sweep, model, state)
    return float(touch)
