"""What an agent does.

One class for each action, named as in YAML.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.families import ACTIONS
from irsim_gym.simulator.engine import Simulation
from irsim_gym.tasks.terms import EpisodeState, Floats, Ints, Model, Shard, State, Term, kernel, kind, option, row_of
from irsim_gym.tasks.terms.outcome import RUNNING

FRAME = option("body", meaning="Frame of an omni drive's action: the body's, or that of its commands (the world's).")


@kind
class VelocityAction:
    """A continuous action: one number in [-1, 1] for each component of the command; other numbers are clipped."""

    frame: Literal["body", "command"] = FRAME

    @property
    def n_choices(self) -> int:
        """0, since the action is continuous."""
        return 0

    def samples(self, term: Term) -> Floats:
        """Return the actions with all numbers -1 and with all numbers 1, ``(n_agents, 2, n_components)``."""
        ends = np.array([-1.0, 1.0])[:, None] * np.ones(term.action_size)
        return np.stack([ends] * len(term.agents))

    @staticmethod
    def act(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Copy the learner's numbers, clipped to [-1, 1]."""
        take_given(shard.worlds, term.action_sizes, episode)


@kind
class DiscreteAction:
    """A discrete action: a grid of commands, evenly spaced between the limits, including the limits.

    Choice ``i * angular + j`` combines the i-th of ``linear`` values of the command's first component with the j-th of
    ``angular`` values of its last one, both ascending from ``vel_min``, so that right turns come first. With an odd
    number of values and symmetric limits, the middle value is 0. A drive with three components has ``lateral`` values
    of the second one: choice ``(i * lateral + l) * angular + j``.
    """

    linear: int = option(3, ge=1, le=1000, meaning="Number of values of the first component; 1: only the maximum.")
    lateral: int = option(
        1, ge=1, le=1000, meaning="Number of values of the second of three components; 1: only its middle."
    )
    angular: int = option(5, ge=1, le=1000, meaning="Number of values of the last component; 1: only its middle.")
    frame: Literal["body", "command"] = FRAME

    @property
    def n_choices(self) -> int:
        """Number of points of the grid."""
        return self.linear * self.lateral * self.angular

    def arrays(self, simulation: Simulation, agents: Ints) -> dict[str, NDArray[Any]]:
        """Return the action in [-1, 1] of each choice, shape ``(n_agents, n_choices, n_components)``."""
        sizes = [len(simulation.scenario.bodies[int(b)].kinematics.command_names) for b in agents]
        grid = np.zeros((len(sizes), self.n_choices, max(sizes)))
        for a, size in enumerate(sizes):
            grid[a, :, :size] = self._grid(size)
        return {"grid": grid}

    def _grid(self, size: int) -> Floats:
        """Return the choices of a drive with ``size`` components, shape ``(n_choices, size)``."""
        first = np.linspace(-1.0, 1.0, self.linear) if self.linear > 1 else np.ones(1)
        between, last = (np.linspace(-1.0, 1.0, n) if n > 1 else np.zeros(1) for n in (self.lateral, self.angular))
        axes = (first, last) if size == 2 else (first, between, last)
        return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)

    def samples(self, term: Term) -> Floats:
        """Return the action of each choice, ``(n_agents, n_choices, n_components)``."""
        grid: Floats = term.arrays["grid"]
        return grid

    @staticmethod
    def act(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Look up the actions of the learner's choices."""
        take_choice(shard.worlds, term.arrays["grid"], episode)


ACTIONS.register("velocity", VelocityAction)
ACTIONS.register("discrete", DiscreteAction)


def take(given: NDArray[Any], worlds: Ints, n_choices: int, sizes: Ints, kept: NDArray[Any]) -> None:
    """Check and copy actions.

    Args:
        given: Actions as ``Episodes.step`` takes them.
        worlds: The worlds to treat; other rows are not checked.
        n_choices: Number of choices; 0 for continuous actions.
        sizes: Components of each agent's actions, ``(n_agents,)``.
        kept: Output, of the shape that ``given`` must have.

    Raises:
        ValueError: If an action has the wrong shape or type, is not finite or is not a valid choice.
    """
    if given.shape != kept.shape:
        raise ValueError(f"actions must have shape {kept.shape}, got {given.shape}")
    if given.dtype.kind not in ("iu" if n_choices else "fiu"):
        wanted = "whole numbers" if n_choices else "numbers"
        raise ValueError(f"actions must be {wanted}, got an array of {given.dtype}")
    kept[...] = given
    if n_choices and not all_within(worlds, n_choices, kept):
        raise ValueError(f"an action is not a choice from 0 to {n_choices - 1}")
    if not n_choices and not all_finite.compiled(worlds, sizes, kept):  # type: ignore[attr-defined]
        raise ValueError("an action is not finite")


@kernel
def all_finite(worlds: Ints, sizes: Ints, given: Floats) -> bool:
    """Return whether the actions ``(n_worlds, n_agents, n_components)`` of all given worlds are finite.

    Components from ``sizes[a]`` on, which the agent's drive does not have, are not checked.
    """
    for w in worlds:
        for a in range(given.shape[1]):
            for c in range(sizes[a]):
                if not np.isfinite(given[w, a, c]):
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
def take_given(worlds: Ints, sizes: Ints, episode: EpisodeState) -> None:
    """Move the latest action to ``previous_action``, and write the new one, clipped to [-1, 1].

    Components from ``sizes[a]`` on, which the agent's drive does not have, become 0.

    Reads: episode (action, given).
    Writes: episode (action, previous_action).
    """
    for w in worlds:
        for a in range(episode.action.shape[1]):
            for c in range(episode.action.shape[2]):
                episode.previous_action[w, a, c] = episode.action[w, a, c]
                episode.action[w, a, c] = min(max(episode.given[w, a, c], -1.0), 1.0) if c < sizes[a] else 0.0


@kernel
def take_choice(worlds: Ints, grid: Floats, episode: EpisodeState) -> None:
    """Move the latest action to ``previous_action``, and write the chosen row of ``grid``.

    Reads: episode (action, choice).
    Writes: episode (action, previous_action).
    """
    for w in worlds:
        for a in range(episode.action.shape[1]):
            for c in range(episode.action.shape[2]):
                episode.previous_action[w, a, c] = episode.action[w, a, c]
                episode.action[w, a, c] = grid[a, episode.choice[w, a], c]


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
                wanted = 0.5 * (low + high) + episode.action[w, a, c] * (0.5 * (high - low))
                state.command[w, b, c] = wanted if episode.outcome[w, a] == RUNNING else 0.0


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
