"""Disturbances of robots in a step: of commands, motion and scans, and of the poses that robots believe in."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.simulator.world.disturbed import begin_disturbed
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, Model, Shard, State, kernel

if TYPE_CHECKING:
    from irsim_gym.simulator.step.turns import Turn


@dataclass
class Belief:
    """What robots believe of their poses, where these are disturbed.

    Attributes:
        state: The state as robots know it: the same arrays, but for ``OWN``.
        drives: The robots, by drive; their odometry moves them like these, by ``State.velocity``.
        errors: Disturbances of these poses, in the order in which they act.
        others: The bodies whose poses are known.
    """

    state: State
    drives: list[Group]
    errors: list[Group]
    others: Ints


OWN = ("direction", "goal_distance", "pose", "steering", "twist")
"""Fields of the state that belong to the believed pose, where it is not the true one."""


@dataclass
class Disturbances:
    """The disturbances of a scenario; those of commands and motions stand in the turns.

    Attributes:
        groups: All of them, by kind.
        outlines: Those of footprints.
        known: The constants as robots know them; None where nothing disturbs footprints.
        reach: ``Model.reach`` as the entries give it [m], NaN for bodies that nothing disturbs, shape ``(n_bodies,)``.
        mounts: Those of the mount poses of sensors.
        scans: Those of scans, in the order in which they act.
        belief: What robots believe of their poses; None where all know them.
    """

    groups: list[Group] = field(default_factory=list)
    outlines: list[Group] = field(default_factory=list)
    known: Model | None = None
    reach: Floats = field(default_factory=lambda: np.zeros(0))
    mounts: list[Group] = field(default_factory=list)
    scans: list[Group] = field(default_factory=list)
    belief: Belief | None = None


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


def begin(disturbances: Disturbances, model: Model, state: State, shard: Shard) -> None:
    """Draw the numbers of the level, and mount the sensors."""
    for group in disturbances.groups:
        begin_disturbed(shard.worlds, group.tables, model)
    for group in disturbances.mounts:
        group.kind.disturb(group, model, state, shard)
    if disturbances.known is not None:
        tell_reach(shard.worlds, disturbances.reach, model, disturbances.known)


def begin_again(disturbances: Disturbances, state: State, shard: Shard, begun: Flags) -> None:
    """Let some robots begin anew in running worlds, shape ``(n_shard_worlds, n_bodies)``; their numbers stay."""
    for group in disturbances.groups:
        row, k = np.nonzero(begun[:, group.members])
        group.tables.count[shard.worlds[row], k] = 0
    for row, b in zip(*np.nonzero(begun), strict=True):
        tell(disturbances, np.array([b]), state, Shard(shard.worlds[row : row + 1]))


def tell(disturbances: Disturbances, bodies: Ints, state: State, shard: Shard) -> None:
    """Let bodies know where they are, as at the start, or where they are moved from outside."""
    if disturbances.belief is not None:
        tell_truth(shard.worlds, bodies, state, disturbances.belief.state)


def believe(disturbances: Disturbances, model: Model, state: State, shard: Shard) -> None:
    """Move the believed poses by what the wheels have turned, and disturb them."""
    if (belief := disturbances.belief) is not None:
        for group in belief.drives:
            group.kind.move(group, model, belief.state, shard)
        for group in belief.errors:
            group.kind.disturb(group, model, belief.state, shard)


@kernel
def tell_reach(worlds: Ints, reach: Floats, model: Model, told: Model) -> None:
    """Write the reach of bodies as robots know it.

    Reads: model (reach).
    Writes: told (reach).
    """
    for w in worlds:
        for b in range(reach.shape[0]):
            told.reach[w, b] = model.reach[w, b] if np.isnan(reach[b]) else reach[b]


@kernel
def copy_rows(worlds: Ints, bodies: Ints, values: Floats, copied: Floats) -> None:
    """Copy the rows of some bodies, of arrays ``(n_worlds, n_bodies, n)``."""
    for w in worlds:
        for b in bodies:
            for axis in range(values.shape[2]):
                copied[w, b, axis] = values[w, b, axis]


@kernel
def tell_truth(worlds: Ints, bodies: Ints, state: State, told: State) -> None:
    """Copy what is ``OWN`` of some bodies.

    Reads: state (direction, goal_distance, pose, steering, twist).
    Writes: told (direction, goal_distance, pose, steering, twist).
    """
    copy_rows(worlds, bodies, state.pose, told.pose)
    copy_rows(worlds, bodies, state.twist, told.twist)
    copy_rows(worlds, bodies, state.direction, told.direction)
    for w in worlds:
        for b in bodies:
            told.steering[w, b], told.goal_distance[w, b] = state.steering[w, b], state.goal_distance[w, b]
