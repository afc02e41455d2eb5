"""Recurrent PPO of sb3-contrib for teams: rows of agents that wait for their world are left out."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, ClassVar

import numpy as np
from gymnasium.spaces import Dict
from numpy.typing import NDArray
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.buffers import RecurrentDictRolloutBuffer, RecurrentRolloutBuffer
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from irsim_gym.arraytypes import Flags
from irsim_gym.envs.sb3_buffers import (
    COLUMNS,
    Team,
    acted_of,
    even_parts,
    keep_experience,
    keep_experience_in,
    read_mask_of,
    rows_of,
)

MEMORIES = ("hidden_states_pi", "cell_states_pi", "hidden_states_vf", "cell_states_vf")


class MaskedRecurrentPPO(RecurrentPPO):
    """``RecurrentPPO`` that learns from the rows of robots that acted, and no others; see ``MaskedPPO``."""

    leaves_out_waiting: ClassVar[bool] = True

    def _setup_model(self) -> None:
        super()._setup_model()
        kind: Any = MaskedRecurrentRolloutBuffer
        if isinstance(self.observation_space, Dict):
            kind = MaskedRecurrentDictRolloutBuffer
        self.rollout_buffer = kind(
            self.n_steps,
            self.observation_space,
            self.action_space,
            self.rollout_buffer.hidden_state_shape,  # type: ignore[attr-defined]
            self.device,
            gamma=self.gamma,
            gae_lambda=self.gae_lambda,
            n_envs=self.n_envs,
        )

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Let the buffer read the mask of ``env``, then collect as ``RecurrentPPO`` does."""
        read_mask_of(env, rollout_buffer)
        return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)


class MaskedRecurrentRolloutBuffer(RecurrentRolloutBuffer):
    """``MaskedRolloutBuffer`` with the memories of a recurrent policy.

    Where a slot waits, its rows are cut out: a sequence before ends with the agent's episode, and the next begins with
    one.

    Attributes:
        acted: Rows that are experience, ``(buffer_size, n_envs)``.
        team: The source of the mask, see ``read_mask_of``.
        slot_starts: 1 at the first row of each slot among the rows that acted, else 0, ``(n_rows, 1)``.
    """

    acted: Flags
    team: Team | None = None
    slot_starts: NDArray[Any]

    def reset(self) -> None:
        """Forget everything."""
        self.acted = np.zeros((self.buffer_size, self.n_envs), np.bool_)
        super().reset()  # type: ignore[no-untyped-call]

    def add(self, *args: Any, **kwargs: Any) -> None:
        """Add a row for each slot; see ``RecurrentRolloutBuffer.add``."""
        self.acted[self.pos] = acted_of(self.team)
        super().add(*args, **kwargs)

    def get(self, batch_size: int | None = None) -> Generator[Any, None, None]:
        """Return minibatches of sequences of the rows that are experience."""
        if not self.generator_ready:
            _prepare(self)
            keep_experience(self, ("observations",))
        return super(MaskedRecurrentRolloutBuffer, rows_of(self)).get(even_parts(len(self.values), batch_size))

    def _get_samples(self, batch_inds: Any, env_change: Any, env: Any = None) -> Any:  # type: ignore[override]
        return super()._get_samples(batch_inds, self.slot_starts, env)


class MaskedRecurrentDictRolloutBuffer(RecurrentDictRolloutBuffer):
    """``MaskedRecurrentRolloutBuffer`` for dict observations.

    Attributes:
        acted: Rows that are experience, ``(buffer_size, n_envs)``.
        team: The source of the mask, see ``read_mask_of``.
        slot_starts: 1 at the first row of each slot among the rows that acted, else 0, ``(n_rows, 1)``.
    """

    acted: Flags
    team: Team | None = None
    slot_starts: NDArray[Any]

    def reset(self) -> None:
        """Forget everything."""
        self.acted = np.zeros((self.buffer_size, self.n_envs), np.bool_)
        super().reset()  # type: ignore[no-untyped-call]

    def add(self, *args: Any, **kwargs: Any) -> None:
        """Add a row for each slot; see ``RecurrentDictRolloutBuffer.add``."""
        self.acted[self.pos] = acted_of(self.team)
        super().add(*args, **kwargs)

    def get(self, batch_size: int | None = None) -> Generator[Any, None, None]:
        """Return minibatches of sequences of the rows that are experience."""
        if not self.generator_ready:
            _prepare(self)
            self.observations = {key: keep_experience_in(self, values) for key, values in self.observations.items()}
        return super(MaskedRecurrentDictRolloutBuffer, rows_of(self)).get(even_parts(len(self.values), batch_size))

    def _get_samples(self, batch_inds: Any, env_change: Any, env: Any = None) -> Any:  # type: ignore[override]
        return super()._get_samples(batch_inds, self.slot_starts, env)


def _prepare(buffer: Any) -> None:
    """Cut waiting rows out of everything but the observations, and note where slots begin among what is left."""
    for name in MEMORIES:
        setattr(buffer, name, getattr(buffer, name).swapaxes(1, 2))
    slots = np.broadcast_to(np.arange(buffer.n_envs), buffer.acted.shape)
    slot_of_row = keep_experience_in(buffer, slots)
    keep_experience(buffer, (*COLUMNS, *MEMORIES, "episode_starts"))
    buffer.slot_starts = np.diff(slot_of_row, axis=0, prepend=-1).astype(bool).astype(np.float32)
    buffer.generator_ready = True
