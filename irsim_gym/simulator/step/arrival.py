"""Arrival at goals, and the next goals."""

import numpy as np

from irsim_gym.simulator.geometry.angles import wrap
from irsim_gym.simulator.world.model import KEEP_GOAL, STATE, WANDER, Model
from irsim_gym.simulator.world.names import Floats, Ints, State, kernel, row_of, uniform

SAME_PLACE = 1e-6
"""Goals closer to each other than this [m] count as equal."""


@kernel(inlined=True)
def goal_gap(pose: Floats, goal: Floats, with_heading: bool) -> float:
    """Return the distance [m] of a pose from a goal.

    If the heading matters, a difference of 1 rad counts like 1 m, as in IR-SIM.
    """
    dx, dy = goal[0] - pose[0], goal[1] - pose[1]
    turn = wrap(goal[2] - pose[2]) if with_heading and not np.isnan(goal[2]) else 0.0
    return float(np.sqrt(dx * dx + dy * dy + turn * turn))


@kernel
def measure_distance(worlds: Ints, goal_bodies: Ints, state: State) -> None:
    """Write ``goal_distance`` only, as at the start, where no body arrives yet.

    Reads: state (goal, pose).
    Writes: state (goal_distance).
    """
    for w in worlds:
        for b in goal_bodies:
            state.goal_distance[w, b] = goal_gap(state.pose[w, b], state.goal[w, b], False)


@kernel
def check_arrival(worlds: Ints, goal_bodies: Ints, model: Model, state: State) -> None:
    """Write ``goal_distance`` and ``arrived``; replace a goal that is not the last one by the next.

    A body arrives when it is strictly nearer than the threshold.

    Reads: model (arrive_mode, goal_threshold, present, waypoints), state (arrived, goal, pose, waypoint, waypoint_end).
    Writes: state (arrived, goal, goal_distance, waypoint).
    """
    for w in worlds:
        for b in goal_bodies:
            with_heading = model.arrive_mode[b] == STATE
            near = goal_gap(state.pose[w, b], state.goal[w, b], with_heading)
            threshold = model.goal_threshold[row_of(model.goal_threshold, w), b]
            state.arrived[w, b] = model.present[w, b] and near < threshold
            goes_on = state.arrived[w, b] and state.waypoint[w, b] + 1 < state.waypoint_end[w, b]
            if goes_on:
                state.waypoint[w, b] += 1
                for axis in range(3):
                    state.goal[w, b, axis] = model.waypoints[w, b, state.waypoint[w, b], axis]
                state.arrived[w, b] = False
            # ``goal_distance`` is the plane distance to the goal that is next now; headings only decide on arrival.
            if goes_on or with_heading:
                near = goal_gap(state.pose[w, b], state.goal[w, b], False)
            state.goal_distance[w, b] = near


@kernel
def renew_goals(worlds: Ints, goal_bodies: Ints, loop_returns: Ints, model: Model, state: State) -> None:
    """Draw the next goal of a wandering body, and send a looping body through its goals again.

    Between the start and a single goal, headings are ignored unless they matter on arrival.

    Reads: model (abreast, arrive_mode, goal_renewal, leader, present, wander_high, wander_low, wandering,
        waypoint_count, waypoints), state (arrived, goal, pose, random, step, stopped, waypoint_end).
    Writes: model (waypoints), state (arrived, goal, random, waypoint, waypoint_end).
    """
    for w in worlds:
        for b in goal_bodies:
            if state.stopped[w, b] or model.goal_renewal[b] == KEEP_GOAL:
                continue
            # A leader has a lower number than those who walk with it, so its goal for this step is already known here.
            walks_along = model.leader[b] != b and model.present[w, model.leader[b]]
            # ``gives_up`` draws a random number: it is asked only of bodies that have not arrived.
            if lags(w, b, model, state) if walks_along else state.arrived[w, b] or gives_up(w, b, model, state):
                begin_round(w, b, False, model, state)
                state.arrived[w, b] = False
        for b in loop_returns:
            # In the first round (``waypoint_end`` 1) the goal keeps the heading of the file; later none counts.
            if model.arrive_mode[b] != STATE and state.waypoint_end[w, b] > 1:
                state.goal[w, b, 2] = np.nan


@kernel
def lags(w: int, b: int, model: Model, state: State) -> bool:
    """Return whether the leader of body b's party has another goal than body b.

    Reads: model (abreast, leader), state (goal).
    """
    shared, slot_goal, aside = state.goal[w, model.leader[b]], state.goal[w, b], np.abs(model.abreast[b]) + SAME_PLACE
    dx, dy = shared[0] - slot_goal[0], shared[1] - slot_goal[1]
    return bool(dx * dx + dy * dy > aside * aside)


@kernel
def gives_up(w: int, b: int, model: Model, state: State) -> bool:
    """Return whether a body wants another goal before it has reached its own.

    It draws a random number each time its interval has passed.

    Reads: model (present, wandering), state (random, step).
    Writes: state (random).
    """
    every, step = model.wandering[b].interval, state.step[w]
    if every == 0 or step == 0 or step % every != 0 or not model.present[w, b]:
        return False
    return bool(uniform(state.random, w, 0.0, 1.0) < model.wandering[b].chance)


@kernel(inlined=True)
def begin_round(w: int, b: int, first: bool, model: Model, state: State) -> None:
    """Give a body the first of its goals. A wandering body draws it, unless it keeps its first goal of all.

    A kept goal stays in its row, because the level may begin again.

    Reads: model (abreast, goal_renewal, leader, present, wander_high, wander_low, wandering, waypoint_count,
        waypoints), state (goal, pose, random).
    Writes: model (waypoints), state (goal, random, waypoint, waypoint_end).
    """
    # Goals are rows of ``model.waypoints``. A wandering body writes each drawn goal over row 0, or over row 1 if row 0
    # holds a first goal that it keeps.
    wanders, row = model.goal_renewal[b] == WANDER, 0
    state.waypoint_end[w, b] = 1 if wanders else model.waypoint_count[w, b]
    if wanders and model.wandering[b].keeps_first:
        row, wanders = 0 if first else 1, not first
        state.waypoint_end[w, b] = row + 1
    state.waypoint[w, b] = row
    if wanders and model.leader[b] != b and model.present[w, model.leader[b]]:
        share_goal(w, b, model.waypoints[w, b, row], model, state)
    elif wanders:
        draw_goal(w, b, model.waypoints[w, b, row], model, state)
    for axis in range(3):
        state.goal[w, b, axis] = model.waypoints[w, b, row, axis]


@kernel
def share_goal(w: int, b: int, goal: Floats, model: Model, state: State) -> None:
    """Write the goal of a body that walks in a party: beside the leader's goal, across the direction of travel.

    Reads: model (abreast, leader), state (goal, pose).
    Writes: goal.
    """
    shared = state.goal[w, model.leader[b]]
    dx, dy = shared[0] - state.pose[w, b, 0], shared[1] - state.pose[w, b, 1]
    # (-dy, dx) / distance is the unit vector to the left of the direction of travel, where ``abreast`` is positive.
    distance = max(np.sqrt(dx * dx + dy * dy), 1e-9)
    goal[0] = shared[0] - model.abreast[b] * dy / distance
    goal[1] = shared[1] + model.abreast[b] * dx / distance
    goal[2] = shared[2]


@kernel
def draw_goal(w: int, b: int, goal: Floats, model: Model, state: State) -> None:
    """Write a goal of a wandering body, drawn from a box or from a circle around its centre, and a heading.

    Reads: model (wander_high, wander_low, wandering), state (random).
    Writes: goal, state (random).
    """
    low, high, circle = model.wander_low[b], model.wander_high[b], model.wandering[b]
    if circle.radius <= 0.0:
        for axis in range(3):
            goal[axis] = uniform(state.random, w, low[axis], high[axis])
        return
    angle = uniform(state.random, w, 0.0, 2.0 * np.pi)
    goal[0] = (low[0] + high[0]) / 2.0 + circle.radius * np.cos(angle)
    goal[1] = (low[1] + high[1]) / 2.0 + circle.radius * np.sin(angle)
    if circle.jitter > 0.0:
        # The square root spreads the points evenly over the area of the disc.
        along = circle.jitter * np.sqrt(uniform(state.random, w, 0.0, 1.0))
        angle = uniform(state.random, w, 0.0, 2.0 * np.pi)
        goal[0], goal[1] = goal[0] + along * np.cos(angle), goal[1] + along * np.sin(angle)
    goal[2] = uniform(state.random, w, low[2], high[2])
