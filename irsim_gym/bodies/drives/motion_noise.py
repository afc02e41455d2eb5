"""Motion noise: what a drive executes differs from its command by normal deviations."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.rng import normal
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, Struct, kernel, kind, option

Variances = tuple[tuple[float, float, float], ...]
"""A row for each component, see ``MotionNoise.variance``."""


@dataclass(repr=False)
class MotionNoise(Struct):
    """The motion noise of a group in which a member has any.

    Attributes:
        variance: Of each component: constant, per square of the first and of the second component, shape
            ``(n_bodies, 3, 3)``. Nothing is drawn for a row of zeros.
        executed: The velocities that the members execute in this step, shape ``(n_worlds, n_bodies, 3)``.
    """

    variance: Floats
    executed: Floats


def constant(alpha: Sequence[float]) -> Variances:
    """Return the variances of a drive whose components deviate by the same at any speed, even at rest."""
    return tuple((variance, 0.0, 0.0) for variance in alpha)


def negative_variances(alpha: Sequence[float]) -> Iterator[tuple[str, str]]:
    """Yield a problem if a variance is negative."""
    if any(variance < 0.0 for variance in alpha):
        shown = ", ".join(f"{variance:g}" for variance in alpha)
        yield "alpha", f"variances must not be negative, got [{shown}]"


@kind
class NoisyDrive:
    """What drives with motion noise have in common."""

    state_size: ClassVar[int] = 3

    noise: bool = option(False, meaning="Add motion noise; to omnidirectional drives also at rest.")
    tau: float | None = option(None, ge=0.0, unit="s", meaning="With contact, lag of the drive; default: drive_tau.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make the tables of a group in which a member has noise; without one there are none, and nothing is drawn."""
        if not any(options.noise for options in group.options):
            return
        n_bodies = len(model.movable)
        group.tables = MotionNoise(np.zeros((n_bodies, 3, 3)), np.zeros((len(model.present), n_bodies, 3)))
        for b, options in zip(group.members, group.options, strict=True):
            if options.noise:
                rows = options.variances
                group.tables.variance[b, : len(rows)] = rows


@kind
class RollingDrive(NoisyDrive):
    """What drives on wheels have in common: the faster they move, the more they deviate."""

    mirrored_command: ClassVar[tuple[tuple[int, int], ...]] = ((0, 1), (1, -1))

    alpha: tuple[float, float, float, float] = option(
        (0.03, 0.0, 0.0, 0.03),
        meaning="Motion noise: variances of the first component of the command per square of the first and of the "
        "second, then the same for the second.",
    )

    @property
    def variances(self) -> Variances:
        """Return a row for each component, see ``MotionNoise.variance``.

        The first component's variance is ``alpha[0] v^2 + alpha[1] w^2``, the second one's ``alpha[2] v^2 + alpha[3]
        w^2``, so that a drive at rest stays there (Thrun, Burgard & Fox, "Probabilistic Robotics", 2005, section
        5.3.3).
        """
        return (0.0, *self.alpha[:2]), (0.0, *self.alpha[2:])

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from negative_variances(self.alpha)


def executed(group: Group, model: Model, state: State, shard: Shard) -> Floats:
    """Return the velocities that the members execute in this step, shape ``(n_worlds, n_bodies, 3)``.

    Without noise they are ``state.velocity`` itself, which stays as commanded in any case.
    """
    noise: MotionNoise | None = group.tables
    if noise is None:
        return state.velocity
    add_noise(shard.worlds, group.members, noise, model, state)
    return noise.executed


@kernel
def add_noise(worlds: Ints, members: Ints, noise: MotionNoise, model: Model, state: State) -> None:
    """Write velocities with normal deviations, drawn from each world's stream: member by member, in component order.

    Reads: noise (executed, variance), model (present), state (random, stopped, velocity).
    Writes: noise (executed), state (random).
    """
    for w in worlds:
        for b in members:
            first, second = state.velocity[w, b, 0], state.velocity[w, b, 1]
            is_free = model.present[w, b] and not state.stopped[w, b]
            for axis in range(3):
                variance = noise.variance[b, axis]
                base, by_first, by_second = variance[0], variance[1], variance[2]
                noise.executed[w, b, axis] = state.velocity[w, b, axis]
                # Nothing is drawn for those that stand still, nor for components without noise: streams stay as without
                # them.
                if is_free and base + by_first + by_second > 0.0:
                    deviation = np.sqrt(base + by_first * first * first + by_second * second * second)
                    noise.executed[w, b, axis] += normal(state.random, w, 0.0, deviation)
