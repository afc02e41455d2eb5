"""Worlds as PyTorch's tensors, without copies: for training loops of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import torch
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from torch import Tensor

from irsim_gym.base.arraytypes import Flags, Ints, Rays
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.envs.parts.observations import on_each
from irsim_gym.envs.teams.batch import Batch

TensorObservation: TypeAlias = Tensor | dict[str, Tensor]


def torch_rows(env: WorldVectorEnv | Batch, device: torch.device | str | None = None) -> TorchRows:
    """Return the arrays of an environment as tensors, and step it by them.

    Without a device, tensors are views of the memory that the worlds write to: nothing is copied, and each step, reset
    and restart overwrites them. With a device, they are fresh copies there.

    Args:
        env: What ``make_vec`` (with ``autoreset_mode="SameStep"`` or ``"Disabled"``) or ``make_batch`` made. From then
            on it is reset and stepped by the rows alone.
        device: Where tensors are copied to, such as ``"cuda"``; None for views.

    Raises:
        TypeError: It is another environment.
        IrsimGymError: It begins episodes in the step after their end, or its observations lie apart in memory.
    """
    return TorchRows(env, None if device is None else torch.device(device))


class TorchRows:
    """What steps gave, as tensors ``(n_worlds, ...)`` of ``make_vec``, ``(n_worlds, n_agents, ...)`` of ``make_batch``.

    Agents end, wait and begin again as ``BatchStep`` describes.

    Args:
        env: The batch to step.
        device: Where tensors are copied to; None for views.

    Attributes:
        batch: The worlds, with the axis of the agents.
        device: Where the tensors are; None where they are views.
        observation: What the agents perceive now, float32, shape ``(n_worlds, ...)``, or a dict of such tensors. Do not
            write to it: observations such as earlier scans are made from it. Ignore rows of agents that wait for their
            world.
        final_observation: In rows that ended in this step, the observation before any restart, likewise.
        reward: Reward of the step, float32; 0 where ``acted`` is False.
        cost: Cost of the step, likewise, also of the last step of an episode; 0 for tasks without ``near``.
        terminated: The agent's task has ended in this very step.
        truncated: The agent's episode was cut in this very step.
        acted: The agent was under way when the step began: its row is experience.
        live: The agent is under way now.
        began: ``observation`` is the first of an episode.
        episodes: Episodes that ended in this step, as fresh NumPy arrays ``(n_ended,)``: ``world``, ``agent``,
            ``episode_return`` and the infos, such as ``is_success``.

    Raises:
        IrsimGymError: The parts of an observation lie apart in memory.
    """

    observation: TensorObservation
    final_observation: TensorObservation

    def __init__(self, env: WorldVectorEnv | Batch, device: torch.device | None) -> None:
        self._env, self.device = env, device
        self.batch = _batch_of(env)
        place: Any = ... if isinstance(env, Batch) else (slice(None), 0)
        worlds, shape = self.batch.worlds, (self.batch.n_worlds, self.batch.n_agents)
        self._paid: Rays = np.zeros((2, *shape), np.float32)  # rewards, costs
        self._flags: dict[str, Flags] = {name: np.zeros(shape, np.bool_) for name in FLAGS}
        seen = [worlds.layout.shared(part, place) for part in (worlds.episodes.view.percepts, self.batch.last_seen)]
        self._observation, self._final = (on_each(part, torch.from_numpy) for part in seen)
        self._action_shape = (*self._paid[0][place].shape, *(self.batch.action_space.shape or ()))
        self._shown_paid = [torch.from_numpy(part[place]) for part in self._paid]
        self._marks = {name: torch.from_numpy(flags[place]) for name, flags in self._flags.items()}
        self.episodes: dict[str, NDArray[Any]] = {}
        self.final_observation = self._shown(self._final)
        self._note(np.zeros(shape), dict.fromkeys(FLAGS, np.zeros(shape, np.bool_)))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.batch.worlds.summary}, {self.device or 'views'}>"

    def reset(self, seed: Any = None, options: Mapping[str, Any] | None = None) -> None:
        """Begin an episode in every world.

        Args:
            seed: As in the ``reset`` of the environment itself.
            options: Likewise.
        """
        chosen = np.arange(self.batch.n_worlds)
        if isinstance(self._env, Batch):
            self._env.reset(seed, options)
        else:
            self._env.reset(seed=seed, options=dict(options or {}))
            mask = (options or {}).get("reset_mask")
            chosen = chosen if mask is None else np.flatnonzero(mask)
        self._begun(self.batch.note_beginnings(chosen))

    def restart(self, worlds: Tensor | Ints) -> None:
        """Begin the next level in some worlds. Use it where worlds do not restart by themselves.

        Args:
            worlds: Indices of the worlds, shape ``(n,)``.

        Raises:
            ResetNeeded: One of the worlds has not begun an episode.
            ValueError: These are not indices, but a mask, for example.
        """
        self._begun(self.batch.restart(np.asarray(worlds)).began)

    def step(self, actions: Tensor) -> None:
        """Advance all worlds by one step; agents and worlds restart as the environment says.

        Args:
            actions: In [-1, 1], ``(n_worlds, n_components)`` for ``make_vec`` and ``(n_worlds, n_agents,
                n_components)`` for ``make_batch``; discrete: whole numbers, without the last axis.

        Raises:
            ResetNeeded: A world has not begun an episode.
            ValueError: The actions have a wrong shape or are not finite.
        """
        batch, rows = self.batch, actions.detach().cpu().numpy()
        if rows.shape != self._action_shape:
            raise ValueError(f"actions must have shape {self._action_shape}, got {rows.shape}")
        if batch is not self._env:
            rows = rows[:, None]
        reward, terminated, truncated, acted = batch.advance(rows)
        ended, cost = terminated | truncated, acted * batch.worlds.episodes.view.infos.get("cost", 0)
        self.episodes = self._ended(ended)
        began = batch.begin_again(ended)
        if ended.any():
            self.final_observation = self._shown(self._final)
        flags = {"terminated": terminated, "truncated": truncated, "acted": acted, "live": batch.live, "began": began}
        self._note(np.stack((reward, cost)), flags)

    def _begun(self, began: Flags) -> None:
        """Show the beginnings of a reset, in which nobody has acted."""
        none = np.zeros_like(began)
        self.episodes = self._ended(none)
        flags = {"terminated": none, "truncated": none, "acted": none, "live": self.batch.live, "began": began}
        self._note(np.zeros(began.shape), flags)

    def _ended(self, ended: Flags) -> dict[str, NDArray[Any]]:
        """Return the infos of agents whose episodes have ended, before any restart."""
        world, agent = ended.nonzero()
        infos = {name: column[world, agent] for name, column in self.batch.worlds.episodes.view.infos.items()}
        return {"world": world, "agent": agent, "episode_return": self.batch.returns[world, agent], **infos}

    def _note(self, paid: NDArray[Any], flags: Mapping[str, Flags]) -> None:
        """Write what a step gave into the arrays behind the tensors, and show all."""
        self._paid[...] = paid
        for name, values in flags.items():
            self._flags[name][...] = values
        self.observation = self._shown(self._observation)
        self.reward, self.cost = (self._moved(part) for part in self._shown_paid)
        self.terminated, self.truncated, self.acted, self.live, self.began = (
            self._moved(self._marks[name]) for name in FLAGS
        )

    def _shown(self, seen: TensorObservation) -> TensorObservation:
        shown: TensorObservation = on_each(seen, self._moved)
        return shown

    def _moved(self, tensor: Tensor) -> Tensor:
        return tensor if self.device is None else tensor.to(self.device, copy=True)


FLAGS = ("terminated", "truncated", "acted", "live", "began")


def _batch_of(env: WorldVectorEnv | Batch) -> Batch:
    if isinstance(env, Batch):
        return env
    if not isinstance(env, WorldVectorEnv):
        raise TypeError(f"torch_rows takes what make_vec or make_batch made, without wrappers, got {env!r}")
    if env.autoreset_mode is AutoresetMode.NEXT_STEP:
        raise IrsimGymError("torch_rows needs make_vec(..., autoreset_mode='SameStep') or 'Disabled', got 'NextStep'")
    return Batch(env.worlds, autoreset=env.autoreset_mode is AutoresetMode.SAME_STEP)
