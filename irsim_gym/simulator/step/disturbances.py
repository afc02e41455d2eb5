"""Disturbances of robots in a step: of commands, motion and scans."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.simulator.world.disturbed import begin_disturbed
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, Model, Shard, State, kernel

if TYPE_CHECKING:
    from irsim_gym.simulator.step.turns import Turn


@dataclass
class Disturbances:
    """The disturbances of a scenario; those of commands and motions stand in the turns.

    Attributes:
        groups: All of them, by kind.
        scans: Those of scans, in the order in which they act.
    """

    groups: list[Group] = field(default_factory=list)
    scans: list[Group] = field(default_factory=list)


def asked(turn: Turn, model: Model, state: State, shard: Shard) -> State:
    """Return the state whose commands the drives get now; ``state`` itself if nothing disturbs them."""
    if turn.asked is None:
        return state
    copy_rows(shard.worlds, turn.movers, state.command, turn.asked.command)
    for group in turn.commands:
        group.kind.disturb(group, model, turn.asked, shard)
    return turn.asked


def moved(turn: Turn, model: Model, state: State, shard: Shard) -> State:
    """Return the state whose velocities the drives execute now; ``state`` itself if nothing disturbs them."""
    if turn.moved is None:
        return state
    copy_rows(shard.worlds, turn.movers, state.velocity, turn.moved.velocity)
    for group in turn.motions:
        group.kind.disturb(group, model, turn.moved, shard)
    return turn.moved


def begin(found: Disturbances, model: Model, shard: Shard) -> None:
    """Draw the numbers of the level."""
    for group in found.groups:
        begin_disturbed(shard.worlds, group.tables, model)


def begin_again(found: Disturbances, shard: Shard, begun: Flags) -> None:
    """Let some robots begin anew in running worlds, shape ``(n_shard_worlds, n_bodies)``; their numbers stay."""
    for group in found.groups:
        row, k = np.nonzero(begun[:, group.members])
        group.tables.count[shard.worlds[row], k] = 0


@kernel
def copy_rows(worlds: Ints, bodies: Ints, values: Floats, copied: Floats) -> None:
    """Copy the rows of some bodies, of arrays ``(n_worlds, n_bodies, n)``."""
    for w in worlds:
        for b in bodies:
            for axis in range(values.shape[2]):
                copied[w, b, axis] = values[w, b, axis]
