"""Omnidirectional drive without rotation, and the motion of those with and without it."""

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.bodies.drives.motion_noise import Variances
from irsim_gym.simulator.geometry.angles import wrap_below, wrap_from
from irsim_gym.simulator.world.model import OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel, kind, option


@kind
class OmniMotion(motion_noise.NoisyDrive):
    """How the bodies of both omnidirectional drives move."""

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_omni(shard.worlds, group.members, model, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the members' poses by one step (explicit Euler with the heading of the step's start)."""
        executed = motion_noise.executed(group, model, state, shard)
        move_omni(shard.worlds, group.members, model, state, executed)


@kind
class Omni(OmniMotion):
    """Moves in any direction and keeps its heading; command: two velocities [m/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("x", "y")
    mirrored_command: ClassVar[tuple[tuple[int, int], ...]] = ((0, 1), (1, -1))

    frame: Literal["world", "body"] = option("world", meaning="Frame of the command: world, or body (forward, left).")
    bound: Literal["components", "speed"] = option("components", meaning="vel_max limits components, or the speed too.")
    alpha: tuple[float, ...] = option(
        (0.03, 0.03),
        min_length=2,
        max_length=4,
        unit="m2/s2",
        meaning="Variances of the motion noise of the two components; of four numbers, the first and the last count.",
    )

    @property
    def command_words(self) -> tuple[tuple[str, str], ...]:
        """What the components of a command are, and their units."""
        names = ("speed ahead", "speed to the left") if self.frame == "body" else ("speed along x", "speed along y")
        return tuple((name, "m/s") for name in names)

    @property
    def drive(self) -> int:
        """How the command reads."""
        return OMNI_WORLD if self.frame == "world" else OMNI_BODY

    @property
    def variances(self) -> Variances:
        """What the motion noise of the components depends on."""
        return motion_noise.constant((self.alpha[0], self.alpha[-1]))

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from motion_noise.negative_variances(self.alpha)
        if len(self.alpha) == 3:
            yield "alpha", "must be 2 numbers, or 4 of which the first and the last count, got 3"


@kernel
def twist_omni(worlds: Ints, members: Ints, model: Model, state: State) -> None:
    """Write velocities in the world frame.

    Reads: model (drive), state (pose, velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for b in members:
            # Velocities in the world's frame need no turn.
            turn = 0.0 if model.drive[b] == OMNI_WORLD else state.pose[w, b, 2]
            write_twist(np.cos(turn), np.sin(turn), model.drive[b], state.velocity[w, b], state.twist[w, b])


@kernel
def write_twist(cosine: float, sine: float, drive: int, velocity: Floats, twist: Floats) -> None:
    """Write the velocity of a body in the world frame, from that in its command's frame, turned by an angle.

    Writes: twist.
    """
    twist[0] = cosine * velocity[0] - sine * velocity[1]
    twist[1] = sine * velocity[0] + cosine * velocity[1]
    twist[2] = velocity[2] if drive == OMNI_ANGULAR else 0.0


@kernel
def move_omni(worlds: Ints, members: Ints, model: Model, state: State, executed: Floats) -> None:
    """Write the poses of the members that are free to move, from what they execute, and all twists.

    Reads: model (drive, heading_low, step_time), state (pose, stopped, velocity).
    Writes: state (pose, twist).
    """
    dt = model.step_time[0]
    for w in worlds:
        for b in members:
            drive, heading, cosine, sine = model.drive[b], state.pose[w, b, 2], 1.0, 0.0
            if drive != OMNI_WORLD:
                cosine, sine = np.cos(heading), np.sin(heading)
            if not state.stopped[w, b]:
                state.pose[w, b, 0] += (cosine * executed[w, b, 0] - sine * executed[w, b, 1]) * dt
                state.pose[w, b, 1] += (sine * executed[w, b, 0] + cosine * executed[w, b, 1]) * dt
                # Wrapped twice, as in IR-SIM: by a drive that turns to [-pi, pi), then to the interval of the body's
                # angle_range. A start outside of it wraps in the first step.
                if drive == OMNI_ANGULAR:
                    heading = wrap_below(heading + executed[w, b, 2] * dt)
                state.pose[w, b, 2] = wrap_from(heading, model.heading_low[b])
            if drive == OMNI_ANGULAR:
                cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            write_twist(cosine, sine, drive, state.velocity[w, b], state.twist[w, b])
