"""Buffers for Stable-Baselines3 that leave out the rows of agents that wait for their world."""

from collections.abc import Generator
from copy import copy
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.buffers import DictRolloutBuffer, RolloutBuffer
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.arraytypes import Flags
from irsim_gym.envs.parts.observations import on_each

BufferT = TypeVar("BufferT", bound=RolloutBuffer)
COLUMNS = ("actions", "values", "log_probs", "advantages", "returns")


class Team(Protocol):
    """The masks of a ``TeamVecEnv``; see there."""

    acted: Flags
    acting: Flags
    leaves_out_waiting: bool


class MaskedRolloutBuffer(RolloutBuffer):
    """The rollout buffer of ``MaskedPPO`` and ``MaskedA2C``: minibatches hold the rows of agents that acted.

    Advantages need no change: an agent's end is a ``done``, which cuts the sum before its waiting begins. Minibatches
    are as equal as the number of rows allows, so that none is tiny; where no agent waits, they are those of
    ``RolloutBuffer``.

    Attributes:
        acted: Rows that are experience, ``(buffer_size, n_envs)``.
        team: The source of the mask, see ``read_mask_of``.
    """

    acted: Flags
    team: Team | None = None

    def reset(self) -> None:
        """Forget everything."""
        self.acted = np.zeros((self.buffer_size, self.n_envs), np.bool_)
        super().reset()

    def add(self, obs: Any, action: Any, reward: Any, *args: Any, **kwargs: Any) -> None:
        """Add a row for each slot; see ``RolloutBuffer.add``."""
        self.acted[self.pos] = acted_of(self.team)
        super().add(obs, action, reward, *args, **kwargs)

    def get(self, batch_size: int | None = None) -> Generator[RolloutBufferSamples, None, None]:
        """Return shuffled minibatches of the rows that are experience."""
        if not self.generator_ready:
            keep_experience(self)
            self.generator_ready = True
        return super(MaskedRolloutBuffer, rows_of(self)).get(even_parts(len(self.values), batch_size))


class MaskedDictRolloutBuffer(MaskedRolloutBuffer, DictRolloutBuffer):  # type: ignore[misc]
    """``MaskedRolloutBuffer`` for dict observations."""


def team_below(env: VecEnv) -> Team:
    """Return the team below the wrappers of an environment.

    Raises:
        TypeError: The environment is no team.
    """
    team: Any = env.unwrapped
    if not hasattr(team, "acted"):
        raise TypeError(
            f"{type(team).__name__} does not say which slots acted: masked algorithms, buffers and wrappers are for "
            "sb3.make_multi_agent_vec_env"
        )
    below: Team = team
    return below


def read_mask_of(env: VecEnv, buffer: Any) -> None:
    """Let a masked rollout buffer read the mask of the team that fills it.

    Args:
        env: The environment that the rollout is collected from; the team may be below wrappers.

    Raises:
        TypeError: The environment is no team.
    """
    buffer.team = team_below(env)
    buffer.team.leaves_out_waiting = True


def acted_of(team: Team | None) -> Flags:
    """Return the mask of a team's latest step.

    Raises:
        TypeError: The buffer was given no team.
    """
    if team is None:
        raise TypeError(
            "a masked rollout buffer has to know which slots acted, and this algorithm does not say: "
            "use sb3.MaskedPPO, sb3.MaskedA2C or sb3.GruPPO"
        )
    return team.acted


def even_parts(n_rows: int, batch_size: int | None) -> int:
    """Return the size, at most ``batch_size``, that cuts the rows into as few and as equal parts as can be."""
    if batch_size is None:
        return n_rows
    n_parts = -(-n_rows // batch_size)
    return -(-n_rows // n_parts)


def rows_of(buffer: BufferT) -> BufferT:
    """Return a buffer of one slot with the rows that are experience; the arrays are those of ``buffer``."""
    rows = copy(buffer)
    rows.buffer_size, rows.n_envs = len(buffer.values), 1
    return rows


def keep_experience(buffer: Any) -> None:
    """Flatten the arrays of a rollout buffer, slot after slot, to the rows that are experience."""
    buffer.observations = on_each(buffer.observations, partial(keep_experience_in, buffer))
    for name in COLUMNS:
        setattr(buffer, name, keep_experience_in(buffer, getattr(buffer, name)))


def keep_experience_in(buffer: Any, values: NDArray[Any]) -> NDArray[Any]:
    """Return values ``(buffer_size, n_envs, ...)`` as rows, slot after slot: those that are experience."""
    rows: NDArray[Any] = buffer.swap_and_flatten(values)[buffer.swap_and_flatten(buffer.acted)[:, 0]]
    return rows
