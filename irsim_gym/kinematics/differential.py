"""Differential drive: two wheels on one axle."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.geometry.angles import wrap, wrap_from
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import DIFFERENTIAL, WorldModel
from irsim_gym.world.state import WorldState


@kind
class Differential:
    """Differential drive; command: linear velocity [m/s], angular velocity [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("linear", "angular")
    state_size: ClassVar[int] = 3
    drive: ClassVar[int] = DIFFERENTIAL

    noise: bool = option(False, meaning="Add motion noise.", planned=True)
    alpha: tuple[float, float, float, float] = option(
        (0.03, 0.0, 0.0, 0.03), meaning="Variances of the motion noise.", planned=True
    )

    @staticmethod
    def move(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Advance the members' poses by one step (explicit Euler with the heading of the step's start)."""
        move_differential(
            shard.worlds,
            group.members,
            model.step_time,
            model.movable,
            model.heading_low,
            model.wraps_heading,
            state.stopped,
            state.velocity,
            state.pose,
            state.twist,
        )

    @staticmethod
    def begin(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_differential(shard.worlds, group.members, state.pose, state.velocity, state.twist)


@kernel
def twist_differential(worlds: Ints, members: Ints, pose: Floats, velocity: Floats, twist: Floats) -> None:
    """Write velocities in the world frame."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(members.shape[0]):
            b = members[k]
            twist[w, b, 0] = velocity[w, b, 0] * np.cos(pose[w, b, 2])
            twist[w, b, 1] = velocity[w, b, 0] * np.sin(pose[w, b, 2])
            twist[w, b, 2] = velocity[w, b, 1]


@kernel
def move_differential(
    worlds: Ints,
    members: Ints,
    step_time: Floats,
    movable: Flags,
    heading_low: Floats,
    wraps_heading: Flags,
    stopped: Flags,
    velocity: Floats,
    pose: Floats,
    twist: Floats,
) -> None:
    """Write pose and twist of the members that are free to move."""
    dt = step_time[0]
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(members.shape[0]):
            b = members[k]
            heading = pose[w, b, 2]
            vx = velocity[w, b, 0] * np.cos(heading)
            vy = velocity[w, b, 0] * np.sin(heading)
            twist[w, b, 0], twist[w, b, 1], twist[w, b, 2] = vx, vy, velocity[w, b, 1]
            if stopped[w, b] or not movable[b]:
                continue
            pose[w, b, 0] += vx * dt
            pose[w, b, 1] += vy * dt
            heading = wrap(heading + velocity[w, b, 1] * dt)
            pose[w, b, 2] = wrap_from(heading, heading_low[b]) if wraps_heading[b] else heading
