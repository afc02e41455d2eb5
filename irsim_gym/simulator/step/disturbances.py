"""Disturbances of robots in a step: of commands, motion and scans, and of the poses that robots believe in."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.simulator.step import arrival
from irsim_gym.simulator.world.disturbed import begin_disturbed
from irsim_gym.simulator.world.names import Flags, Floats, Group, Ints, Model, Shard, State, kernel

if TYPE_CHECKING:
    from irsim_gym.simulator.step.turns import Turn


@dataclass
class Belief:
    """What robots believe of their poses.

    Attributes:
        state: The state as the robots know it: the same arrays, but for their own poses and what follows from these.
        drives: The robots, by drive; their odometry moves them like these, by ``State.velocity``.
        errors: Disturbances of these poses, in the order in which they act.
        others: The bodies whose poses are known.
        believers: The robots.
    """

    state: State
    drives: list[Group]
    errors: list[Group]
    others: Ints
    believers: Ints


@dataclass
class Disturbances:
    """The disturbances of a scenario; those of commands and motions stand in the turns.

    Attributes:
        groups: All of them, by kind.
        sights: Those of the poses from which sensors look, in the order in which they act.
        seeing: The state with these poses; None where nothing disturbs them.
        scans: Those of scans, likewise.
        belief: What robots believe of their poses; None where all know them.
    """

    groups: list[Group] = field(default_factory=list)
    sights: list[Group] = field(default_factory=list)
    seeing: State | None = None
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


def seeing(found: Disturbances, everyone: Ints, model: Model, state: State, shard: Shard) -> State:
    """Return the state from whose poses sensors look now; ``state`` itself if nothing disturbs them."""
    if found.seeing is None:
        return state
    tell_truth(shard.worlds, everyone, state, found.seeing)
    for group in found.sights:
        group.kind.disturb(group, model, found.seeing, shard)
    return found.seeing


def begin(found: Disturbances, goal_bodies: Ints, model: Model, state: State, shard: Shard) -> None:
    """Draw the numbers of the level, and let all robots know their poses."""
    for group in found.groups:
        begin_disturbed(shard.worlds, group.tables, model)
    if (belief := found.belief) is not None:
        tell_truth(shard.worlds, belief.others, state, belief.state)
        tell_truth(shard.worlds, belief.believers, state, belief.state)
        arrival.measure_distance(shard.worlds, goal_bodies, belief.state)


def begin_again(found: Disturbances, goal_bodies: Ints, state: State, shard: Shard, begun: Flags) -> None:
    """Let some robots begin anew in running worlds, shape ``(n_shard_worlds, n_bodies)``; their numbers stay."""
    for group in found.groups:
        row, k = np.nonzero(begun[:, group.members])
        group.tables.count[shard.worlds[row], k] = 0
    if (belief := found.belief) is not None:
        for row, b in zip(*np.nonzero(begun), strict=True):
            tell_truth(shard.worlds[row : row + 1], np.array([b]), state, belief.state)
        arrival.measure_distance(shard.worlds, goal_bodies, belief.state)


def believe(belief: Belief, model: Model, state: State, shard: Shard) -> None:
    """Move the believed poses by what the wheels have turned, and disturb them."""
    tell_truth(shard.worlds, belief.others, state, belief.state)
    for group in belief.drives:
        group.kind.move(group, model, belief.state, shard)
    for group in belief.errors:
        group.kind.disturb(group, model, belief.state, shard)


@kernel
def copy_rows(worlds: Ints, bodies: Ints, values: Floats, copied: Floats) -> None:
    """Copy the rows of some bodies, of arrays ``(n_worlds, n_bodies, 3)``."""
    for w in worlds:
        for b in bodies:
            for axis in range(3):
                copied[w, b, axis] = values[w, b, axis]


@kernel
def tell_truth(worlds: Ints, bodies: Ints, state: State, told: State) -> None:
    """Write the true poses of some bodies, and what follows from them.

    Reads: state (direction, pose, steering, twist).
    Writes: told (direction, pose, steering, twist).
    """
    for w in worlds:
        for b in bodies:
            told.steering[w, b] = state.steering[w, b]
            for axis in range(3):
                told.pose[w, b, axis], told.twist[w, b, axis] = state.pose[w, b, axis], state.twist[w, b, axis]
                told.direction[w, b, axis] = state.direction[w, b, axis]
