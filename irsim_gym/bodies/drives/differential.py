"""Differential drive: two wheels on one axle."""

from typing import ClassVar

import numpy as np

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.simulator.geometry.angles import turned, wrap_below, wrap_from
from irsim_gym.simulator.world.names import DIFFERENTIAL, Floats, Group, Ints, Model, Shard, State, kernel, kind


@kind
class Differential(motion_noise.RollingDrive):
    """Differential drive; command: linear velocity [m/s], angular velocity [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("linear", "angular")
    command_words: ClassVar[tuple[tuple[str, str], ...]] = (
        ("speed ahead", "m/s"),
        ("turn rate, positive to the left", "rad/s"),
    )
    drive: ClassVar[int] = DIFFERENTIAL

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_differential(shard.worlds, group.members, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the members' poses by one step (explicit Euler with the heading of the step's start)."""
        executed = motion_noise.executed(group, model, state, shard)
        move_differential(shard.worlds, group.members, model, state, executed)


@kernel
def twist_differential(worlds: Ints, members: Ints, state: State) -> None:
    """Write velocities in the world frame.

    Reads: state (pose, velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for b in members:
            state.twist[w, b, 0] = state.velocity[w, b, 0] * np.cos(state.pose[w, b, 2])
            state.twist[w, b, 1] = state.velocity[w, b, 0] * np.sin(state.pose[w, b, 2])
            state.twist[w, b, 2] = state.velocity[w, b, 1]


@kernel
def move_differential(worlds: Ints, members: Ints, model: Model, state: State, executed: Floats) -> None:
    """Write the poses of the members that are free to move, from what they execute, and all twists.

    A twist has the heading after the move and the velocity that was asked for, without noise.

    Reads: model (heading_low, step_time), state (direction, pose, stopped, velocity).
    Writes: state (direction, pose, twist).
    """
    dt = model.step_time[0]
    for w in worlds:
        for b in members:
            if not state.stopped[w, b]:
                heading = state.pose[w, b, 2]
                cosine, sine = turned(heading, state.direction[w, b])
                state.pose[w, b, 0] += executed[w, b, 0] * cosine * dt
                state.pose[w, b, 1] += executed[w, b, 0] * sine * dt
                # Wrapped twice, as in IR-SIM: by the drive to [-pi, pi), then to the interval of the body's
                # angle_range.
                heading = wrap_below(heading + executed[w, b, 1] * dt)
                state.pose[w, b, 2] = wrap_from(heading, model.heading_low[b])
            direction = state.direction[w, b]
            # Kept with the heading that they belong to, so that the next step and the sensors need not compute them
            # again.
            direction[0], direction[1] = turned(state.pose[w, b, 2], direction)
            direction[2] = state.pose[w, b, 2]
            state.twist[w, b, 0] = state.velocity[w, b, 0] * direction[0]
            state.twist[w, b, 1] = state.velocity[w, b, 0] * direction[1]
            state.twist[w, b, 2] = state.velocity[w, b, 1]
