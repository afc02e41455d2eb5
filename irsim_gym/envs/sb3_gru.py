"""PPO with a memory (GRU) for many worlds: whole rollouts are cut into sequences, which learn without padding."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from typing import Any, ClassVar

import numpy as np
import torch
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import DictRolloutBuffer, RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.utils import obs_as_tensor
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.arraytypes import Flags, Ints
from irsim_gym.envs.observations import concatenated
from irsim_gym.envs.sb3_buffers import COLUMNS, keep_experience_in, team_below
from irsim_gym.envs.sb3_memory import GruPolicy, Sequences

SEQUENCE_LENGTH = 16


class GruPPO(PPO):
    """PPO whose policy remembers its episode, see ``GruPolicy``.

    It takes the arguments of ``PPO``; ``rollout_buffer_kwargs={"sequence_length": 16}`` is the number of steps through
    which gradients reach back, and ``policy_kwargs={"memory_size": 64}`` the length of the memory. It learns from teams
    too, and from the rows of robots that acted alone. ``batch_size`` counts rows; minibatches hold whole sequences, and
    so a few rows more or less.

    Attributes:
        policy: The networks.
        last_memory: What is remembered of each row's episode so far, shape ``(1, n_envs, memory_size)``.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = dict.fromkeys(
        ("MlpGruPolicy", "CnnGruPolicy", "MultiInputGruPolicy"), GruPolicy
    )
    leaves_out_waiting: ClassVar[bool] = True
    policy: GruPolicy
    last_memory: torch.Tensor

    def _setup_model(self) -> None:
        self.rollout_buffer_class = DictSequenceBuffer if isinstance(self.observation_space, Dict) else SequenceBuffer
        super()._setup_model()
        self.last_memory = self.policy.first_memory(self.n_envs)

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "last_memory"]

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Collect steps of all worlds, see ``PPO``; False if the callback stops it."""
        assert isinstance(rollout_buffer, SequenceBuffer | DictSequenceBuffer)
        assert self._last_obs is not None
        assert self._last_episode_starts is not None
        team = team_below(env) if hasattr(env.unwrapped, "acted") else None
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
            new_obs, rewards, dones, infos = env.step(self._within(done_actions))
            self.num_timesteps += env.num_envs
            callback.update_locals(locals())
            if not callback.on_step():
                return False
            self._update_info_buffer(infos, dones)
            self._add_what_followed(rewards, dones, infos)
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

    def _within(self, actions: NDArray[Any]) -> NDArray[Any]:
        """Return actions as the environment takes them."""
        if isinstance(self.action_space, Box):
            actions = np.clip(actions, self.action_space.low, self.action_space.high)
        return actions

    def _add_what_followed(self, rewards: NDArray[Any], dones: Flags, infos: Sequence[dict[str, Any]]) -> None:
        """Add the value of what would have followed to the last rewards of episodes that a time limit has cut."""
        cut = [slot for slot in dones.nonzero()[0].tolist() if infos[slot].get("TimeLimit.truncated", False)]
        if not cut:
            return
        last = concatenated([infos[slot]["terminal_observation"] for slot in cut], np.stack)
        with torch.no_grad():
            obs = self.policy.obs_to_tensor(last)[0]
            values = self.policy.predict_values(obs, self.last_memory[:, cut], torch.zeros(len(cut)).to(self.device))
        rewards[cut] += self.gamma * values.cpu().numpy()[:, 0]


class SequenceBuffer(RolloutBuffer):
    """A rollout buffer whose minibatches are sequences, for ``GruPPO``.

    Sequences end where an episode does, where a robot waits and after ``sequence_length`` steps; what was remembered
    before each is kept. Rows of robots that waited are left out.

    Args:
        *args: Those of ``RolloutBuffer``.
        sequence_length: Most steps of a sequence.
        **kwargs: More of these.

    Attributes:
        acted: Rows that are experience, ``(buffer_size, n_envs)``.
        memories: What was remembered before each row, ``(buffer_size, n_envs, memory_size)``.
    """

    acted: Flags
    memories: NDArray[Any]

    def __init__(self, *args: Any, sequence_length: int = SEQUENCE_LENGTH, **kwargs: Any) -> None:
        self.sequence_length = _checked(sequence_length)
        super().__init__(*args, **kwargs)

    def reset(self) -> None:
        """Forget everything."""
        self.acted = np.ones((self.buffer_size, self.n_envs), np.bool_)
        super().reset()

    def add(self, *args: Any, memory: torch.Tensor, acted: Flags | None) -> None:  # type: ignore[override]
        """Add a row for each slot, see ``RolloutBuffer.add``; ``acted`` is None where all of them are experience."""
        _note(self, memory, acted)
        super().add(*args)

    def get(self, batch_size: int | None = None) -> Generator[RolloutBufferSamples, None, None]:
        """Return shuffled minibatches of sequences; ``observations`` are ``Sequences``."""
        if not self.generator_ready:
            _cut(self)
            self.observations = keep_experience_in(self, self.observations)
        for rows, running, memory in _minibatches(self, batch_size):
            yield _samples(self, rows, Sequences(self.to_torch(self.observations[rows]), running, memory))


class DictSequenceBuffer(DictRolloutBuffer):
    """``SequenceBuffer`` for dict observations."""

    acted: Flags
    memories: NDArray[Any]

    def __init__(self, *args: Any, sequence_length: int = SEQUENCE_LENGTH, **kwargs: Any) -> None:
        self.sequence_length = _checked(sequence_length)
        super().__init__(*args, **kwargs)

    def reset(self) -> None:
        """Forget everything."""
        self.acted = np.ones((self.buffer_size, self.n_envs), np.bool_)
        super().reset()

    def add(self, *args: Any, memory: torch.Tensor, acted: Flags | None) -> None:  # type: ignore[override]
        """Add a row for each slot, see ``SequenceBuffer.add``."""
        _note(self, memory, acted)
        super().add(*args)

    def get(self, batch_size: int | None = None) -> Generator[Any, None, None]:
        """Return shuffled minibatches of sequences; ``observations`` are ``Sequences``."""
        if not self.generator_ready:
            _cut(self)
            self.observations = {key: keep_experience_in(self, part) for key, part in self.observations.items()}
        for rows, running, memory in _minibatches(self, batch_size):
            seen = {key: self.to_torch(part[rows]) for key, part in self.observations.items()}
            yield _samples(self, rows, Sequences(seen, running, memory))


def _checked(sequence_length: int) -> int:
    if sequence_length < 1:
        raise ValueError(f"sequence_length must be >= 1, got {sequence_length!r}")
    return sequence_length


def _note(buffer: Any, memory: torch.Tensor, acted: Flags | None) -> None:
    """Keep what was remembered before a row, and which slots acted."""
    if buffer.pos == 0:
        buffer.memories = np.zeros((buffer.buffer_size, *memory.shape[1:]), np.float32)
    buffer.memories[buffer.pos] = memory[0].cpu().numpy()
    if acted is not None:
        buffer.acted[buffer.pos] = acted


def _cut(buffer: Any) -> None:
    """Flatten all but the observations to the rows that are experience, and find the sequences among them.

    ``starts`` are the first rows of sequences, ``lengths`` their numbers of rows.
    """
    step, slot = np.indices(buffer.acted.shape)
    by_row = {name: keep_experience_in(buffer, part)[:, 0] for name, part in (("step", step), ("slot", slot))}
    begins = keep_experience_in(buffer, buffer.episode_starts)[:, 0] > 0.0
    first = begins | (by_row["step"] % buffer.sequence_length == 0)
    first[1:] |= np.diff(by_row["slot"]) != 0
    first[:1] = True
    buffer.starts = np.flatnonzero(first)
    buffer.lengths = np.diff(buffer.starts, append=len(first))
    buffer.memories = keep_experience_in(buffer, buffer.memories)[buffer.starts]
    buffer.memories[begins[buffer.starts]] = 0.0
    for name in COLUMNS:
        setattr(buffer, name, keep_experience_in(buffer, getattr(buffer, name)))
    buffer.generator_ready = True


def _minibatches(buffer: Any, batch_size: int | None) -> Iterator[tuple[Ints, torch.Tensor, torch.Tensor]]:
    """Yield shuffled sequences of about ``batch_size`` rows: their rows step by step, as ``Sequences`` has them."""
    order = torch.randperm(len(buffer.starts)).numpy()
    ends = np.cumsum(buffer.lengths[order])
    n_rows = int(ends[-1])
    n_parts = 1 if batch_size is None else -(-n_rows // batch_size)
    limits = np.searchsorted(ends, np.arange(1, n_parts) * n_rows / n_parts)
    for part in np.split(order, limits):
        if not len(part):
            continue
        part = part[np.argsort(-buffer.lengths[part], kind="stable")]
        lengths = buffer.lengths[part]
        steps = np.arange(lengths[0])[:, None]
        runs = steps < lengths
        rows = (buffer.starts[part] + steps)[runs]
        yield rows, torch.as_tensor(runs.sum(axis=1)), buffer.to_torch(buffer.memories[part])[None]


def _samples(buffer: Any, rows: Ints, sequences: Sequences) -> RolloutBufferSamples:
    actions = buffer.actions[rows]
    if not isinstance(buffer.action_space, Discrete):
        actions = actions.astype(np.float32, copy=False)
    values, log_probs, advantages, returns = (getattr(buffer, name)[rows].flatten() for name in COLUMNS[1:])
    columns: Any = map(buffer.to_torch, (actions, values, log_probs, advantages, returns))
    return RolloutBufferSamples(sequences, *columns)  # type: ignore[arg-type]
