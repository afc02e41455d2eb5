"""Who has arrived, and where it goes next."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Words
from irsim_gym.geometry.angles import wrap
from irsim_gym.jit import kernel
from irsim_gym.rng import uniform
from irsim_gym.world.group import Shard
from irsim_gym.world.model import LOOP, STATE, WANDER, WorldModel
from irsim_gym.world.state import WorldState


def check(goal_bodies: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write ``goal_distance`` and ``arrived``; a goal that is not the last one gives way to the next."""
    check_arrival(
        shard.worlds,
        goal_bodies,
        model.arrive_mode,
        model.goal_threshold,
        model.waypoints,
        model.present,
        state.pose,
        state.waypoint_end,
        state.waypoint,
        state.goal,
        state.goal_distance,
        state.arrived,
    )


def measure(goal_bodies: Ints, state: WorldState, shard: Shard) -> None:
    """Write ``goal_distance`` alone, as at the start, where nobody arrives yet."""
    measure_distance(shard.worlds, goal_bodies, state.pose, state.goal, state.goal_distance)


def renew(goal_bodies: Ints, loop_returns: Ints, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Give bodies that arrived and wander or loop their next goals."""
    renew_goals(
        shard.worlds,
        goal_bodies,
        loop_returns,
        model.arrive_mode,
        model.goal_renewal,
        model.wander_low,
        model.wander_high,
        model.waypoint_count,
        state.stopped,
        state.random,
        model.waypoints,
        state.waypoint,
        state.waypoint_end,
        state.goal,
        state.arrived,
    )


@kernel(inlined=True)
def goal_gap(pose: Floats, goal: Floats, with_heading: bool) -> float:
    """Return the distance [m] of a pose from a goal; with a heading, radians count like metres (as in IR-SIM)."""
    dx, dy = goal[0] - pose[0], goal[1] - pose[1]
    turn = wrap(goal[2] - pose[2]) if with_heading and not np.isnan(goal[2]) else 0.0
    return float(np.sqrt(dx * dx + dy * dy + turn * turn))


@kernel
def measure_distance(worlds: Ints, goal_bodies: Ints, pose: Floats, goal: Floats, goal_distance: Floats) -> None:
    """Write the distances to the goals."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(goal_bodies.shape[0]):
            b = goal_bodies[k]
            goal_distance[w, b] = goal_gap(pose[w, b], goal[w, b], False)


@kernel
def check_arrival(
    worlds: Ints,
    goal_bodies: Ints,
    arrive_mode: Ints,
    goal_threshold: Floats,
    waypoints: Floats,
    present: Flags,
    pose: Floats,
    waypoint_end: Ints,
    waypoint: Ints,
    goal: Floats,
    goal_distance: Floats,
    arrived: Flags,
) -> None:
    """Compare each body with its goal; arrival is strictly nearer than the threshold."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(goal_bodies.shape[0]):
            b = goal_bodies[k]
            with_heading = arrive_mode[b] == STATE
            near = goal_gap(pose[w, b], goal[w, b], with_heading)
            arrived[w, b] = present[w, b] and near < goal_threshold[min(w, goal_threshold.shape[0] - 1), b]
            goes_on = arrived[w, b] and waypoint[w, b] + 1 < waypoint_end[w, b]
            if goes_on:
                waypoint[w, b] += 1
                for axis in range(3):
                    goal[w, b, axis] = waypoints[w, b, waypoint[w, b], axis]
                arrived[w, b] = False
            if goes_on or with_heading:
                near = goal_gap(pose[w, b], goal[w, b], False)
            goal_distance[w, b] = near


@kernel
def renew_goals(
    worlds: Ints,
    goal_bodies: Ints,
    loop_returns: Ints,
    arrive_mode: Ints,
    goal_renewal: Ints,
    wander_low: Floats,
    wander_high: Floats,
    waypoint_count: Ints,
    stopped: Flags,
    random: Words,
    waypoints: Floats,
    waypoint: Ints,
    waypoint_end: Ints,
    goal: Floats,
    arrived: Flags,
) -> None:
    """Draw a wandering body's next goal; send a looping one through its goals again.

    On the way between one goal and the start headings do not matter, unless they do on arrival.
    """
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(goal_bodies.shape[0]):
            b = goal_bodies[k]
            if not arrived[w, b] or stopped[w, b]:
                continue
            if goal_renewal[b] == WANDER:
                for axis in range(3):
                    waypoints[w, b, 0, axis] = uniform(random, w, wander_low[b, axis], wander_high[b, axis])
                waypoint_end[w, b] = 1
            elif goal_renewal[b] == LOOP:
                waypoint_end[w, b] = waypoint_count[w, b]
            else:
                continue
            waypoint[w, b] = 0
            for axis in range(3):
                goal[w, b, axis] = waypoints[w, b, 0, axis]
            arrived[w, b] = False
        for k in range(loop_returns.shape[0]):
            b = loop_returns[k]
            if arrive_mode[b] != STATE and waypoint_end[w, b] > 1:
                goal[w, b, 2] = np.nan
