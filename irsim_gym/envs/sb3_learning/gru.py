"""PPO with a GRU for many worlds. Rollouts are cut into sequences, which need no padding."""

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import torch
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import DictRolloutBuffer, RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.utils import obs_as_tensor
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.envs.parts.observations import concatenated, on_each
from irsim_gym.envs.sb3.buffers import keep_experience, keep_experience_in, team_below
from irsim_gym.envs.sb3_learning.memory import GruPolicy, Sequences

SEQUENCE_LENGTH = 16


class GruPPO(PPO):
    """PPO with a recurrent policy, see ``GruPolicy``.

    It takes the arguments of ``PPO``. ``rollout_buffer_kwargs={"sequence_length": 16}`` sets the number of steps that
    gradients flow through, ``policy_kwargs={"memory_size": 64}`` the length of the memory, and ``rollout_buffer_class``
    a class derived from ``SequenceBuffer`` or ``DictSequenceBuffer``; others are replaced. It also learns from teams,
    and then only from the rows of robots that acted. ``batch_size`` counts rows. Minibatches consist of whole
    sequences, so that they have a few rows more or less.

    Attributes:
        policy: The networks.
        last_memory: Memory of the current episode of each slot, shape ``(1, n_envs, memory_size)``.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = dict.fromkeys(
        ("MlpGruPolicy", "CnnGruPolicy", "MultiInputGruPolicy"), GruPolicy
    )
    leaves_out_waiting: ClassVar[bool] = True
    policy: GruPolicy
    last_memory: torch.Tensor

    def _setup_model(self) -> None:
        self.rollout_buffer_class = _sequence_buffer(self.rollout_buffer_class, self.observation_space)
        super()._setup_model()
        self.last_memory = self.policy.first_memory(self.n_envs)

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "last_memory"]

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Collect a rollout, see ``PPO``. Return False if the callback stops it."""
        assert isinstance(rollout_buffer, SequenceBuffer)
        assert self._last_obs is not None
        assert self._last_episode_starts is not None
        space, team = self.action_space, team_below(env) if hasattr(env.unwrapped, "acted") else None
        if team is not None:
            team.leaves_out_waiting = True
        self.policy.set_training_mode(False)
        rollout_buffer.reset()
        callback.on_rollout_start()
        for _ in range(n_rollout_steps):
            before, starts = self.last_memory, self._flags(self._last_episode_starts)
            with torch.no_grad():
                obs = obs_as_tensor(self._last_obs, self.device)  # type: ignore[arg-type]
                actions, values, log_probs, self.last_memory = self.policy(obs, before, starts)
            done_actions = actions.cpu().numpy()
            within = np.clip(done_actions, space.low, space.high) if isinstance(space, Box) else done_actions
            new_obs, rewards, dones, infos = env.step(within)
            self.num_timesteps += env.num_envs
            callback.update_locals(locals())
            if not callback.on_step():
                return False
            self._update_info_buffer(infos, dones)
            self._bootstrap_truncated(rewards, dones, infos)
            row: list[Any] = [self._last_obs, done_actions, rewards, self._last_episode_starts, values, log_probs]
            rollout_buffer.add(*row, memory=before, acted=None if team is None else team.acted)
            self._last_obs, self._last_episode_starts = new_obs, dones  # type: ignore[assignment]
        with torch.no_grad():
            obs = obs_as_tensor(self._last_obs, self.device)  # type: ignore[arg-type]
            values = self.policy.predict_values(obs, self.last_memory, self._flags(dones))
        rollout_buffer.compute_returns_and_advantage(last_values=values, dones=dones)
        callback.update_locals(locals())
        callback.on_rollout_end()
        return True

    def _flags(self, flags: NDArray[Any]) -> torch.Tensor:
        return torch.as_tensor(flags, dtype=torch.float32, device=self.device)

    def _bootstrap_truncated(self, rewards: NDArray[Any], dones: Flags, infos: Sequence[dict[str, Any]]) -> None:
        """Add the discounted value of the last observation to the last reward of each truncated episode."""
        cut = [slot for slot in dones.nonzero()[0].tolist() if infos[slot].get("TimeLimit.truncated", False)]
        if not cut:
            return
        last = concatenated([infos[slot]["terminal_observation"] for slot in cut], np.stack)
        with torch.no_grad():
            obs = self.policy.obs_to_tensor(last)[0]
            values = self.policy.predict_values(obs, self.last_memory[:, cut], torch.zeros(len(cut)).to(self.device))
        rewards[cut] += self.gamma * values.cpu().numpy()[:, 0]


@dataclass(frozen=True)
class SequenceTable:
    """The sequences of a rollout. The rows of each are consecutive.

    Attributes:
        starts: First row of each sequence, shape ``(n_sequences,)``.
        lengths: Number of rows of each sequence, shape ``(n_sequences,)``.
        memories: Memory before each sequence, shape ``(n_sequences, memory_size)``.
    """

    starts: Ints
    lengths: Ints
    memories: NDArray[Any]

    def shuffled(self, batch_size: int | None) -> Iterator[tuple[Ints, Ints, NDArray[Any]]]:
        """Yield minibatches of whole sequences, in random order.

        Args:
            batch_size: Approximate number of rows in a minibatch; None for a single minibatch.

        Yields:
            Rows ``(n_rows,)`` in the order of ``Sequences``, the number of sequences that run at each step
            ``(longest,)``, and the memory before each sequence ``(n, memory_size)``.
        """
        order = torch.randperm(len(self.starts)).numpy()
        ends = np.cumsum(self.lengths[order])
        n_rows = int(self.lengths.sum())
        n_parts = 1 if batch_size is None else max(1, -(-n_rows // batch_size))
        limits = np.searchsorted(ends, np.arange(1, n_parts) * n_rows / n_parts, side="right")
        for part in np.split(order, limits):
            if not len(part):
                continue
            part = part[np.argsort(-self.lengths[part], kind="stable")]
            lengths = self.lengths[part]
            steps = np.arange(lengths[0])[:, None]
            runs = steps < lengths
            yield (self.starts[part] + steps)[runs], runs.sum(axis=1), self.memories[part]


class SequenceBuffer(RolloutBuffer):
    """A rollout buffer whose minibatches consist of sequences, for ``GruPPO``.

    A sequence ends with its episode, where a robot waits, or after ``sequence_length`` steps. The memory before each
    sequence is stored. Rows of robots that waited are left out.

    Args:
        *args: Arguments of ``RolloutBuffer``.
        sequence_length: Greatest number of steps in a sequence.
        **kwargs: Keyword arguments of ``RolloutBuffer``.

    Attributes:
        acted: Whether each row is experience, shape ``(buffer_size, n_envs)``.
        memories: Memory before each row, shape ``(buffer_size, n_envs, memory_size)``.
        sequences: The sequences; None before the first minibatch of a rollout.

    Raises:
        ValueError: If ``sequence_length`` is not an integer or less than 1.
    """

    acted: Flags
    memories: NDArray[Any]
    sequences: SequenceTable | None

    def __init__(self, *args: Any, sequence_length: int = SEQUENCE_LENGTH, **kwargs: Any) -> None:
        if not isinstance(sequence_length, int | np.integer) or sequence_length < 1:
            raise ValueError(f"sequence_length must be an integer >= 1, got {sequence_length!r}")
        self.sequence_length = sequence_length
        super().__init__(*args, **kwargs)

    def reset(self) -> None:
        """Remove all rows."""
        self.acted = np.ones((self.buffer_size, self.n_envs), np.bool_)
        self.sequences = None
        super().reset()

    def add(self, *args: Any, memory: torch.Tensor, acted: Flags | None) -> None:  # type: ignore[override]
        """Add a row for each slot.

        Args:
            *args: Arguments of ``RolloutBuffer.add``.
            memory: Memory before the rows, shape ``(1, n_envs, memory_size)``.
            acted: Whether each row is experience, shape ``(n_envs,)``; None if all are.
        """
        self._store_memory(memory)
        if acted is not None:
            self.acted[self.pos] = acted
        super().add(*args)

    def get(self, batch_size: int | None = None) -> Generator[RolloutBufferSamples, None, None]:
        """Return shuffled minibatches of sequences, whose ``observations`` are ``Sequences``; none without experience.

        Args:
            batch_size: Approximate number of rows in a minibatch; None for a single minibatch.
        """
        if self.sequences is None:
            self.sequences = self._cut_into_sequences()
            keep_experience(self)
            self.generator_ready = True
        for rows, running, memory in self.sequences.shuffled(batch_size):
            yield self._samples(rows, torch.as_tensor(running), self.to_torch(memory)[None])

    def _store_memory(self, memory: torch.Tensor) -> None:
        if self.pos == 0:
            self.memories = np.zeros((self.buffer_size, *memory.shape[1:]), np.float32)
        self.memories[self.pos] = memory[0].cpu().numpy()

    def _cut_into_sequences(self) -> SequenceTable:
        """Return the sequences among the rows that are experience, in the order of ``keep_experience_in``."""
        indices: NDArray[Any] = np.indices(self.acted.shape)
        step, slot = keep_experience_in(self, np.moveaxis(indices, 0, -1)).T
        begins = keep_experience_in(self, self.episode_starts)[:, 0] > 0.0
        is_first = begins | (step % self.sequence_length == 0)
        is_first[1:] |= np.diff(slot) != 0
        is_first[:1] = True
        starts = np.flatnonzero(is_first)
        memories = keep_experience_in(self, self.memories)[starts]
        memories[begins[starts]] = 0.0
        return SequenceTable(starts, np.diff(starts, append=len(is_first)), memories)

    def _samples(self, rows: Ints, running: torch.Tensor, memory: torch.Tensor) -> RolloutBufferSamples:
        """Return a minibatch of these rows, ``(n_rows,)``; the other arguments are those of ``Sequences``."""
        seen = on_each(self.observations, lambda part: self.to_torch(part[rows]))
        actions = self.actions[rows]
        if not isinstance(self.action_space, Discrete):
            actions = actions.astype(np.float32, copy=False)
        parts = self.values, self.log_probs, self.advantages, self.returns
        columns: Any = map(self.to_torch, (actions, *(part[rows].flatten() for part in parts)))
        return RolloutBufferSamples(Sequences(seen, running, memory), *columns)  # type: ignore[arg-type]


class DictSequenceBuffer(SequenceBuffer, DictRolloutBuffer):  # type: ignore[misc]
    """``SequenceBuffer`` for dict observations, with the same arguments."""


def _sequence_buffer(kind: type[RolloutBuffer] | None, space: Space[Any]) -> type[RolloutBuffer]:
    """Return the class of the rollout buffer: ``kind`` if it stores sequences of such observations."""
    stores: type[RolloutBuffer] = DictSequenceBuffer if isinstance(space, Dict) else SequenceBuffer
    return kind if kind is not None and issubclass(kind, stores) else stores
