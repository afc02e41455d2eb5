"""A detector of ties: decisions that ir-sim itself turns over when its state is moved by 1e-12."""

from __future__ import annotations

from typing import Any

import numpy as np
from ir_sim import Snapshot

PUSH = 1e-12
MATCH = 1e-9
TRIES = 48
EDGE = 1e-9


def confirm(pair: Any, b: int, before: Snapshot, after: Snapshot) -> None:
    """Fail unless our answer for the body is one that ir-sim gives from a state that differs by 1e-12.

    ir-sim steps again and again from its own state, moved by random amounts of that size; it is then set back.
    """
    random = np.random.default_rng(pair.report.steps)
    least = pair.apart(b, after)
    try:
        for _ in range(TRIES):
            pair.reference.restore(pushed(before, random))
            pair.reference.step(pair.held)
            least = min(least, pair.apart(b, pair.reference.snapshot()))
            if least <= MATCH:
                return
    finally:
        pair.reference.restore(after)
    name = pair.reference.objects[b].name
    raise AssertionError(
        f"step {pair.report.steps}: {name} is {pair.apart(b, after):.3g} from ir-sim's state and {least:.3g} from any "
        f"that it reaches from within {PUSH:g}: ours {pair.sim.state.pose[0, b]}, {pair.sim.state.velocity[0, b]}, "
        f"ir-sim's {after.states[b][:, 0]}, {after.velocities[b][:, 0]}"
    )


def pushed(at: Snapshot, random: Any) -> Snapshot:
    """Return the state with every number of pose and velocity moved a little."""
    states = [state + PUSH * random.uniform(-1, 1, state.shape) for state in at.states]
    velocities = [velocity + PUSH * random.uniform(-1, 1, velocity.shape) for velocity in at.velocities]
    planned = [[tuple(np.add(velocity, PUSH * random.uniform(-1, 1, 2))) for velocity in one] for one in at.planned]
    return Snapshot(states, velocities, at.goals, at.flags, at.touched, planned, at.clock, at.random)


def on_threshold(theirs: Any) -> bool:
    """Return whether an object stands on the very edge of arrival."""
    if theirs.goal is None:
        return False
    near, far = theirs.goal_threshold - EDGE, theirs.goal_threshold + EDGE
    return bool(theirs.check_arrive(theirs.goal, near) != theirs.check_arrive(theirs.goal, far))
