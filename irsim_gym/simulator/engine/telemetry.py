"""Figures on the present state of bodies, for pictures and replays."""

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.simulator.engine.simulation import Simulation


def telemetry(simulation: Simulation, world: int, bodies: Ints) -> list[dict[str, float]]:
    """Return ``speed`` [m/s], ``turn_rate`` [rad/s], ``clearance`` [m] and ``goal_distance`` [m] of bodies.

    Bodies without a goal have no distance, absent ones have no figures at all. The clearance is computed here and not
    stored; it is infinite if there is nothing else.
    """
    model, state = simulation.model, simulation.state
    clearance: Floats = np.zeros((simulation.n_worlds, len(bodies)))
    simulation.run(lambda shard: simulation.clearance(shard, bodies, clearance), np.array([world]))
    rows = []
    for k, body in enumerate(bodies.tolist()):
        x, y, turn_rate = state.twist[world, body].tolist()
        numbers = {"speed": float(np.hypot(x, y)), "turn_rate": turn_rate, "clearance": float(clearance[world, k])}
        if model.has_goal[body]:
            numbers["goal_distance"] = float(state.goal_distance[world, body])
        rows.append(numbers if model.present[world, body] else {})
    return rows
