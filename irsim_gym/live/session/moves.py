"""Moves bodies by hand: commands for a step, and new places for obstacles."""

from collections.abc import Mapping, Sequence

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.errors import PlacementError
from irsim_gym.simulator.engine import Shard, Simulation
from irsim_gym.simulator.world.model import ROBOT

SCATTER_TRIES = 100


def commands(simulation: Simulation, rows: Mapping[int, Floats]) -> tuple[Ints, Floats]:
    """Return bodies that can move, shape ``(n,)``, and their commands, shape ``(n, 3)``.

    Raises:
        ValueError: A command has a wrong length.
    """
    found = {}
    for b, row in rows.items():
        if not simulation.model.movable[b]:
            continue
        names = simulation.scenario.bodies[b].kinematics.command_names
        if row.size != len(names):
            name = simulation.parts.names[b]
            raise ValueError(f"an action for '{name}' has {len(names)} numbers ({', '.join(names)}), got {row.size}")
        found[b] = np.pad(row, (0, 3 - row.size))
    return np.array(list(found), np.int64), np.array(list(found.values()), np.float64).reshape(-1, 3)


def scatter(
    simulation: Simulation, bodies: Sequence[int], low: Sequence[float], high: Sequence[float], *, apart: bool
) -> None:
    """Move bodies to random places, for now and for later resets.

    Args:
        simulation: The world.
        bodies: Their indices.
        low: Minimum x, y, heading [m, m, rad].
        high: Maximum x, y, heading [m, m, rad].
        apart: Whether they must be clear of all other bodies.

    Raises:
        PlacementError: One of them found no place in 100 draws; none has moved.
    """
    model, state = simulation.model, simulation.state
    chosen = np.array(bodies, np.int64)
    before, present = state.pose[0, chosen], model.present[0].copy()
    shard, distance = Shard(np.zeros(1, np.int64)), np.zeros((1, 1))
    try:
        # Bodies that are still to be moved are not in the way of those that were.
        model.present[0, chosen] = False
        for b in chosen:
            member = np.array([b], np.int64)
            model.present[0, b] = present[b]
            for _ in range(SCATTER_TRIES):
                state.pose[0, b] = simulation.uniform(low, high)
                simulation.place(member)
                if not apart:
                    break
                simulation.clearance(shard, member, distance)
                if distance[0, 0] > 0.0:
                    break
            else:
                name = simulation.parts.names[b]
                raise PlacementError(f"no place found for '{name}' in {SCATTER_TRIES} draws clear of the others")
    except PlacementError:
        state.pose[0, chosen] = before
        raise
    finally:
        model.present[0] = present
        simulation.place(chosen)
    model.start[0, chosen] = state.pose[0, chosen]


def robots(simulation: Simulation) -> Ints:
    """Return the robots that this level has."""
    return np.flatnonzero((simulation.model.role == ROBOT) & simulation.model.present[0])


def status_of(simulation: Simulation) -> str:
    """Return ``Arrived`` if all robots have arrived, else ``Collision`` if one collides, else ``Running``."""
    chosen = robots(simulation)
    if len(chosen) and simulation.state.arrived[0, chosen].all():
        return "Arrived"
    return "Collision" if simulation.state.collided[0, chosen].any() else "Running"
