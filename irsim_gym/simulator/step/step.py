"""One step of the simulator, phase by phase."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from irsim_gym.simulator.contact import body_buckets, contact, swept
from irsim_gym.simulator.pushing.memory import follow
from irsim_gym.simulator.pushing.parting import part_bodies
from irsim_gym.simulator.step import arrival, command_limits, disturbances, fog, outlines, patience
from irsim_gym.simulator.step.guide import decide
from irsim_gym.simulator.step.parts import Parts
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Shard, State, kernel


@dataclass(frozen=True)
class Orders:
    """Commands from outside that take the place of what bodies decide, for one step.

    Attributes:
        bodies: The bodies that they command, shape ``(n_bodies,)``.
        commands: Commands in drive coordinates [m/s or rad/s], shape ``(n_worlds, n_bodies, 3)``.
    """

    bodies: Ints
    commands: Floats

    def others(self, groups: Sequence[Group]) -> list[Group]:
        """Return the groups of bodies that still decide for themselves."""
        free = [np.flatnonzero(~np.isin(group.members, self.bodies)) for group in groups]
        return [group.select(chosen) for group, chosen in zip(groups, free, strict=True) if len(chosen)]

    def give(self, state: State, shard: Shard) -> None:
        """Write the commands over the decisions."""
        state.command[shard.worlds[:, None], self.bodies] = self.commands[shard.worlds]

    def show(self, state: State, shard: Shard) -> None:
        """Write the actual velocities of these bodies as their plans, because they did not follow a plan."""
        rows = shard.worlds[:, None]
        state.plan[rows, self.bodies] = state.twist[rows, self.bodies, :2]


def advance(parts: Parts, model: Model, state: State, shard: Shard, orders: Orders | None = None) -> None:
    """Advance the shard's worlds by one step_time. This order is the specification."""
    if parts.sweep is not None:
        swept.note_starts(shard.worlds, parts.sweep, model, state)
    for group in parts.group_behaviors:
        decide(group, model, state, shard)
    arrival.renew_goals(shard.worlds, parts.goal_bodies, parts.loop_returns, model, state)
    for turn in parts.turns:
        for group in turn.behaviors if orders is None else orders.others(turn.behaviors):
            decide(group, model, state, shard)
        if orders is not None:
            orders.give(state, shard)
        asked = disturbances.asked(turn, model, state, shard)
        limit(parts, turn.driven, model, asked, shard)
        moved = disturbances.moved(turn, model, state, shard)
        for group in turn.kinematics:
            group.kind.move(group, model, moved, shard)
        outlines.place(turn.movers, model, state, shard)
        body_buckets.refresh(turn.movers, model, state, shard)
    disturbances.believe(parts.disturbances, model, state, shard)
    if orders is not None:
        orders.show(state, shard)
    # The caller moves the bodies between steps: their outlines are still those of the old poses.
    if parts.external:
        outlines.place(parts.everyone, model, state, shard)
        body_buckets.refresh(parts.everyone, model, state, shard)
    # ``tick`` comes last, so ``state.step`` is still the number of the step before.
    let_appear(parts, model, state, shard, ahead=1)
    if parts.pushing is not None and parts.matter is not None:
        part_bodies(shard.worlds, shard.slot, parts.pushing, parts.matter, model.cells, model, state)
        body_buckets.refresh(parts.movers, model, state, shard)
    contact.find(parts.movers, model, state, shard, parts.sweep)
    if parts.patience is not None:
        patience.let_go(shard.worlds, parts.patience, model, state)
    check_arrival(parts, model, state, shard)
    sense(parts, model, state, shard)
    if parts.fog is not None:
        fog.reveal(parts.fog, model, state, shard)
    tick(shard.worlds, model, state)


def advance_one(parts: Parts, model: Model, state: State, shard: Shard, body: int, *, decides: bool) -> None:
    """Move one body by step_time, as ``advance`` moves it without disturbances; all else stays: time, flags, readings.

    Args:
        parts: Groups and index lists.
        model: Constants of the worlds.
        state: State of the worlds.
        shard: The worlds.
        body: The body.
        decides: Ask its behaviour for its command, which else stands in ``state.command``.
    """
    here = np.array([body], np.int64)
    goals, loops = np.intersect1d(parts.goal_bodies, here), np.intersect1d(parts.loop_returns, here)
    arrival.renew_goals(shard.worlds, goals, loops, model, state)
    for group in _of(parts.behaviors, body) if decides else ():
        decide(group, model, state, shard)
    limit(parts, np.setdiff1d(here, parts.coasting), model, state, shard)
    for group in _of(parts.kinematics, body):
        group.kind.move(group, model, state, shard)
    outlines.place(here, model, state, shard)
    body_buckets.refresh(here, model, state, shard)
    disturbances.tell(parts.disturbances, here, state, shard)


def limit(parts: Parts, driven: Ints, model: Model, state: State, shard: Shard) -> None:
    """Turn the commands of bodies with a drive into velocities that it can execute."""
    command_limits.limit_velocity(shard.worlds, driven, model, state)
    if parts.pushing is not None and parts.matter is not None:
        follow(shard.worlds, driven, parts.pushing, parts.matter, model, state)


def _of(groups: Sequence[Group], body: int) -> list[Group]:
    return [group.select(np.flatnonzero(group.members == body)) for group in groups if body in group.members]


def let_appear(parts: Parts, model: Model, state: State, shard: Shard, ahead: int) -> None:
    """Let bodies whose behaviour does so appear and disappear, as at the step ``state.step + ahead``."""
    for group in parts.visitors:
        group.kind.appear(group, model, state, shard, ahead)
        outlines.place(group.members, model, state, shard)
        body_buckets.refresh(group.members, model, state, shard)


def refresh(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Update the worlds without moving anything, after poses were written from outside."""
    outlines.place(parts.everyone, model, state, shard)
    body_buckets.refresh(parts.everyone, model, state, shard)
    disturbances.tell(parts.disturbances, parts.everyone, state, shard)
    find_flags(parts, model, state, shard)
    sense(parts, model, state, shard)


def find_flags(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Update contacts and arrivals from the present poses."""
    contact.find_static(parts.fixed, model, state, shard)
    contact.find(parts.movers, model, state, shard)
    check_arrival(parts, model, state, shard)


def check_arrival(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Update distances to goals, which are true, and arrivals, which are what robots believe."""
    if (belief := parts.disturbances.belief) is None:
        arrival.check_arrival(shard.worlds, parts.goal_bodies, model, state)
    else:
        disturbances.tell_truth(shard.worlds, belief.others, state, belief.state)
        arrival.check_arrival(shard.worlds, parts.goal_bodies, model, belief.state)
        arrival.measure_distance(shard.worlds, parts.goal_bodies, state)


def sense(parts: Parts, model: Model, state: State, shard: Shard) -> None:
    """Take the readings of all sensors."""
    for group in parts.sensors:
        group.kind.sense(group, model, state, shard)
    for group in parts.disturbances.scans:
        group.kind.disturb(group, model, state, shard)


@kernel
def tick(worlds: Ints, model: Model, state: State) -> None:
    """Count the step. The time is a multiple of the step time, so rounding errors do not accumulate.

    Reads: model (step_time), state (step).
    Writes: state (step, time).
    """
    for w in worlds:
        state.step[w] += 1
        state.time[w] = state.step[w] * model.step_time[0]
