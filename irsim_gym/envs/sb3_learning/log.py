"""Outcomes and reward terms of the episodes of a training, in the logger of Stable-Baselines3."""

from collections import deque
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.infos import reward_keys
from irsim_gym.envs.sb3.base import NativeVecEnv
from irsim_gym.envs.sb3.mixture import MixtureVecEnv
from irsim_gym.tasks import Outcome

OUTCOMES = tuple(outcome for outcome in Outcome if outcome != Outcome.RUNNING)
PREFIX = "reward/"


class LogCallback(BaseCallback):
    """Logs how episodes end and what each reward term pays.

    It goes with any algorithm, and with all environments of this package, also in worker processes:
    ``model.learn(100_000, callback=LogCallback())``. The logger of the model, and so TensorBoard if
    ``tensorboard_log`` is set, gets for the latest episodes

    - ``outcome/success``, ``outcome/collision`` and so on: the shares of episodes that ended so;
    - ``reward/progress`` and so on: the mean sum of each reward term over an episode, before any normalisation.

    Args:
        window: How many of the latest episodes count.

    Raises:
        IrsimGymError: ``window`` is less than 1.
    """

    def __init__(self, *, window: int = 100) -> None:
        super().__init__()
        if window < 1:
            raise IrsimGymError(f"LogCallback: window must be at least 1, got {window}")
        self._latest: deque[tuple[int, Floats]] = deque(maxlen=window)  # outcomes, and what each term paid
        self._sums: Floats = np.zeros((0, 0))
        self._keys: tuple[str, ...] = ()

    def _on_training_start(self) -> None:
        env = self.training_env
        if not env.has_attr("choose_level"):
            raise IrsimGymError(f"LogCallback: {env.unwrapped} is no environment of irsim_gym")
        if isinstance(env.unwrapped, NativeVecEnv | MixtureVecEnv):
            self._name_terms(reward_keys(env.unwrapped.reward_names))

    def _on_step(self) -> bool:
        dones: Flags = self.locals["dones"]
        infos: list[dict[str, Any]] = self.locals["infos"]
        if not self._keys:  # single environments: each info holds the terms
            self._name_terms(tuple(key for key in infos[0] if key.startswith(PREFIX)))
        ended = dones.nonzero()[0]
        self._add(infos, ended)
        finished = [slot for slot in ended.tolist() if infos[slot].get("outcome", Outcome.RUNNING) != Outcome.RUNNING]
        for slot in finished:
            self._latest.append((infos[slot]["outcome"], self._sums[slot].copy()))
        self._sums[ended] = 0.0
        if finished:
            self._record()
        return True

    def _name_terms(self, keys: tuple[str, ...]) -> None:
        self._keys = keys
        self._sums = np.zeros((self.training_env.num_envs, len(keys)))

    def _add(self, infos: list[dict[str, Any]], ended: Ints) -> None:
        """Add what the terms paid in the latest step."""
        env = self.training_env.unwrapped
        if not isinstance(env, NativeVecEnv | MixtureVecEnv):
            self._sums += [[info[key] for key in self._keys] for info in infos]
            return
        paid = env.reward_terms()
        for slot in ended.tolist():  # the world may have begun its next episode already
            paid[slot] = [infos[slot].get(key, 0.0) for key in self._keys]
        self._sums += paid

    def _record(self) -> None:
        outcomes, sums = zip(*self._latest, strict=True)
        for outcome in OUTCOMES:
            self.logger.record(f"outcome/{outcome.name.lower()}", outcomes.count(outcome) / len(outcomes))
        for key, mean in zip(self._keys, np.mean(sums, axis=0).tolist(), strict=True):
            self.logger.record(key, mean)
