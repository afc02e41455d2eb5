"""Omnidirectional drive with rotation."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.bodies.drives.motion_noise import Variances
from irsim_gym.simulator.geometry.angles import wrap_below, wrap_from
from irsim_gym.simulator.world.names import OMNI_ANGULAR, Floats, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class OmniAngular(motion_noise.NoisyDrive):
    """Moves in any direction while turning; command: forward, left [m/s] and angular velocity [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("forward", "left", "angular")
    command_words: ClassVar[tuple[tuple[str, str], ...]] = (
        ("speed ahead", "m/s"),
        ("speed to the left", "m/s"),
        ("turn rate, positive to the left", "rad/s"),
    )
    mirrored_command: ClassVar[tuple[tuple[int, int], ...]] = ((0, 1), (1, -1), (2, -1))
    drive: ClassVar[int] = OMNI_ANGULAR

    alpha: tuple[float, float, float] = option(
        (0.03, 0.03, 0.03),
        unit="m2/s2, m2/s2, rad2/s2",
        meaning="Variances of the motion noise of the three components.",
    )

    @property
    def variances(self) -> Variances:
        """What the motion noise of the components depends on."""
        return motion_noise.constant(self.alpha)

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from motion_noise.negative_variances(self.alpha)

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_omni_angular(shard.worlds, group.members, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the members' poses by one step (explicit Euler with the heading of the step's start)."""
        executed = motion_noise.executed(group, model, state, shard)
        move_omni_angular(shard.worlds, group.members, model, state, executed)


@kernel
def twist_omni_angular(worlds: Ints, members: Ints, state: State) -> None:
    """Write velocities in the world frame.

    Reads: state (pose, velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for b in members:
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            state.twist[w, b, 0] = cosine * state.velocity[w, b, 0] - sine * state.velocity[w, b, 1]
            state.twist[w, b, 1] = sine * state.velocity[w, b, 0] + cosine * state.velocity[w, b, 1]
            state.twist[w, b, 2] = state.velocity[w, b, 2]


@kernel
def move_omni_angular(worlds: Ints, members: Ints, model: Model, state: State, executed: Floats) -> None:
    """Write the poses of the members that are free to move, from what they execute, and all twists.

    Reads: model (heading_low, step_time), state (pose, stopped, velocity).
    Writes: state (pose, twist).
    """
    dt = model.step_time[0]
    for w in worlds:
        for b in members:
            if not state.stopped[w, b]:
                heading = state.pose[w, b, 2]
                cosine, sine = np.cos(heading), np.sin(heading)
                state.pose[w, b, 0] += (cosine * executed[w, b, 0] - sine * executed[w, b, 1]) * dt
                state.pose[w, b, 1] += (sine * executed[w, b, 0] + cosine * executed[w, b, 1]) * dt
                # Wrapped twice, as in IR-SIM: by the drive to [-pi, pi), then to the interval of the body's
                # angle_range.
                heading = wrap_below(heading + executed[w, b, 2] * dt)
                state.pose[w, b, 2] = wrap_from(heading, model.heading_low[b])
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            state.twist[w, b, 0] = cosine * state.velocity[w, b, 0] - sine * state.velocity[w, b, 1]
            state.twist[w, b, 1] = sine * state.velocity[w, b, 0] + cosine * state.velocity[w, b, 1]
            state.twist[w, b, 2] = state.velocity[w, b, 2]
