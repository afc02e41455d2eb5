"""A detector of ties: decisions that ir-sim itself turns over when its state is moved by 1e-12 or less."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
from ir_sim import Snapshot, rounded_centres

PUSH = 1e-12
SINGLE_PUSH = 1e-6
MATCH = 1e-9
TRIES = 48
EDGE = 1e-9


def confirm(pair: Any, b: int, before: Snapshot, after: Snapshot) -> None:
    """Fail unless our answer for the body is one that ir-sim gives from a state that differs by 1e-12.

    ir-sim steps again and again from its own state, moved by random amounts of that size, with and without the
    rounding errors of its centroids; it is then set back.
    """
    random = np.random.default_rng(pair.report.steps)
    least, match = pair.apart(b, after), pair.tolerance(b)
    push = PUSH if match <= MATCH else SINGLE_PUSH
    try:
        for attempt in range(TRIES):
            pair.reference.restore(pushed(before, random, push) if attempt else before)
            with rounded_centres() if attempt % 2 == 0 else contextlib.nullcontext():
                pair.reference.step(pair.held)
            least = min(least, pair.apart(b, pair.reference.snapshot()))
            if least <= match:
                return
    finally:
        pair.reference.restore(after)
    name = pair.reference.objects[b].name
    raise AssertionError(
        f"step {pair.report.steps}: {name} is {pair.apart(b, after):.3g} from ir-sim's state and {least:.3g} from any "
        f"that it reaches from within {push:g}: ours {pair.sim.state.pose[0, b]}, {pair.sim.state.velocity[0, b]}, "
        f"ir-sim's {after.states[b][:, 0]}, {after.velocities[b][:, 0]}"
    )


def pushed(at: Snapshot, random: Any, most: float) -> Snapshot:
    """Return the state with all or some numbers of poses and velocities moved, by a rounding error or by ``most``."""
    size, share = random.choice([1e-16, 1e-15, most]), random.choice([0.1, 0.4, 1.0])

    def push(numbers: Any) -> Any:
        chosen = random.random(np.shape(numbers)) < share
        scale = np.maximum(1.0, np.abs(numbers)) if size < most else 1.0
        return numbers + chosen * size * scale * random.uniform(-1, 1, np.shape(numbers))

    states, velocities = [push(state) for state in at.states], [push(velocity) for velocity in at.velocities]
    planned = [[tuple(push(np.array(velocity))) for velocity in one] for one in at.planned]
    return Snapshot(states, velocities, at.goals, at.flags, at.touched, planned, at.clock, at.random)


def on_threshold(theirs: Any) -> bool:
    """Return whether an object stands on the very edge of arrival."""
    if theirs.goal is None:
        return False
    near, far = theirs.goal_threshold - EDGE, theirs.goal_threshold + EDGE
    return bool(theirs.check_arrive(theirs.goal, near) != theirs.check_arrive(theirs.goal, far))
