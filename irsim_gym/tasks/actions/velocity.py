"""``velocity``: a number for each component of the command."""

from typing import Literal

import numpy as np

from irsim_gym.tasks.actions.commands import FRAME
from irsim_gym.tasks.terms import EpisodeState, Floats, Ints, Model, Shard, State, Term, kernel, kind


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
