"""``wander_goals: {patience: ...}``: wandering bodies that a collision has held for long go on with another goal."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.step.arrival import begin_round
from irsim_gym.simulator.world.model import WANDER
from irsim_gym.simulator.world.names import Flags, Ints, Model, State, Struct, kernel


@dataclass(repr=False)
class Patience(Struct):
    """Who is patient, and for how long they have been held.

    Attributes:
        bodies: Bodies, shape ``(n,)``.
        steps: After how many steps each of them goes on, shape ``(n,)``.
        held: Steps that it has been held, shape ``(n_worlds, n)``.
        free: Whether other bodies that can move do not hold a body, shape ``(n_worlds, n_bodies)``.
    """

    bodies: Ints
    steps: Ints
    held: Ints
    free: Flags


def find_patient(scenario: Scenario, model: Model, agents: tuple[int, ...]) -> Patience | None:
    """Return the patience of wandering bodies; None if no body has any."""
    times = [getattr(getattr(body.renewal, "wander_goals", None), "patience", None) for body in scenario.bodies]
    wanders = model.goal_renewal == WANDER
    bodies = [b for b, time in enumerate(times) if time is not None and wanders[b] and b not in agents]
    steps = [max(1, round(float(times[b] or 0.0) / float(model.step_time[0]))) for b in bodies]
    if not bodies:
        return None
    n_worlds, n_bodies = model.present.shape
    held, free = np.zeros((n_worlds, len(bodies)), np.int64), np.zeros((n_worlds, n_bodies), np.bool_)
    return Patience(np.array(bodies, np.int64), np.array(steps, np.int64), held, free)


@kernel
def begin_patience(worlds: Ints, patience: Patience) -> None:
    """Forget how long bodies have been held.

    Writes: patience (free, held).
    """
    for w in worlds:
        patience.held[w, :], patience.free[w, :] = 0, False


@kernel
def let_go(worlds: Ints, patience: Patience, model: Model, state: State) -> None:
    """Free bodies that have been held long enough, with a new goal, until they touch nothing any more.

    What cannot move still holds them.

    Reads: patience (bodies, free, held, steps), model (abreast, goal_renewal, leader, movable, present, wander_high,
        wander_low, wandering, waypoint_count, waypoints), state (collided, goal, hit, pose, random, stopped).
    Writes: patience (free, held), model (waypoints), state (arrived, goal, random, stopped, waypoint, waypoint_end).
    """
    for w in worlds:
        for k in range(patience.bodies.shape[0]):
            b = patience.bodies[k]
            if not state.collided[w, b]:
                patience.held[w, k], patience.free[w, b] = 0, False
                continue
            if state.stopped[w, b] and model.movable[state.hit[w, b]]:
                patience.held[w, k] += 1
                if not patience.free[w, b] and patience.held[w, k] >= patience.steps[k]:
                    patience.free[w, b], state.arrived[w, b] = True, False
                    begin_round(w, b, False, model, state)
                state.stopped[w, b] = not patience.free[w, b]
