"""Buffers for Stable-Baselines3 that leave out the rows of agents that wait for their world."""

from collections.abc import Generator, Sequence
from copy import copy
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np
from gymnasium import Space
from numpy.typing import NDArray
from stable_baselines3.common.buffers import DictReplayBuffer, DictRolloutBuffer, ReplayBuffer, RolloutBuffer
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.arraytypes import Flags, Ints
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


class MaskedReplayBuffer(ReplayBuffer):
    """A replay buffer for SAC, TD3 and DQN that stores the transitions of agents that acted, and no others.

    It holds up to ``buffer_size`` transitions of all slots together.

    Args:
        buffer_size: Most transitions, of all slots together.
        observation_space: What is observed.
        action_space: What is done.
        device: Where PyTorch puts what is sampled.
        n_envs: Slots; their rows are stored one below the other.
        optimize_memory_usage: Only False.
        handle_timeout_termination: An episode that was cut by its time limit counts as one that goes on.

    Raises:
        ValueError: ``optimize_memory_usage`` is True.
    """

    def __init__(
        self,
        buffer_size: int,
        observation_space: Space[Any],
        action_space: Space[Any],
        device: Any = "auto",
        n_envs: int = 1,
        optimize_memory_usage: bool = False,
        handle_timeout_termination: bool = True,
    ) -> None:
        if optimize_memory_usage:
            raise ValueError("optimize_memory_usage is not supported, because rows are not in the order of steps")
        super().__init__(
            buffer_size, observation_space, action_space, device, 1, False, handle_timeout_termination
        )  # fmt: skip

    def add(self, obs: Any, next_obs: Any, action: Any, reward: Any, done: Any, infos: list[dict[str, Any]]) -> None:
        """Store a transition of each slot that acted; see ``ReplayBuffer.add``."""
        slots, rows = _places(self, infos)
        for stored, seen in ((self.observations, obs), (self.next_observations, next_obs)):
            for part, fresh in zip(_parts(stored), _parts(seen), strict=True):
                part[rows, 0] = fresh[slots]
        self.actions[rows, 0] = np.asarray(action).reshape(len(infos), self.action_dim)[slots]
        self.rewards[rows, 0] = np.asarray(reward)[slots]
        self.dones[rows, 0] = np.asarray(done)[slots]
        if self.handle_timeout_termination:
            self.timeouts[rows, 0] = [infos[slot].get("TimeLimit.truncated", False) for slot in slots.tolist()]
        self.full = self.full or self.pos + len(slots) >= self.buffer_size
        self.pos = (self.pos + len(slots)) % self.buffer_size


class MaskedDictReplayBuffer(MaskedReplayBuffer, DictReplayBuffer):
    """``MaskedReplayBuffer`` for dict observations."""


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


def _places(buffer: ReplayBuffer, infos: Sequence[dict[str, Any]]) -> tuple[Ints, Ints]:
    """Return the slots that acted, and the rows in which they are to be stored."""
    slots = np.array([slot for slot, info in enumerate(infos) if not info.get("idle")], np.int64)
    slots = slots[-buffer.buffer_size :]
    return slots, (buffer.pos + np.arange(len(slots))) % buffer.buffer_size


def _parts(seen: Any) -> list[NDArray[Any]]:
    """Return the arrays of observations, sorted by their names."""
    return [seen[name] for name in sorted(seen)] if isinstance(seen, dict) else [seen]
