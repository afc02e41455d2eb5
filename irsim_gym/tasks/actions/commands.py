"""Actions are checked and become commands."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.tasks.terms import RUNNING, EpisodeState, Floats, Ints, Model, State, kernel, option, row_of

FRAME = option("body", meaning="Frame of an omni drive's action: the body's, or that of its commands (the world's).")


def take(actions: NDArray[Any], worlds: Ints, n_choices: int, sizes: Ints, taken: NDArray[Any]) -> None:
    """Check and copy actions.

    Args:
        actions: Actions as ``Episodes.step`` takes them.
        worlds: The worlds to treat; other rows are not checked.
        n_choices: Number of choices; 0 for continuous actions.
        sizes: Components of each agent's actions, ``(n_agents,)``.
        taken: Output, of the shape that ``actions`` must have.

    Raises:
        ValueError: If an action has the wrong shape or type, is not finite or is not a valid choice.
    """
    if actions.shape != taken.shape:
        raise ValueError(f"actions must have shape {taken.shape}, got {actions.shape}")
    if actions.dtype.kind not in ("iu" if n_choices else "fiu"):
        numbers = "whole numbers" if n_choices else "numbers"
        raise ValueError(f"actions must be {numbers}, got an array of {actions.dtype}")
    taken[...] = actions
    if n_choices and not all_within(worlds, n_choices, taken):
        raise ValueError(f"an action is not a choice from 0 to {n_choices - 1}")
    if not n_choices and not all_finite.compiled(worlds, sizes, taken):  # type: ignore[attr-defined]
        raise ValueError("an action is not finite")


@kernel
def all_finite(worlds: Ints, sizes: Ints, actions: Floats) -> bool:
    """Return whether the actions ``(n_worlds, n_agents, n_components)`` of all given worlds are finite.

    Components from ``sizes[a]`` on, which the agent's drive does not have, are not checked.
    """
    for w in worlds:
        for a in range(actions.shape[1]):
            for c in range(sizes[a]):
                if not np.isfinite(actions[w, a, c]):
                    return False
    return True


@kernel
def all_within(worlds: Ints, count: int, choice: Ints) -> bool:
    """Return whether the choices ``(n_worlds, n_agents)`` of all given worlds lie in [0, count)."""
    for w in worlds:
        for a in range(choice.shape[1]):
            if choice[w, a] < 0 or choice[w, a] >= count:
                return False
    return True


@kernel
def write_commands(worlds: Ints, agents: Ints, model: Model, state: State, episode: EpisodeState) -> None:
    """Map actions in [-1, 1] affinely to the agents' velocity limits; the command is 0 if the episode has ended.

    Reads: model (velocity_max, velocity_min), episode (action, outcome).
    Writes: state (command).

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent, ``(n_agents,)``.
    """
    for w in worlds:
        slowest = model.velocity_min[row_of(model.velocity_min, w)]
        fastest = model.velocity_max[row_of(model.velocity_max, w)]
        for a in range(agents.shape[0]):
            b = agents[a]
            for c in range(episode.action.shape[2]):
                low, high = slowest[b, c], fastest[b, c]
                command = 0.5 * (low + high) + episode.action[w, a, c] * (0.5 * (high - low))
                state.command[w, b, c] = command if episode.outcome[w, a] == RUNNING else 0.0


@kernel
def turn_commands(worlds: Ints, agents: Ints, state: State) -> None:
    """Rotate the commands of omnidirectional agents from the body frame to the world frame.

    Reads: state (command, pose).
    Writes: state (command).

    Args:
        worlds: The worlds to treat.
        agents: Bodies whose commands are velocities in the world frame, ``(n,)``.
    """
    for w in worlds:
        for b in agents:
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            ahead, left = state.command[w, b, 0], state.command[w, b, 1]
            state.command[w, b, 0] = cosine * ahead - sine * left
            state.command[w, b, 1] = sine * ahead + cosine * left


@kernel
def rest(worlds: Ints, agents: Ints, model: Model, episode: EpisodeState) -> None:
    """Write the action for standing still, or for the nearest possible command, where episodes begin.

    Reads: model (velocity_max, velocity_min), episode (action, began).
    Writes: episode (action, previous_action).
    """
    for w in worlds:
        slowest = model.velocity_min[row_of(model.velocity_min, w)]
        fastest = model.velocity_max[row_of(model.velocity_max, w)]
        for a in range(agents.shape[0]):
            b = agents[a]
            if not episode.began[w, a]:
                continue
            for c in range(episode.action.shape[2]):
                low, high = slowest[b, c], fastest[b, c]
                # The action that ``write_commands`` maps to 0.
                still = -(low + high) / (high - low) if high > low else 0.0
                episode.action[w, a, c] = min(max(still, -1.0), 1.0)
                episode.previous_action[w, a, c] = episode.action[w, a, c]
