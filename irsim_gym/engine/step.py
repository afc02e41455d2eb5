"""One step of the simulator, phase by phase."""

from __future__ import annotations

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.engine import arrival, buckets, contact, limits, outlines
from irsim_gym.engine.parts import Parts
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


def advance(parts: Parts, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Advance the shard's worlds by one step_time. This order is the specification."""
    arrival.renew(parts.goal_bodies, model, state, shard)
    for group in parts.group_behaviors:
        group.kind.decide(group, model, state, shard)
    for turn in parts.turns:
        for group in turn.behaviors:
            group.kind.decide(group, model, state, shard)
        limits.apply(turn.movers, model, state, shard)
        for group in turn.kinematics:
            group.kind.move(group, model, state, shard)
        outlines.place(turn.movers, model, state, shard)
        buckets.refresh(turn.movers, model, state, shard)
    if parts.external:
        outlines.place(parts.everyone, model, state, shard)
        buckets.refresh(parts.everyone, model, state, shard)
    contact.find(parts.movers, model, state, shard)
    arrival.check(parts.goal_bodies, model, state, shard)
    sense(parts, model, state, shard)
    tick(shard.worlds, model.step_time, state.step, state.time)


def sense(parts: Parts, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Take the readings of all sensors."""
    for group in parts.sensors:
        group.kind.sense(group, model, state, shard)


@kernel
def tick(worlds: Ints, step_time: Floats, step: Ints, time: Floats) -> None:
    """Count the step; the time is a multiple of the step time, so it gathers no rounding."""
    for i in range(worlds.shape[0]):
        step[worlds[i]] += 1
        time[worlds[i]] = step[worlds[i]] * step_time[0]
