"""Restarts or removes single bodies while their worlds go on."""

from dataclasses import replace

import numpy as np

from irsim_gym.base.errors import PlacementError
from irsim_gym.simulator.cell_paths.queries import has_free_path, standing_bodies
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.levels import path_checks
from irsim_gym.simulator.pushing.memory import forget_contacts
from irsim_gym.simulator.step import arrival, disturbances, outlines
from irsim_gym.simulator.step.arrival import begin_round
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.step.restart import forget_bodies
from irsim_gym.simulator.step.step import sense
from irsim_gym.simulator.world.model import KEEP_GOAL
from irsim_gym.simulator.world.names import Flags, Group, Ints, Model, Shard, State, kernel, uniform

TRIES = 10
"""Number of draws from a body's own distribution before any free place is accepted."""

SCATTER_TRIES = 1000

WAYS_SOUGHT = 50
"""Number of free places that are tried for a path to the goal before one without a path is accepted."""


def vanish(bodies: Ints, gone: Flags, model: Model, state: State, shard: Shard) -> None:
    """Remove bodies until their world begins another level or they respawn.

    Args:
        bodies: Candidates, shape ``(n,)``.
        gone: Which of them are removed, shape ``(n_worlds, n)``.
        model: The constants; ``present`` and ``altered`` are rewritten.
        state: State of the worlds.
        shard: The worlds to treat.
    """
    remove(shard.worlds, bodies, gone, model)
    body_buckets.refresh(bodies, model, state, shard)


@kernel
def remove(worlds: Ints, bodies: Ints, gone: Flags, model: Model) -> None:
    """Mark bodies as absent, and mark the worlds in which any is.

    Writes: model (altered, present).
    """
    for w in worlds:
        for k in range(bodies.shape[0]):
            if gone[w, k]:
                model.present[w, bodies[k]], model.altered[w] = False, True


def respawn(parts: Parts, model: Model, state: State, shard: Shard, bodies: Ints, chosen: Flags) -> None:
    """Draw new starts and goals for bodies in running worlds. They start at rest and clear of everything.

    Each body is placed by the distribution of its entry, as at the start of a level. If every draw fails, it is placed
    anywhere in the world, if possible with a path to its goals. Then all sensors of these worlds are read again.

    Args:
        parts: The compiled scenario.
        model: Its constants. Goals and presence of the chosen bodies are rewritten; ``start`` remains that of the
            level.
        state: Its state; rewritten.
        shard: The worlds.
        bodies: Candidates, shape ``(n,)``.
        chosen: Which of them respawn, shape ``(n_worlds, n)``.

    Raises:
        PlacementError: There is no room.
    """
    _find_places(parts, model, state, shard, bodies, chosen)
    # ``begin`` of a drive writes the twists of all its members: those of the bodies that go on are restored below.
    twist = state.twist[shard.worlds]
    forget_bodies(parts, shard, bodies, chosen)
    begin_bodies(shard.worlds, bodies, chosen, model, state)
    if parts.pushing is not None:
        forget_contacts(shard.worlds, bodies, chosen, parts.pushing, state)
    for group in parts.kinematics:
        group.kind.begin(group, model, state, shard)
    begun = np.zeros(twist.shape[:2], np.bool_)
    begun[:, bodies] = chosen[shard.worlds]
    state.twist[shard.worlds] = np.where(begun[:, :, None], state.twist[shard.worlds], twist)
    body_buckets.refresh(bodies, model, state, shard)
    arrival.measure_distance(shard.worlds, parts.goal_bodies, state)
    disturbances.begin_again(parts.disturbances, state, shard, begun)
    sense(parts, model, state, shard)


def _find_places(parts: Parts, model: Model, state: State, shard: Shard, bodies: Ints, chosen: Flags) -> None:
    """Write poses, outlines and goals of the chosen bodies."""
    failed = np.zeros(len(state.random), np.int64)
    model.altered[shard.worlds] |= chosen[shard.worlds].any(axis=1)
    moved = bodies[chosen[shard.worlds].any(axis=0)]
    groups = [group for group in parts.placements if np.isin(group.members, moved).any()]
    remaining = shard
    for _ in range(TRIES):
        unplace(remaining.worlds, bodies, chosen, model, state, failed)
        for group in groups:
            group.kind.draw(group, model, state, _concerned(group, remaining, bodies, chosen), failed)
        outlines.place(moved, model, state, remaining)
        body_buckets.refresh(moved, model, state, remaining)
        _check(parts, model, state, remaining, bodies, chosen, failed)
        # The next try draws only for the worlds in which this one failed.
        worlds = remaining.worlds[failed[remaining.worlds] > 0]
        if not len(worlds):
            return
        remaining = Shard(worlds, shard.slot)
    for w in remaining.worlds.tolist():
        _scatter(parts, model, state, Shard(np.array([w]), shard.slot), bodies[chosen[w]])


def _concerned(group: Group, shard: Shard, bodies: Ints, chosen: Flags) -> Shard:
    """Return the worlds in which a member respawns. Other worlds must not draw from their random streams."""
    members = chosen[shard.worlds][:, np.isin(bodies, group.members)]
    return Shard(shard.worlds[members.any(axis=1)], shard.slot)


def _check(parts: Parts, model: Model, state: State, shard: Shard, bodies: Ints, chosen: Flags, failed: Ints) -> None:
    """Set ``failed`` where a chosen body overlaps something, or lacks a path to its goal that it needs."""
    # Only a distance of 0 matters. With so small a limit, distances are measured only of what is about to touch.
    gap = np.full((len(failed), len(bodies)), 1e-9)
    contact.clearance(bodies, gap, model, state, shard, gap)
    blocked = (chosen & (gap <= 0.0))[shard.worlds].any(axis=1)
    failed[shard.worlds[blocked]] = 1
    for w in shard.worlds.tolist() if len(parts.ways.agents) else []:
        guarded = parts.ways.agents[np.isin(parts.ways.agents, bodies[chosen[w]])]
        path_checks.check(replace(parts.ways, agents=guarded), model, state, Shard(np.array([w]), shard.slot), failed)


def _scatter(parts: Parts, model: Model, state: State, shard: Shard, bodies: Ints) -> None:
    """Place the bodies of one world anywhere in its rectangle where they touch nothing, if possible with a path."""
    w = int(shard.worlds[0])
    x0, y0, x1, y1 = model.bounds.tolist()
    for b in bodies.tolist():
        free, sought = None, WAYS_SOUGHT if _needs_way(parts, b) else 0
        for _ in range(SCATTER_TRIES):
            bounds = (x0, x1), (y0, y1), (-np.pi, np.pi)
            pose = [uniform(state.random, w, low, high) for low, high in bounds]
            if not _is_free(model, state, shard, b, pose):
                continue
            # Kept even without a way: if none with a way turns up, the last free pose is taken.
            free = pose
            if sought == 0 or _has_way(model, state, w, b):
                break
            sought -= 1
        if free is None:
            raise PlacementError(f"no room for {parts.places[b]} to begin anew: the world is too full")
        # The pose tried last need not be the chosen one: put the body there again.
        _is_free(model, state, shard, b, free)
        state.placed[w, b] = True


def _is_free(model: Model, state: State, shard: Shard, b: int, pose: list[float]) -> bool:
    """Place a body of one world at a pose, and return whether it touches nothing there."""
    w, members = int(shard.worlds[0]), np.array([b])
    state.pose[w, b] = pose
    outlines.place(members, model, state, shard)
    body_buckets.refresh(members, model, state, shard)
    gap = np.zeros((len(state.random), 1))
    gap[w] = 1e-9
    contact.clearance(members, gap, model, state, shard, gap)
    return bool(gap[w, 0] > 0.0)


def _needs_way(parts: Parts, b: int) -> bool:
    """Return whether every level must have a path for a body."""
    promised = [group for group in parts.placements if group.options[0].ensures_way]
    return b in parts.ways.agents or any(b in group.members for group in promised)


def _has_way(model: Model, state: State, w: int, b: int) -> bool:
    """Return whether a disc around a body has a path from its position through all of its goals."""
    if not model.has_goal[b] or model.goal_renewal[b] != KEEP_GOAL:
        return True
    goals = model.waypoints[w, b, : model.waypoint_count[w, b]]
    reach, blocks = float(model.reach[w % len(model.reach), b]), standing_bodies(model, w)
    blocks[b] = False
    ends = zip([state.pose[w, b], *goals], goals, strict=False)
    return all(has_free_path(model, state, w, reach, start, goal, blocks=blocks) for start, goal in ends)


@kernel
def unplace(worlds: Ints, bodies: Ints, chosen: Flags, model: Model, state: State, failed: Ints) -> None:
    """Mark the chosen bodies as present and as still to be placed.

    Writes: model (present), state (placed), failed.
    """
    for w in worlds:
        failed[w] = 0
        for k in range(bodies.shape[0]):
            if chosen[w, k]:
                model.present[w, bodies[k]], state.placed[w, bodies[k]] = True, False


@kernel
def begin_bodies(worlds: Ints, bodies: Ints, chosen: Flags, model: Model, state: State) -> None:
    """Give the chosen bodies their first goals, initial velocities and cleared flags.

    Reads: model (abreast, goal_renewal, has_goal, initial_steering, initial_velocity, leader, present, wander_high,
        wander_low, wandering, waypoint_count, waypoints), state (goal, pose, random).
    Writes: model (waypoints), state (arrived, collided, goal, hit, plan, random, steering, stopped, velocity, waypoint,
        waypoint_end).
    """
    for w in worlds:
        for k in range(bodies.shape[0]):
            if not chosen[w, k]:
                continue
            b = bodies[k]
            state.steering[w, b], state.hit[w, b] = model.initial_steering[b], -1
            state.plan[w, b, 0], state.plan[w, b, 1] = 0.0, 0.0
            state.arrived[w, b], state.collided[w, b], state.stopped[w, b] = False, False, False
            for axis in range(3):
                state.velocity[w, b, axis] = model.initial_velocity[b, axis]
            if model.has_goal[b]:
                begin_round(w, b, True, model, state)
