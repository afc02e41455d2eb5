"""Behaviours for ``omni`` robots that steer any drive with ``simulator.world.kinds.Steers``.

Such a behaviour sees the body as omnidirectional, with the first component of ``vel_max`` as its maximum speed in every
direction. It asks for a velocity in the world frame, which the drive turns into a command.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from irsim_gym.base import families
from irsim_gym.simulator.world.names import OMNI_WORLD, Group, Ints, Model, Shard, State


@dataclass(frozen=True)
class Guide:
    """The members of a group that are driven by velocities.

    Attributes:
        shown: Constants as the behaviour sees them.
        drives: Members whose drives turn velocities into commands, by drive.
    """

    shown: Model
    drives: tuple[Group, ...]

    def among(self, members: Ints) -> Guide:
        """Return the guide of some of the bodies."""
        chosen = [(drive, np.flatnonzero(np.isin(drive.members, members))) for drive in self.drives]
        return Guide(self.shown, tuple(drive.select(those) for drive, those in chosen if len(those)))


def guide(group: Group, bodies: Sequence[object], kinematics: Sequence[Group], model: Model) -> None:
    """Give a group that decides a guide, if it needs one.

    Args:
        group: The group; its ``guide`` is written.
        bodies: What the file says of each body.
        kinematics: All bodies that move, by drive.
        model: Constants of the worlds.
    """
    guided = [int(b) for b in group.members if families.steers(group.kind, type(bodies[b].kinematics))]
    if guided:
        group.guide = Guide(_shown(model, np.array(guided)), tuple(kinematics)).among(np.array(guided))


def _shown(model: Model, guided: Ints) -> Model:
    """Return constants in which some bodies are omnidirectional; all other arrays are those of the model."""
    # Copies: whoever changes limits of velocity later has to compile again.
    drive = model.drive.copy()
    drive[guided] = OMNI_WORLD
    fastest, slowest, sharpest = (
        field.copy() for field in (model.velocity_max, model.velocity_min, model.acceleration_limit)
    )
    # vx and vy of the world frame get the limits of the drive's first velocity, in both directions.
    fastest[:, guided, :2] = fastest[:, guided, :1]
    slowest[:, guided, :2] = -fastest[:, guided, :2]
    sharpest[:, guided, :2] = sharpest[:, guided, :1]
    return replace(model, drive=drive, velocity_max=fastest, velocity_min=slowest, acceleration_limit=sharpest)


def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
    """Let a group decide: write the commands of its members."""
    if group.guide is None:
        group.kind.decide(group, model, state, shard)
        return
    group.kind.decide(group, group.guide.shown, state, shard)
    for drive in group.guide.drives:
        drive.kind.steer(drive, model, state, shard)
