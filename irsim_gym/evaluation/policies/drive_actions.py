"""Converts commands of drives to actions."""

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.simulator.world.model import OMNI_WORLD
from irsim_gym.tasks import Episodes


def decided_commands(episodes: Episodes, worlds: Ints) -> Floats:
    """Return the agents' decided commands, clipped to their limits, ``(n, n_agents, n_components)``."""
    low, high = velocity_limits(episodes, worlds)
    decided = episodes.simulation.state.command[worlds[:, None], episodes.simulation.agents]
    return np.asarray(np.clip(decided[..., : low.shape[2]], low, high))


def to_actions(episodes: Episodes, worlds: Ints, command: Floats) -> NDArray[np.float64] | Ints:
    """Return the actions that produce commands: exact ones in [-1, 1], or the nearest choices.

    Args:
        episodes: The episodes; their task defines the actions.
        worlds: Indices of the worlds, ``(n,)``.
        command: In drive coordinates [m/s, rad/s], ``(n, n_agents, n_components)``.

    Returns:
        ``(n, n_agents, n_components)``, or ``(n, n_agents)`` choices.
    """
    simulation = episodes.simulation
    if getattr(episodes.task.action, "frame", "command") == "body":
        turned = np.flatnonzero(simulation.model.drive[simulation.agents] == OMNI_WORLD)
        command = _into_body_frame(command, turned, simulation.state.pose[worlds[:, None], simulation.agents, 2])
    low, high = velocity_limits(episodes, worlds)
    half = np.maximum(0.5 * (high - low), 1e-12)
    action: Floats = np.clip((command - 0.5 * (low + high)) / half, -1.0, 1.0)
    return action if episodes.action_kind == "continuous" else _nearest_choices(episodes, action)


def velocity_limits(episodes: Episodes, worlds: Ints) -> tuple[Floats, Floats]:
    """Return the minimum and maximum commands of the agents, ``(n, n_agents, n_components)`` each."""
    model, agents = episodes.simulation.model, episodes.simulation.agents
    size = len(episodes.action_low)
    limits = [field[worlds % len(field)][:, agents, :size] for field in (model.velocity_min, model.velocity_max)]
    return limits[0], limits[1]


def _into_body_frame(command: Floats, turned: Ints, heading: Floats) -> Floats:
    """Return commands, with the velocities of the ``turned`` agents rotated from the world frame to the body frame."""
    cosine, sine = np.cos(heading[:, turned]), np.sin(heading[:, turned])
    vx, vy = command[:, turned, 0], command[:, turned, 1]
    rotated = command.copy()
    rotated[:, turned, 0], rotated[:, turned, 1] = cosine * vx + sine * vy, cosine * vy - sine * vx
    return rotated


def _nearest_choices(episodes: Episodes, action: Floats) -> Ints:
    """Return the choices whose actions are nearest to the given ones in each component."""
    options = episodes.task.action
    choices = np.zeros(action.shape[:2], np.int64)
    for a, size in enumerate(episodes.action_sizes.tolist()):
        counts = (options.linear, options.angular) if size == 2 else (options.linear, options.lateral, options.angular)
        places = [np.rint(0.5 * (action[:, a, c] + 1.0) * (count - 1)) for c, count in enumerate(counts)]
        choices[:, a] = np.ravel_multi_index([place.astype(np.int64) for place in places], counts)
    return choices
