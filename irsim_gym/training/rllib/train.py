"""Training with Ray RLlib. Checkpoints, logs and policies are the same as with Stable-Baselines3."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ray.rllib.algorithms.algorithm import Algorithm
from ray.rllib.core import DEFAULT_MODULE_ID
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.requests.interruption import stopped_at_end, stopped_early
from irsim_gym.evaluation.saved_policies.checkpoint_files import RunProgress, remove_partial
from irsim_gym.rllib import CPU_SECONDS, SUCCESS
from irsim_gym.training.rllib.config import make_config
from irsim_gym.training.rllib.module import module_state
from irsim_gym.training.rllib.ray_session import ray_session
from irsim_gym.training.runs import checkpoint as files
from irsim_gym.training.runs.monitoring import LOG_ROWS, Clock, StopRequest, TrainingBar, tensorboard_logger
from irsim_gym.training.settings.engines import Engine
from irsim_gym.training.settings.run import Run, Settings

STALLED_S = 900.0
"""Time without an answer of any worker after which a training fails [s]."""
SAMPLED = "env_runners"
"""Key of the workers' metrics in RLlib's results."""


def learn(
    run: Run,
    settings: Settings,
    model: BaseAlgorithm,
    progress: RunProgress,
    console: Console,
    on_checkpoint: Callable[[Run], object] | None,
    newest: Path | None,
    address: str | None,
) -> None:
    """Learn until the end of the run or until a signal, and write a checkpoint in both cases.

    Args:
        settings: Settings of the run, with an engine.
        model: Model with the initial weights, which gets the final ones.
        progress: Progress of the run, which this updates.
        on_checkpoint: Function that is called after each checkpoint but the last.
        newest: Checkpoint to resume from; None for a new run.
        address: Address of a Ray cluster; None for this machine.

    Raises:
        TrainingInterruptedError: If Ctrl-C or SIGTERM stops the training. A checkpoint is on disk.
        IrsimGymError: If there is no such cluster, or no worker answers.
    """
    assert settings.engine is not None
    engine = settings.engine.chosen(settings.hyperparameters.n_envs)
    remove_partial(run.checkpoints)
    with ray_session(address, 1 + (engine.workers or 0) + (engine.learner_gpus or 0)):
        algorithm = _algorithm(settings, engine, model, progress, newest)
        try:
            learning = Learning(run, settings, algorithm, model, progress, console)
            with StopRequest().listening() as stop:
                learning.learn(stop, on_checkpoint)
        finally:
            algorithm.stop()
            with suppress(OSError):
                Path(algorithm.logdir).rmdir()  # RLlib makes an empty folder in the user's home


def _algorithm(
    settings: Settings, engine: Engine, model: BaseAlgorithm, progress: RunProgress, newest: Path | None
) -> Algorithm:
    """Return RLlib's algorithm, restored from a checkpoint if there is one."""
    config = make_config(settings, engine, model, progress.steps)
    try:
        algorithm = config.build_algo()
    except IndexError as error:  # RLlib reads the spaces from the first worker
        raise IrsimGymError("no worker of RLlib could start; Ray's logs (/tmp/ray) say why") from error
    if newest is not None:
        algorithm.learner_group.set_state(files.load_state(newest)["learner"])
        algorithm.env_runner_group.sync_weights(from_worker_or_learner_group=algorithm.learner_group)
    return algorithm


@dataclass
class Learning:
    """A training with RLlib.

    Args:
        algorithm: RLlib's algorithm.
        model: Model of Stable-Baselines3, which saves the weights.
        progress: Progress of the run, which the training updates.
    """

    run: Run
    settings: Settings
    algorithm: Algorithm
    model: BaseAlgorithm
    progress: RunProgress
    console: Console

    def __post_init__(self) -> None:
        wanted = self.settings.hyperparameters
        self._before = (self.progress.steps, self.progress.cpu_seconds)
        self._clock = Clock(self.progress.training_seconds, self.progress.cpu_seconds)
        self._bar = TrainingBar(self.progress, wanted.n_timesteps, self.console)
        self._success: float | None = None
        self._sampling_seconds = 0.0
        self._logger = tensorboard_logger(self.run)

    def learn(self, stop: StopRequest, on_checkpoint: Callable[[Run], object] | None) -> None:
        """Learn until all steps are taken, or a signal requests a stop.

        Raises:
            TrainingInterruptedError: If a signal requests a stop.
            IrsimGymError: If no worker answers.
        """
        wanted, progress = self.settings.hyperparameters, self.progress
        following = (progress.steps // wanted.checkpoint_every + 1) * wanted.checkpoint_every
        self._bar.start()
        self._clock.start()
        try:
            while progress.steps < wanted.n_timesteps:
                self._iterate()
                is_due = following <= progress.steps < wanted.n_timesteps
                if stop.signal is not None or is_due:
                    self._save()
                    following = (progress.steps // wanted.checkpoint_every + 1) * wanted.checkpoint_every
                if stop.signal is not None and progress.steps < wanted.n_timesteps:
                    raise stopped_early(progress.steps, stop.signal)
                if is_due and on_checkpoint is not None:
                    self._clock.stop()
                    on_checkpoint(self.run)
                    self._clock.start()
        finally:
            self._clock.stop()
            self._bar.stop()
            self._logger.close()
        self._write()
        self._bar.print_line(progress, self._success)
        files.export_policy(self.run.policy, self.model)
        if stop.signal is not None:
            raise stopped_at_end(progress.steps, stop.signal)

    def _iterate(self) -> None:
        """Run iterations until new steps arrive. Workers that restart may deliver none for a while.

        Raises:
            IrsimGymError: If no worker answers for ``STALLED_S`` seconds.
        """
        begun, before = time.monotonic(), self.progress.steps
        while self.progress.steps == before:
            self._update(self.algorithm.train())
            if time.monotonic() - begun > STALLED_S:
                raise IrsimGymError(f"no worker of RLlib has answered for {STALLED_S:.0f} s; the checkpoint is kept")

    def _update(self, result: dict[str, Any]) -> None:
        """Update the progress, the log and the bar with the results of an iteration."""
        progress, sampled = self.progress, result.get(SAMPLED, {})
        progress.steps = self._before[0] + int(sampled.get("num_env_steps_sampled_lifetime", 0))
        self._sampling_seconds = float(sampled.get(CPU_SECONDS, self._sampling_seconds))
        progress.training_seconds, own = self._clock.read()
        is_apart = bool(self.algorithm.config.num_env_runners)
        progress.cpu_seconds = own + (self._sampling_seconds if is_apart else 0.0)
        figures = {name: sampled.get(name) for name in (SUCCESS, "episode_return_mean", "episode_len_mean")}
        success = figures[SUCCESS]
        self._success = self._success if success is None or success != success else float(success)
        self._log(result, figures)
        self._bar.show(progress, self._success)

    def _log(self, result: dict[str, Any], figures: dict[str, Any]) -> None:
        """Log the results to TensorBoard, and add a row to the training log if it is due."""
        progress, total = self.progress, self.settings.hyperparameters.n_timesteps
        of_learner = result.get("learners", {}).get(DEFAULT_MODULE_ID, {})
        shown = {f"train/{name}": value for name, value in of_learner.items() if not isinstance(value, dict)}
        shown |= {f"rollout/{name}": value for name, value in figures.items() if value is not None}
        for name, value in shown.items():
            self._logger.record(name, float(value))
        self._logger.dump(progress.steps)
        logged = progress.history[-1]["steps"] if progress.history else 0
        if progress.steps - logged < total / LOG_ROWS:
            return
        row = {"steps": progress.steps, "training_seconds": progress.training_seconds}
        names = {"episode_return": "episode_return_mean", "episode_steps": "episode_len_mean"}
        row |= {name: float(figures[key]) for name, key in names.items() if figures[key] is not None}
        if self._success is not None:
            row["success"] = self._success
        progress.history.append(row)

    def _save(self) -> None:
        self._clock.stop()
        self._write()
        self._bar.print_line(self.progress, self._success)
        self._clock.start()

    def _write(self) -> None:
        """Write a checkpoint: the policy in the format of Stable-Baselines3, and RLlib's state for resuming."""
        weights = self.algorithm.learner_group.get_weights()[DEFAULT_MODULE_ID]
        self.model.policy.load_state_dict(module_state(weights))
        self.model.num_timesteps = self.progress.steps
        state = {"learner": self.algorithm.learner_group.get_state()}
        files.write_checkpoint(self.run.checkpoints, self.model, self.progress, state)
