"""The data that learners get from a step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Bytes, Flags, Floats, Rays
from irsim_gym.tasks.terms.episode_state import EpisodeState


@dataclass(frozen=True)
class Percepts:
    """What agents perceive: arrays with common leading axes, such as ``(n_worlds, n_agents)``.

    Attributes:
        observation: Numbers in [-1, 1], float32, shape ``(..., n_features)``.
        images: Images by the name of their observation, uint8, shape ``(..., height, width, n_channels)`` each.
    """

    observation: Rays
    images: Mapping[str, Bytes]

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Percepts:
        """Apply a function to each array."""
        return Percepts(change(self.observation), {name: change(image) for name, image in self.images.items()})

    def overwrite(self, chosen: Flags, other: Percepts) -> None:
        """Copy the rows chosen by a mask over the leading axes from ``other``."""
        self.observation[chosen] = other.observation[chosen]
        for name, image in self.images.items():
            image[chosen] = other.images[name][chosen]


@dataclass(frozen=True)
class Transition:
    """The data of a step for learners: live arrays that the next call of ``Episodes`` overwrites.

    Attributes:
        observation: float32 in [-1, 1], shape ``(n_worlds, n_agents, n_features)``.
        reward: float64, shape ``(n_worlds, n_agents)``.
        terminated: Whether the task has ended, shape ``(n_worlds, n_agents)``.
        truncated: Whether the time limit has ended the episode, shape ``(n_worlds, n_agents)``.
        reward_terms: The terms whose sum is ``reward``, shape ``(n_worlds, n_agents, n_terms)``.
        over: Whether the agent's episode had ended before the step, so that its row is no experience, shape
            ``(n_worlds, n_agents)``.
        infos: Arrays of shape ``(n_worlds, n_agents)``: outcome, hit, hit_kind, path_length [m], min_clearance [m],
            goal_distance [m], is_success, steps, stalled [s], deadlocked, level; some tasks have those of
            ``EXTRAS``, too.
        images: The agents' images, by the name of their observation, uint8, shape
            ``(n_worlds, n_agents, height, width, n_channels)`` each.
    """

    observation: Rays
    reward: Floats
    terminated: Flags
    truncated: Flags
    reward_terms: Floats
    over: Flags
    infos: Mapping[str, NDArray[Any]]
    images: Mapping[str, Bytes]

    @property
    def percepts(self) -> Percepts:
        """All that the agents perceive."""
        return Percepts(self.observation, self.images)

    @property
    def live(self) -> Flags:
        """Whether each agent's episode is running, a fresh array of shape ``(n_worlds, n_agents)``."""
        return ~(self.terminated | self.truncated)


def transition_of(state: EpisodeState, images: Mapping[str, Bytes], extras: Sequence[str] = ()) -> Transition:
    """Return the view of a task's arrays for learners.

    Args:
        state: The state of the episodes.
        images: Images by name, see ``Percepts``.
        extras: Names of the columns of ``state.extra``.
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
        **{name: state.extra[:, :, k] for k, name in enumerate(extras)},
    }
    return Transition(
        state.observation, state.reward, state.terminated, state.truncated, state.reward_term, state.over, infos, images
    )
