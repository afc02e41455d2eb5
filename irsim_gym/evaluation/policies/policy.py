"""Policies that drive the agents of many worlds."""

from collections.abc import Callable
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Ints
from irsim_gym.envs.parts.spaces import observation_layout
from irsim_gym.evaluation.policies.perception import Perception
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.episodes.transition import Percepts

Actions = NDArray[Any]


@runtime_checkable
class Policy(Protocol):
    """A policy that drives the agents of many worlds."""

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Prepare for the levels that begin in the given worlds, arrays ``(n,)``."""

    def act(self, episodes: Episodes, worlds: Ints) -> Actions:
        """Return the actions of worlds: ``(n, n_agents, action_dim)`` in [-1, 1], or ``(n, n_agents)`` integers.

        If a task has one agent, its axis is omitted: ``(n, action_dim)`` or ``(n,)``. Actions of agents whose episode
        has ended are ignored.
        """


class ObservationPolicy:
    """A policy that acts on each agent's own observation; the agents of a team share it.

    Args:
        function: Maps observations, float32 ``(n, n_features)``, to actions ``(n, action_dim)`` or ``(n,)``, with a row
            for each agent of each world. Observations have the form of the environments, stacked: a dict of arrays
            for dicts, uint8 ``(n, height, width, n_channels)`` for a single image.
        perception: Its observations and action; None for those of the played task.
    """

    def __init__(self, function: Callable[[Any], Actions], perception: Perception | None = None) -> None:
        self.function, self.perception = function, perception

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Do nothing: the policy has no memory."""

    def act(self, episodes: Episodes, worlds: Ints) -> Actions:
        """Return the actions of worlds."""
        seen = percepts(episodes, worlds)
        return by_world(self.function(observation_layout(episodes).formed(seen)), episodes)


def percepts(episodes: Episodes, worlds: Ints) -> Percepts:
    """Return a copy of what the agents of worlds perceive, one row per agent: arrays ``(n * n_agents, ...)``."""
    n_rows = len(worlds) * episodes.n_agents
    return episodes.view.percepts.each(lambda rows: rows[worlds].reshape(n_rows, *rows.shape[2:]))


def by_world(actions: Actions, episodes: Episodes) -> Actions:
    """Convert actions with one row per agent, ``(n * n_agents, ...)``, to the shape that ``Policy.act`` returns."""
    rows = np.asarray(actions)
    return without_lone_axis(rows.reshape(-1, episodes.n_agents, *rows.shape[1:]))


def without_lone_axis(actions: Actions) -> Actions:
    """Convert actions ``(n, n_agents, ...)`` to the shape that ``Policy.act`` returns: no axis for a single agent."""
    return actions[:, 0] if actions.shape[1] == 1 else actions


def by_agent(actions: Actions, episodes: Episodes, worlds: Ints) -> Actions:
    """Convert actions from ``Policy.act`` to shape ``(n, n_agents, ...)``.

    Raises:
        ValueError: If the actions have another shape.
    """
    rows = np.asarray(actions)
    size = () if episodes.action_kind == "discrete" else episodes.action_low.shape
    shape = (len(worlds), episodes.n_agents, *size)
    if rows.shape == shape:
        return rows
    if episodes.n_agents == 1 and rows.shape == (len(worlds), *size):
        return rows[:, None]
    raise ValueError(f"the policy's actions must have shape {shape}, got {rows.shape}")
