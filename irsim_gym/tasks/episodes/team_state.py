"""The state of a whole team, for a centralised critic."""

import numpy as np

from irsim_gym.tasks.terms import RUNNING, Ints, Model, Rays, Simulation, State, kernel, row_of, unit

WIDTH = 10
"""Number of values per agent."""


def team_states(simulation: Simulation, agents: Ints, outcome: Ints, worlds: Ints) -> Rays:
    """Return the state of the teams of some worlds, a fresh array ``(n, WIDTH * n_agents)``."""
    model, world = simulation.model, simulation.state
    states = np.zeros((len(worlds), WIDTH * len(agents)), np.float32)
    write_team_state(worlds, agents, model, world, outcome, states)
    return states


@kernel
def write_team_state(worlds: Ints, agents: Ints, model: Model, state: State, outcome: Ints, out: Rays) -> None:
    """Write ten numbers for each agent: x, y, cos and sin of the heading, velocity x, y, goal x, y, live, present.

    Positions are scaled so that the world's rectangle is [-1, 1], and clipped to it; velocities (in the world frame)
    are divided by the agent's larger limit. A missing goal is 0, 0; of an absent body, all numbers but the goal are 0.

    Reads: model (bounds, has_goal, present, velocity_max, velocity_min), state (goal, pose, stopped, twist).
    Writes: out.

    Args:
        worlds: The worlds to treat, ``(n,)``.
        agents: Body of each agent, ``(n_agents,)``.
        outcome: ``(n_worlds, n_agents)``.
        out: Output, ``(n, n_agents * 10)``, in the order of ``worlds``.
    """
    middle_x, middle_y = 0.5 * (model.bounds[0] + model.bounds[2]), 0.5 * (model.bounds[1] + model.bounds[3])
    half_x, half_y = 0.5 * (model.bounds[2] - model.bounds[0]), 0.5 * (model.bounds[3] - model.bounds[1])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        fastest = model.velocity_max[row_of(model.velocity_max, w)]
        slowest = model.velocity_min[row_of(model.velocity_min, w)]
        for a in range(agents.shape[0]):
            b, row = agents[a], out[i, WIDTH * a : WIDTH * (a + 1)]
            row[:] = np.float32(0.0)
            if model.has_goal[b]:
                row[6] = unit((state.goal[w, b, 0] - middle_x) / half_x)
                row[7] = unit((state.goal[w, b, 1] - middle_y) / half_y)
            if not model.present[w, b]:
                continue
            row[0] = unit((state.pose[w, b, 0] - middle_x) / half_x)
            row[1] = unit((state.pose[w, b, 1] - middle_y) / half_y)
            row[2], row[3] = np.float32(np.cos(state.pose[w, b, 2])), np.float32(np.sin(state.pose[w, b, 2]))
            # One scale for both components, because the velocity is given in the world frame.
            largest = max(np.abs(fastest[b, 0]), np.abs(slowest[b, 0]))
            if largest > 0.0 and not state.stopped[w, b]:
                row[4], row[5] = unit(state.twist[w, b, 0] / largest), unit(state.twist[w, b, 1] / largest)
            row[8] = np.float32(1.0) if outcome[w, a] == RUNNING else np.float32(0.0)
            row[9] = np.float32(1.0)
