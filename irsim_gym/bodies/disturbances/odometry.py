"""odometry: errors of the pose that a robot believes in, and what corrects it."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.kernels.structs import record_type
from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.base.rng import normal
from irsim_gym.simulator.geometry.angles import wrap_from
from irsim_gym.simulator.world.disturbed import Disturbed, whole_steps
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Records, Shard, State, kernel, kind, option

FIXES = record_type("spread turn", every=np.int64)
"""Deviations of a position fix [m, rad], and how many steps lie between two; 0: there is none."""


@kind
class PositionFix:
    """A position from outside, such as from a map or a satellite, which replaces the believed pose."""

    every: float = option(1.0, gt=0.0, unit="s", meaning="Time from one to the next, rounded up to whole steps.")
    std: float = option(0.0, ge=0.0, unit="m", meaning="Standard deviation of its x and of its y.")
    angle_std: float = option(0.0, ge=0.0, unit="rad", meaning="Standard deviation of its heading.")


@kind
class Odometry:
    """The believed pose drifts: it follows the wheels with an error of scale and one of heading."""

    acts_on: ClassVar[str] = "belief"

    scale: Annotated[Drawn, Bounds(-1.0, 10.0)] = option(0.0, meaning="Share by which ways are believed too long.")
    yaw: Annotated[Drawn, Bounds(-10.0, 10.0)] = option(0.0, unit="rad/m", meaning="Drift to the left for each metre.")
    fix: PositionFix | None = option(None, meaning="A mapping with the keys every, std and angle_std; default: none.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Note when fixes come, and how good they are."""
        group.arrays["fixes"] = fixes = np.zeros(len(group.options), FIXES)
        for row, options in zip(fixes, group.options, strict=True):
            if options.fix is not None:
                every = whole_steps(options.fix.every, float(model.step_time[0]))
                row["every"], row["spread"], row["turn"] = every, options.fix.std, options.fix.angle_std

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Let the believed poses drift, or correct them."""
        drift(shard.worlds, group.tables, group.arrays["fixes"], group.arrays["pose"], model, state)


@kernel
def drift(worlds: Ints, disturbed: Disturbed, fixes: Records, true: Floats, model: Model, told: State) -> None:
    """Add the errors of this step to the believed poses; in the step of a fix replace them.

    Reads: disturbed (count, members, random, values), model (heading_low, step_time), told (pose, twist).
    Writes: disturbed (count, random), told (pose).
    """
    dt = model.step_time[0]
    for w in worlds:
        for k in range(disturbed.members.shape[0]):
            b, scale, yaw, fix = disturbed.members[k], disturbed.values[w, k, 0], disturbed.values[w, k, 1], fixes[k]
            pose, dx, dy = told.pose[w, b], told.twist[w, b, 0] * dt, told.twist[w, b, 1] * dt
            disturbed.count[w, k] += 1
            pose[0], pose[1] = pose[0] + scale * dx, pose[1] + scale * dy
            heading = pose[2] + yaw * np.sqrt(dx * dx + dy * dy)
            if fix.every > 0 and disturbed.count[w, k] % fix.every == 0:
                for axis in range(2):
                    pose[axis] = normal(disturbed.random[w], k, true[w, b, axis], fix.spread)
                heading = normal(disturbed.random[w], k, true[w, b, 2], fix.turn)
            pose[2] = wrap_from(heading, model.heading_low[b])
