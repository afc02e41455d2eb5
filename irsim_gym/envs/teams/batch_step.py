"""What a batch of worlds with many learners gives at each step."""

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Rays
from irsim_gym.envs.parts.spaces import Observation


@dataclass(frozen=True)
class BatchStep:
    """What a step, or a reset, gave; all arrays are fresh.

    Observations are arrays, or a dict of arrays.

    Attributes:
        observation: What the agents perceive now, shape ``(n_worlds, n_agents, ...)``, those that begin an episode
            included: the next actions answer to it. An agent that waits for its world keeps its last observation.
        reward: Reward of the step, shape ``(n_worlds, n_agents)``; 0 where ``acted`` is False.
        terminated: The agent's task has ended in this very step, likewise.
        truncated: The agent's episode was cut in this very step, likewise, by its time limit or because its world
            restarts.
        acted: The agent was under way when the step began: its row is experience, likewise. The others must not be
            learnt from.
        live: The agent is under way now, likewise.
        began: ``observation`` is the first of an episode, likewise.
        final_observation: The observation after the step, before any restart, likewise. Where an episode was truncated,
            its value stands for what would have followed.
        reward_terms: The terms that ``reward`` is the sum of, ``(n_worlds, n_agents, n_terms)``.
        infos: Arrays as in ``Transition.infos``, of shape ``(n_worlds, n_agents)``, before any restart, and
            ``episode_return``: the sum of the agent's rewards so far. The outcome of an agent that was cut with its
            world is RUNNING.
        state: What a centralised critic sees, ``(n_worlds, n_state)``, in [-1, 1], see ``Episodes.team_state``; without
            columns where the batch was made with ``team_state=False``.
        final_state: The same, of the same shape, before any restart.
    """

    observation: Observation
    reward: Floats
    terminated: Flags
    truncated: Flags
    acted: Flags
    live: Flags
    began: Flags
    final_observation: Observation
    reward_terms: Floats
    infos: dict[str, NDArray[Any]]
    state: Rays
    final_state: Rays

    @property
    def ended(self) -> Flags:
        """The agent's episode has ended in this very step, ``(n_worlds, n_agents)``."""
        return self.terminated | self.truncated
