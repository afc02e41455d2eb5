"""The state of a whole team: what a centralised critic sees."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.engine import Simulation
from irsim_gym.jit import kernel
from irsim_gym.tasks.outcome import RUNNING
from irsim_gym.tasks.scaling import unit

WIDTH = 10
"""Numbers for each agent."""


def team_states(simulation: Simulation, agents: Ints, outcome: Ints, worlds: Ints) -> Rays:
    """Return the state of the whole teams of some worlds, fresh, ``(n, WIDTH * n_agents)``."""
    model, world = simulation.model, simulation.state
    states = np.zeros((len(worlds), WIDTH * len(agents)), np.float32)
    write_team_state(
        worlds,
        agents,
        model.bounds,
        model.velocity_max,
        model.velocity_min,
        model.has_goal,
        world.stopped,
        world.pose,
        world.twist,
        world.goal,
        outcome,
        model.present,
        states,
    )
    return states


@kernel
def write_team_state(
    worlds: Ints,
    agents: Ints,
    bounds: Floats,
    velocity_max: Floats,
    velocity_min: Floats,
    has_goal: Flags,
    stopped: Flags,
    pose: Floats,
    twist: Floats,
    goal: Floats,
    outcome: Ints,
    present: Flags,
    out: Rays,
) -> None:
    """Write ten numbers for each agent: x, y, cos and sin of the heading, velocity x, y, goal x, y, live, present.

    Positions are scaled so that the world's rectangle is [-1, 1] and cut to it, velocities (in the world frame) by the
    agent's largest limit. A goal that is not there is 0, 0; of a body that is not there all but the goal is 0.

    Args:
        worlds: The worlds to treat, ``(n,)``.
        agents: Body of each agent, ``(n_agents,)``.
        bounds: World rectangle [m].
        velocity_max: ``(n_worlds or 1, n_bodies, 3)`` [m/s or rad/s].
        velocity_min: The same.
        has_goal: ``(n_bodies,)``.
        stopped: ``(n_worlds, n_bodies)``.
        pose: ``(n_worlds, n_bodies, 3)`` [m, m, rad].
        twist: The same shape, in the world frame [m/s, m/s, rad/s].
        goal: The same shape [m, m, rad].
        outcome: ``(n_worlds, n_agents)``.
        present: ``(n_worlds, n_bodies)``.
        out: Written, ``(n, n_agents * 10)``, in the order of ``worlds``.
    """
    middle_x, middle_y = 0.5 * (bounds[0] + bounds[2]), 0.5 * (bounds[1] + bounds[3])
    half_x, half_y = 0.5 * (bounds[2] - bounds[0]), 0.5 * (bounds[3] - bounds[1])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        fastest, slowest = velocity_max[w % velocity_max.shape[0]], velocity_min[w % velocity_min.shape[0]]
        for a in range(agents.shape[0]):
            b, row = agents[a], out[i, WIDTH * a : WIDTH * (a + 1)]
            row[:] = np.float32(0.0)
            if has_goal[b]:
                row[6], row[7] = unit((goal[w, b, 0] - middle_x) / half_x), unit((goal[w, b, 1] - middle_y) / half_y)
            if not present[w, b]:
                continue
            row[0], row[1] = unit((pose[w, b, 0] - middle_x) / half_x), unit((pose[w, b, 1] - middle_y) / half_y)
            row[2], row[3] = np.float32(np.cos(pose[w, b, 2])), np.float32(np.sin(pose[w, b, 2]))
            largest = max(np.abs(fastest[b, 0]), np.abs(slowest[b, 0]))
            if largest > 0.0 and not stopped[w, b]:
                row[4], row[5] = unit(twist[w, b, 0] / largest), unit(twist[w, b, 1] / largest)
            row[8] = np.float32(1.0) if outcome[w, a] == RUNNING else np.float32(0.0)
            row[9] = np.float32(1.0)
