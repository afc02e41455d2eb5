"""Outcomes and reward terms of the episodes of a training, for TensorBoard, Weights & Biases and MLflow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.envs.infos import reward_keys
from irsim_gym.envs.sb3_base import NativeVecEnv
from irsim_gym.envs.sb3_mixture import MixtureVecEnv
from irsim_gym.envs.sb3_trackers import Tracker, find_tracker
from irsim_gym.errors import IrsimGymError
from irsim_gym.tasks import Outcome

OUTCOMES = tuple(outcome for outcome in Outcome if outcome != Outcome.RUNNING)
PREFIX = "reward/"


class LogCallback(BaseCallback):
    """Logs how episodes end and what each reward term pays, and sends the log to Weights & Biases or MLflow.

    It goes with any algorithm, and with all environments of this package, also in worker processes:
    ``model.learn(100_000, callback=LogCallback("wandb", project="robots"))``. The logger of the model, and so
    TensorBoard if ``tensorboard_log`` is set, gets for the latest episodes

    - ``outcome/success``, ``outcome/collision`` and so on: the shares of episodes that ended so;
    - ``reward/progress`` and so on: the mean sum of each reward term over an episode, before any normalisation.

    A tracking service gets all numbers of the logger, ``rollout/success_rate`` and those of the algorithm included.

    Args:
        to: ``"wandb"``, ``"mlflow"``, both in a list, or nothing. A run that is under way there is used; otherwise
            one is begun, and finished when the training ends.
        project: W&B's project, or MLflow's experiment.
        name: Name of the run.
        config: Settings to store with the run.
        run_ids: Ids of runs to continue, by service.
        window: How many of the latest episodes count.
        **settings: More arguments of ``wandb.init`` or ``mlflow.start_run``; only if there is one service.

    Attributes:
        run_ids: The ids of the runs, by service.

    Raises:
        IrsimGymError: There is no such service, or its package is not installed.
    """

    def __init__(
        self,
        to: str | Sequence[str] = (),
        *,
        project: str | None = None,
        name: str | None = None,
        config: Mapping[str, Any] | None = None,
        run_ids: Mapping[str, str] | None = None,
        window: int = 100,
        **settings: Any,
    ) -> None:
        super().__init__()
        services = [to] if isinstance(to, str) else list(to)
        if settings and len(services) != 1:
            raise IrsimGymError(
                f"LogCallback: {', '.join(settings)}: further arguments need exactly one service in 'to'"
            )
        self._kinds = {service: find_tracker(service) for service in services}
        self._how = (project, name, config or {}, settings)
        self.run_ids = dict(run_ids or {})
        self._trackers: list[Tracker] = []
        self._episodes = _LatestEpisodes(window)
        self._sums: Floats = np.zeros((0, 0))
        self._keys: tuple[str, ...] = ()

    def _on_training_start(self) -> None:
        env = self.training_env
        if not env.has_attr("choose_level"):
            raise IrsimGymError(f"LogCallback: {env.unwrapped} is no environment of irsim_gym")
        if isinstance(env.unwrapped, NativeVecEnv | MixtureVecEnv):
            self._name_terms(reward_keys(env.unwrapped.reward_names))
        self.begin()
        self.logger.output_formats += [one for one in self._trackers if one not in self.logger.output_formats]

    def _on_step(self) -> bool:
        dones: Flags = self.locals["dones"]
        infos: list[dict[str, Any]] = self.locals["infos"]
        if not self._keys:  # single environments: each info holds the terms
            self._name_terms(tuple(key for key in infos[0] if key.startswith(PREFIX)))
        ended = dones.nonzero()[0]
        self._add(infos, ended)
        finished = [slot for slot in ended.tolist() if infos[slot].get("outcome", Outcome.RUNNING) != Outcome.RUNNING]
        for slot in finished:
            self._episodes.add(infos[slot]["outcome"], self._sums[slot])
        self._sums[ended] = 0.0
        if finished:
            self._record()
        return True

    def _on_training_end(self) -> None:
        self.close()

    def begin(self) -> None:
        """Begin the runs at the services, as the beginning of a training does. May be called twice."""
        project, name, config, settings = self._how
        for service, kind in list(self._kinds.items())[len(self._trackers) :]:
            tracker = kind(project, name, config, self.run_ids.get(service), settings)
            self.run_ids[service] = tracker.run_id
            self._trackers.append(tracker)

    def close(self) -> None:
        """Finish the runs that were begun here, as the end of a training does. May be called twice."""
        for tracker in self._trackers:
            if hasattr(self, "model") and tracker in self.logger.output_formats:
                self.logger.output_formats.remove(tracker)
            tracker.close()
        self._trackers.clear()

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
        shares, means = self._episodes.shares(), self._episodes.means()
        for outcome, share in zip(OUTCOMES, shares, strict=True):
            self.logger.record(f"outcome/{outcome.name.lower()}", share)
        for key, mean in zip(self._keys, means, strict=True):
            self.logger.record(key, mean)


class _LatestEpisodes:
    """Outcomes and sums of reward terms of the latest episodes.

    Args:
        window: How many.
    """

    def __init__(self, window: int) -> None:
        if window < 1:
            raise IrsimGymError(f"LogCallback: window must be at least 1, got {window}")
        self._window = window
        self._outcomes: Ints = np.zeros(window, np.int64)
        self._sums: Floats | None = None
        self._count = 0

    def add(self, outcome: int, sums: Floats) -> None:
        """Add an episode."""
        if self._sums is None:
            self._sums = np.zeros((self._window, len(sums)))
        row = self._count % self._window
        self._outcomes[row], self._sums[row] = outcome, sums
        self._count += 1

    def shares(self) -> list[float]:
        """Return the share of each of ``OUTCOMES``."""
        counts = np.bincount(self._outcomes[: self._count], minlength=len(Outcome))
        return [float(counts[outcome]) / min(self._count, self._window) for outcome in OUTCOMES]

    def means(self) -> list[float]:
        """Return the mean sum of each reward term."""
        assert self._sums is not None
        found: list[float] = self._sums[: self._count].mean(axis=0).tolist()
        return found
