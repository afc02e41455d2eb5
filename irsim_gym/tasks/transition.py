"""What a learner gets."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, Flags, Floats, Rays
from irsim_gym.tasks.episode_state import EpisodeState

CRITIC = "critic"
"""Under which name the critic's numbers are found."""


@dataclass(frozen=True)
class Percepts:
    """What agents perceive: arrays that begin with the same axes, such as ``(n_worlds, n_agents)``.

    Attributes:
        observation: Numbers in [-1, 1], float32, shape ``(..., n_features)``.
        images: Pictures by the name of their observation, uint8, shape ``(..., height, width, n_channels)`` each.
        critic: What the critic alone perceives: under ``CRITIC`` numbers like ``observation``, under ``critic_NAME``
            pictures; empty where there is nothing.
    """

    observation: Rays
    images: Mapping[str, Bytes]
    critic: Mapping[str, NDArray[Any]]

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Percepts:
        """Return what a function makes of each array."""
        images = {name: change(image) for name, image in self.images.items()}
        return Percepts(change(self.observation), images, {name: change(part) for name, part in self.critic.items()})

    def overwrite(self, chosen: Flags, other: Percepts) -> None:
        """Take the rows that a mask over the first axes chooses from ``other``."""
        self.observation[chosen] = other.observation[chosen]
        for name, image in self.images.items():
            image[chosen] = other.images[name][chosen]
        for name, part in self.critic.items():
            part[chosen] = other.critic[name][chosen]


@dataclass(frozen=True)
class Transition:
    """What the learner gets; live arrays that the next call of ``Episodes`` overwrites.

    Attributes:
        observation: float32 in [-1, 1], shape ``(n_worlds, n_agents, n_features)``.
        reward: float64, shape ``(n_worlds, n_agents)``.
        terminated: The task has ended, shape ``(n_worlds, n_agents)``.
        truncated: The time limit has cut the episode, shape ``(n_worlds, n_agents)``.
        reward_terms: The terms that ``reward`` is the sum of, shape ``(n_worlds, n_agents, n_terms)``.
        over: The agent's episode had ended before the step, so its row is no experience, shape
            ``(n_worlds, n_agents)``.
        infos: Arrays of shape ``(n_worlds, n_agents)``: outcome, hit, hit_kind, path_length [m], min_clearance [m],
            goal_distance [m], is_success, steps, stalled [s], deadlocked, level.
        images: The pictures that the agents see, by the name of their observation, uint8, shape
            ``(n_worlds, n_agents, height, width, n_channels)`` each.
        critic: What the critic alone perceives, see ``Percepts``.
    """

    observation: Rays
    reward: Floats
    terminated: Flags
    truncated: Flags
    reward_terms: Floats
    over: Flags
    infos: Mapping[str, NDArray[Any]]
    images: Mapping[str, Bytes]
    critic: Mapping[str, NDArray[Any]]

    @property
    def percepts(self) -> Percepts:
        """All that the agents perceive."""
        return Percepts(self.observation, self.images, self.critic)

    @property
    def live(self) -> Flags:
        """Agents whose episode is under way, a fresh array of shape ``(n_worlds, n_agents)``."""
        return ~(self.terminated | self.truncated)


def transition_of(state: EpisodeState, images: Mapping[str, Bytes], critic: Mapping[str, NDArray[Any]]) -> Transition:
    """Return the view of a task's arrays that learners get.

    Args:
        state: What the task remembers.
        images: Pictures by name, see ``Percepts``.
        critic: What the critic alone perceives, see ``Percepts``.
    """
    infos = {
        "outcome": state.outcome,
        "hit": state.hit,
        "hit_kind": state.hit_kind,
        "path_length": state.path_length,
        "min_clearance": state.min_clearance,
        "goal_distance": state.goal_distance,
        "is_success": state.success,
        "steps": state.steps,
        "stalled": state.stalled,
        "deadlocked": state.deadlocked,
        "level": state.level,
    }
    return Transition(
        state.observation,
        state.reward,
        state.terminated,
        state.truncated,
        state.reward_term,
        state.over,
        infos,
        images,
        critic,
    )
