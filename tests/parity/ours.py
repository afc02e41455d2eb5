"""irsim_gym with one world, whose state can be set to ir-sim's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from ir_sim import IrSim, Snapshot

import irsim_gym as ig
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.world.group import Shard
from irsim_gym.simulator.world.model import OMNI_WORLD, WANDER

SHARD = Shard(np.zeros(1, np.int64))


def build(scenario: Mapping[str, Any], agents: Sequence[int] = ()) -> Any:
    """Compile the scenario and draw its first level."""
    sim = ig.compile(ig.load_scenario(scenario, warn=False), agents=tuple(agents))
    sim.reset(seed=0)
    return sim


def adopt_placement(sim: Any, reference: IrSim) -> None:
    """Take over what ir-sim drew at random: starts, outlines and goals."""
    model = sim.model
    for b, theirs in enumerate(reference.objects):
        adopt_outline(sim, b, theirs)
        sim.state.pose[0, b] = model.start[0, b] = theirs._state[:3, 0]
        if model.has_goal[b]:
            goals = [_waypoint(goal) for goal in theirs._goal]
            model.waypoints[0, b, : len(goals)] = goals
            sim.state.goal[0, b] = goals[0]
            if b in sim.parts.loop_returns:
                model.waypoints[0, b, 1, :2] = theirs._state[:2, 0]
    outlines.place(sim.parts.everyone, model, sim.state, SHARD)
    contact.find_static(sim.parts.fixed, model, sim.state, SHARD)


def adopt_outline(sim: Any, b: int, theirs: Any) -> None:
    """Copy a random radius."""
    model = sim.model
    if sim.scenario.bodies[b].shape.is_random and theirs.shape == "circle":
        model.local_discs[0, model.disc_start[b], 2] = theirs.gf.radius
        model.reach[0, b] = model.radius[0, b] = theirs.gf.radius


def _waypoint(goal: Any) -> list[float]:
    numbers = np.asarray(goal, float).reshape(-1).tolist()
    return [*numbers, np.nan][:3]


def set_state(sim: Any, at: Snapshot, reference: IrSim) -> None:
    """Set our state to ir-sim's."""
    model, state = sim.model, sim.state
    for b, theirs in enumerate(reference.objects):
        state.velocity[0, b], state.twist[0, b] = 0.0, 0.0
        arrived, collided, stopped = at.flags[b]
        state.arrived[0, b] = arrived and model.has_goal[b]
        state.collided[0, b], state.stopped[0, b] = collided, stopped
        if not model.movable[b]:
            continue
        pose, velocity = at.states[b][:, 0], at.velocities[b][:, 0]
        state.pose[0, b] = pose[:3]
        state.steering[0, b] = pose[3] if len(pose) > 3 else 0.0
        state.velocity[0, b, : len(velocity)] = from_body_frame(sim, b, velocity)
        state.twist[0, b, :2] = np.asarray(theirs.kf.velocity_to_xy(at.states[b], at.velocities[b]), float).reshape(-1)
        if model.has_goal[b]:
            _set_goals(sim, b, at)
    for members, velocities in zip(reference.groups_of_planners, at.planned, strict=True):
        state.plan[0, members] = velocities
    state.step[0] = at.clock
    outlines.place(sim.parts.everyone, model, state, SHARD)
    body_buckets.refresh(sim.parts.everyone, model, state, SHARD)


def _set_goals(sim: Any, b: int, at: Snapshot) -> None:
    """Put the next goal and the place in the queue where ir-sim has them."""
    model, state = sim.model, sim.state
    left = [_waypoint(goal) for goal in at.goals[b]]
    end = int(model.waypoint_count[0, b])
    if model.goal_renewal[b] == WANDER:
        end, model.waypoints[0, b, 0] = 1, left[0]
    elif b in sim.parts.loop_returns and len(left) == 1 and left[0][:2] != model.waypoints[0, b, 1, :2].tolist():
        end = 1
    state.waypoint_end[0, b], state.waypoint[0, b] = end, end - len(left)
    state.goal[0, b] = left[0]


def renew_wandering(sim: Any, before: Snapshot, after: Snapshot) -> None:
    """Take over the goals that ir-sim drew in a step (decision ``random_streams``)."""
    for b in range(len(before.flags)):
        arrived, _, stopped = before.flags[b]
        if sim.model.goal_renewal[b] == WANDER and arrived and not stopped:
            sim.state.arrived[0, b] = False
            sim.model.waypoints[0, b, 0] = sim.state.goal[0, b] = _waypoint(after.goals[b][0])


def velocity_in_body_frame(sim: Any, b: int) -> Any:
    """Return the executed velocity in ir-sim's frame."""
    velocity = sim.state.velocity[0, b].copy()
    return _turned(velocity, -sim.state.pose[0, b, 2]) if sim.model.drive[b] == OMNI_WORLD else velocity


def from_body_frame(sim: Any, b: int, command: Any) -> Any:
    """Return a command of ir-sim in our frame: omni's is the world's (decision ``omni_frame``)."""
    return _turned(command, sim.state.pose[0, b, 2]) if sim.model.drive[b] == OMNI_WORLD else command


def _turned(velocity: Any, angle: float) -> Any:
    turned = np.array(velocity, float)
    cosine, sine = np.cos(angle), np.sin(angle)
    turned[:2] = cosine * velocity[0] - sine * velocity[1], sine * velocity[0] + cosine * velocity[1]
    return turned
