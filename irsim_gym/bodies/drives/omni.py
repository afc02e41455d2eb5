"""Omnidirectional drive without rotation."""

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.bodies.drives import motion_noise
from irsim_gym.bodies.drives.motion_noise import Variances
from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.world.names import (
    OMNI_BODY,
    OMNI_WORLD,
    Floats,
    Group,
    Ints,
    Model,
    Shard,
    State,
    kernel,
    kind,
    option,
)


@kind
class Omni(motion_noise.NoisyDrive):
    """Moves in any direction and keeps its heading; command: two velocities [m/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("x", "y")
    mirrored_command: ClassVar[tuple[tuple[int, int], ...]] = ((0, 1), (1, -1))

    frame: Literal["world", "body"] = option(
        "world", meaning="Frame of the command: the world's, or the body's (forward and left)."
    )
    bound: Literal["components", "speed"] = option(
        "components",
        meaning="What vel_max limits: each component, or the speed in any direction too, to its first number.",
    )
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

    @staticmethod
    def begin(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' twists at the start of an episode, from their poses and initial velocities."""
        twist_omni(shard.worlds, group.members, group.params, state)

    @staticmethod
    def move(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Advance the members' positions by one step."""
        executed = motion_noise.executed(group, model, state, shard)
        move_omni(shard.worlds, group.members, group.params, model, state, executed)


@kernel
def twist_omni(worlds: Ints, members: Ints, params: Any, state: State) -> None:
    """Write velocities in the world frame.

    Reads: state (pose, velocity).
    Writes: state (twist).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            # Frame `body`; velocities in the world's frame need no turn.
            turn = state.pose[w, b, 2] if params[k].frame == 1 else 0.0
            cosine, sine = np.cos(turn), np.sin(turn)
            state.twist[w, b, 0] = cosine * state.velocity[w, b, 0] - sine * state.velocity[w, b, 1]
            state.twist[w, b, 1] = sine * state.velocity[w, b, 0] + cosine * state.velocity[w, b, 1]
            state.twist[w, b, 2] = 0.0


@kernel
def move_omni(worlds: Ints, members: Ints, params: Any, model: Model, state: State, executed: Floats) -> None:
    """Write the positions of the members that are free to move, from what they execute, and all twists.

    Reads: model (heading_low, step_time), state (pose, stopped, velocity).
    Writes: state (pose, twist).
    """
    dt = model.step_time[0]
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            cosine, sine = 1.0, 0.0
            # Frame `body`.
            if params[k].frame == 1:
                cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            if not state.stopped[w, b]:
                state.pose[w, b, 0] += (cosine * executed[w, b, 0] - sine * executed[w, b, 1]) * dt
                state.pose[w, b, 1] += (sine * executed[w, b, 0] + cosine * executed[w, b, 1]) * dt
                # The heading does not change, but a start outside of its interval wraps in the first step, as in
                # IR-SIM.
                state.pose[w, b, 2] = wrap_from(state.pose[w, b, 2], model.heading_low[b])
            state.twist[w, b, 0] = cosine * state.velocity[w, b, 0] - sine * state.velocity[w, b, 1]
            state.twist[w, b, 1] = sine * state.velocity[w, b, 0] + cosine * state.velocity[w, b, 1]
            state.twist[w, b, 2] = 0.0
