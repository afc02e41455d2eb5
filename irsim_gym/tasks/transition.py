"""What a learner gets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from irsim_gym.arraytypes import Flags, Floats, Rays
from irsim_gym.tasks.state import EpisodeState


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
    """

    observation: Rays
    reward: Floats
    terminated: Flags
    truncated: Flags
    reward_terms: Floats
    over: Flags
    infos: Mapping[str, NDArray[Any]]

    @property
    def live(self) -> Flags:
        """Agents whose episode is under way, a fresh array of shape ``(n_worlds, n_agents)``."""
        return ~(self.terminated | self.truncated)


def transition_of(state: EpisodeState) -> Transition:
    """Return the view of a task's arrays that learners get."""
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
        state.observation, state.reward, state.terminated, state.truncated, state.reward_term, state.over, infos
    )
