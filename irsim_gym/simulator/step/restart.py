"""Begins an episode: draws a level from its random stream."""

from collections.abc import Callable

import numpy as np

from irsim_gym.base.errors import PlacementError
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.levels import body_measures, path_checks, traits
from irsim_gym.simulator.levels.level_table import LevelTable, copy_levels, copy_maps
from irsim_gym.simulator.pushing.matter import renew_matter
from irsim_gym.simulator.pushing.memory import begin_pushing
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.step import arrival, disturbances, fog, outlines, patience
from irsim_gym.simulator.step.arrival import begin_round
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.step.step import let_appear, sense
from irsim_gym.simulator.world.model import STATE
from irsim_gym.simulator.world.names import Flags, Ints, Model, Shard, State, Words, integer, kernel

LEVEL_TRIES = 100

Phase = Callable[[Shard], None]


def begin(state: State, shard: Shard, draw: Fused, start: Phase) -> None:
    """Draw a level for each world of the shard, repeat failed draws, and begin it.

    Args:
        state: The moment; ``random`` holds the stream of each level.
        shard: The worlds.
        draw: ``draw_level`` for some worlds.
        start: ``start_drawn`` for some worlds.

    Raises:
        RuntimeError: A body found no place in any of the tries; ``check_drawn`` says which.
    """
    draw.repeat(shard, state.failed, LEVEL_TRIES)
    refuse_failed(shard.worlds, state.failed)
    start(shard)


def check_drawn(parts: Parts, state: State, worlds: Ints) -> None:
    """Raise a PlacementError if a level of the worlds could not be drawn."""
    failed = state.failed[worlds]
    if (failed > 0).any():
        raise PlacementError(_failure(parts.places[failed[failed > 0][0] - 1]))


@kernel
def refuse_failed(worlds: Ints, failed: Ints) -> None:
    """Fail if something failed in one of the worlds, ``(n,)``, so that the following calls are skipped."""
    for w in worlds:
        if failed[w] > 0:
            raise RuntimeError("a level could not be drawn")


def start_drawn(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Begin the episode of levels that were just drawn, and store the present state of their random streams."""
    if len(parts.traits):
        traits.draw_traits(shard.worlds, parts.traits, model, state)
    if len(parts.measured):
        body_measures.measure(shard.worlds, parts.measured, model)
    if parts.matter is not None:
        renew_matter(shard.worlds, parts.matter, model)
    copy_words(shard.worlds, model, state)
    start(parts, model, state, shard)


def begin_again(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Begin the present level of each world again, from ``model.start``, with the same random numbers."""
    state.random[shard.worlds] = model.level_random[shard.worlds]
    state.pose[shard.worlds] = model.start[shard.worlds]
    outlines.place(parts.everyone, model, state, shard)
    start(parts, model, state, shard)


def start(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Begin the episode where the bodies stand: clocks, flags, goals and first readings."""
    if parts.fog is not None:
        fog.cover(parts.fog, shard)
    if parts.patience is not None:
        patience.begin_patience(shard.worlds, parts.patience)
    body_buckets.empty(model, state, shard)
    body_buckets.refresh(parts.everyone, model, state, shard)
    begin_moment(parts, model, state, shard)
    let_appear(parts, model, state, shard, ahead=0)
    empty_memories(parts, shard)
    for group in parts.kinematics:
        group.kind.begin(group, model, state, shard)
    contact.find_static(parts.fixed, model, state, shard)
    contact.stop_bodies(shard.worlds, model, state)
    arrival.measure_distance(shard.worlds, parts.goal_bodies, state)
    if parts.pushing is not None:
        begin_pushing(shard.worlds, parts.pushing, state)
    disturbances.begin(parts.disturbances, model, state, shard)
    disturbances.tell(parts.disturbances, parts.everyone, state, shard)
    sense(parts, model, state, shard)


def empty_memories(parts: Parts, shard: Shard) -> None:
    """Clear the memory of kinds where episodes begin: calls ``begin`` of behaviours and sensors that have it."""
    for group in parts.remembering:
        group.arrays["memory"][shard.worlds] = None
    for group in (*parts.behaviors, *parts.group_behaviors, *parts.sensors):
        if hasattr(group.kind, "begin"):
            group.kind.begin(group, shard)


def forget_bodies(parts: Parts, shard: Shard, bodies: Ints, chosen: Flags) -> None:
    """Clear what functions remember of the bodies in ``chosen``, shape ``(n_worlds, n_bodies)``."""
    row, k = np.nonzero(chosen[shard.worlds])
    for group in parts.remembering:
        group.arrays["memory"][shard.worlds[row], bodies[k]] = None


def _failure(place: str) -> str:
    return (
        f"no place found for {place}, or no way to its goal, in {LEVEL_TRIES} draws of the level: "
        "the world is too full, or the bounds, goals, min_distance, clearance, min_goal_distance or radius of its "
        "distribution leave no room for its size"
    )


@kernel
def note_streams(worlds: Ints, streams: Words, random: Words, model: Model) -> None:
    """Start the random streams from which levels are drawn, and store them; arrays ``(n_worlds,)``.

    Writes: random, model (altered, level_stream).
    """
    for w in worlds:
        random[w], model.level_stream[w], model.altered[w] = streams[w], streams[w], False


@kernel
def copy_words(worlds: Ints, model: Model, state: State) -> None:
    """Note where the random streams are once a level is drawn, so that it can begin again with the same numbers.

    Reads: state (random).
    Writes: model (level_random).
    """
    for w in worlds:
        model.level_random[w] = state.random[w]


def draw_level(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Draw presence, maps, outlines and placements, and write ``state.failed``; copy what a file of levels gives."""
    for group in parts.disturbances.outlines:
        group.kind.disturb(group, model, state, shard)
    if parts.levels is not None:
        take_level(parts, parts.levels, model, state, shard)
        return
    failed = state.failed
    draw_presence(shard.worlds, parts.number_ranges, model, state, failed)
    for group in (*parts.maps, *parts.footprints):
        group.kind.draw(group, model, state, shard)
    for group in parts.placements:
        group.kind.draw(group, model, state, shard, failed)
        outlines.place(group.members, model, state, shard)
    for group in parts.promised:
        group.kind.confirm(group, model, state, shard, failed)
    path_checks.check(parts.ways, model, state, shard, failed)


def take_level(parts: Parts, levels: LevelTable, model: Model, state: State, shard: Shard) -> None:
    """Copy a level from its file. Bodies that the file does not place start as the scenario says."""
    # Draws no numbers, as there are no ranges: marks all bodies as present and not placed.
    draw_presence(shard.worlds, levels.no_ranges, model, state, state.failed)
    copy_levels(shard.worlds, levels, model, state)
    if (cells := model.cells) is not None and len(levels.cells):
        copy_maps(shard.worlds, shard.slot, levels, cells, model)
    for group in parts.free:
        group.kind.draw(group, model, state, shard, state.failed)
    outlines.place(parts.everyone, model, state, shard)
    for group in parts.promised:
        group.kind.confirm(group, model, state, shard, state.failed)


@kernel
def draw_presence(worlds: Ints, number_ranges: Ints, model: Model, state: State, failed: Ints) -> None:
    """Draw the number of bodies of each entry with a ``number_range``, and mark all bodies as not placed.

    Reads: state (random).
    Writes: model (present), state (placed, pose, random), failed.
    """
    for w in worlds:
        failed[w] = 0
        state.placed[w, :] = False
        model.present[w, :] = True
        state.pose[w, :, :] = 0.0
        for k in range(number_ranges.shape[0]):
            first, fewest, most = number_ranges[k, 0], number_ranges[k, 1], number_ranges[k, 2]
            # The bodies of an entry follow each other: the first ``drawn`` of them are present.
            drawn = integer(state.random, w, fewest, most + 1)
            for b in range(first + drawn, first + most):
                model.present[w, b] = False


def begin_moment(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Set clocks, flags, velocities and first goals."""
    write_first_goals(shard.worlds, parts.goal_bodies, parts.loop_returns, model, state)
    clear_moment(shard.worlds, model, state)


@kernel
def clear_moment(worlds: Ints, model: Model, state: State) -> None:
    """Reset what an episode accumulates.

    Reads: model (initial_steering, initial_velocity).
    Writes: state (arrived, collided, command, hit, plan, steering, step, stopped, time, twist, velocity).
    """
    for w in worlds:
        state.time[w], state.step[w] = 0.0, 0
        for b in range(state.hit.shape[1]):
            state.steering[w, b] = model.initial_steering[b]
            state.plan[w, b, 0], state.plan[w, b, 1] = 0.0, 0.0
            state.arrived[w, b], state.collided[w, b], state.stopped[w, b], state.hit[w, b] = False, False, False, -1
            for axis in range(3):
                state.command[w, b, axis], state.twist[w, b, axis] = 0.0, 0.0
                state.velocity[w, b, axis] = model.initial_velocity[b, axis]


@kernel
def write_first_goals(worlds: Ints, goal_bodies: Ints, loop_returns: Ints, model: Model, state: State) -> None:
    """Set the first goal of each body, NaN for an absent one.

    Wandering bodies draw theirs. Bodies that loop with a single goal return to their start.

    Reads: model (abreast, arrive_mode, goal_renewal, leader, present, start, wander_high, wander_low, wandering,
        waypoint_count, waypoints), state (goal, pose, random).
    Writes: model (start, waypoints), state (goal, random, waypoint, waypoint_end).
    """
    for w in worlds:
        for b in range(model.start.shape[1]):
            for axis in range(3):
                model.start[w, b, axis] = state.pose[w, b, axis]
        for b in goal_bodies:
            if model.present[w, b]:
                begin_round(w, b, True, model, state)
            else:
                state.waypoint[w, b], state.waypoint_end[w, b] = 0, model.waypoint_count[w, b]
                state.goal[w, b, :] = np.nan
        for b in loop_returns:
            # Row 0 is the goal and row 1 the start. The first round ends at the goal, later ones at the start.
            state.waypoint_end[w, b] = 1
            # Where headings do not count on arrival, that of row 1 stays NaN.
            for axis in range(3 if model.arrive_mode[b] == STATE else 2):
                model.waypoints[w, b, 1, axis] = model.start[w, b, axis]
