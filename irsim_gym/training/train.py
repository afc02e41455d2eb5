"""Training with Stable-Baselines3, interruptible at any moment."""

from __future__ import annotations

import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import torch
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import remove_leftovers, write_bytes, write_csv
from irsim_gym.training import checkpoint as files
from irsim_gym.training.environment import compile_kernels
from irsim_gym.training.models import new_model, restored_model
from irsim_gym.training.run import Run, Settings
from irsim_gym.training.watch import StopLearningError, StopRequest, Watch

WRITTEN = ("config.json", "training.csv", files.NORMALIZATION, "policy.zip", "curve.json", "curve.csv", "curve.png")
"""Files in a run's folder that are written under another name first."""
LOG_COLUMNS = ("steps", "training_seconds", "episode_return", "episode_steps", "success", "idle_share")


class TrainingInterruptedError(IrsimGymError):
    """A run was stopped by a signal; its checkpoint is on disk.

    Attributes:
        signal: Number of the signal.
    """

    def __init__(self, message: str, number: int) -> None:
        super().__init__(message)
        self.signal = number


@contextmanager
def ctrl_c_told(message: str) -> Iterator[None]:
    """Turn Ctrl-C, where nothing else listens to it, into an error with this message.

    Raises:
        TrainingInterruptedError: Ctrl-C.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise TrainingInterruptedError(message, signal.SIGINT) from None


def train(settings: Settings, folder: Path, *, resume: bool = False, console: Console | None = None) -> Run:
    """Train an agent and leave checkpoints, logs and the final policy in ``folder``.

    A finished run is left as it is. A run that was interrupted goes on from its newest checkpoint with ``resume``;
    for PPO the result equals that of a run that was never interrupted.

    Raises:
        IrsimGymError: The folder holds another run, or one that should be resumed.
        TrainingInterruptedError: Ctrl-C or SIGTERM; a checkpoint was written.
    """
    run, screen = Run(folder), console or Console(stderr=True)
    _open(run, settings, resume)
    if run.finished():
        return run
    torch.set_num_threads(settings.hyperparameters.torch_threads)
    compile_kernels(settings)
    newest = files.newest_checkpoint(run.checkpoints)
    model, progress = (new_model(settings), files.Progress()) if newest is None else restored_model(settings, newest)
    try:
        _learn(run, settings, model, progress, screen)
    finally:
        _write_log(run, progress)
        env = model.get_env()
        if env is not None:
            env.close()
    return run


def _open(run: Run, settings: Settings, resume: bool) -> None:
    """Begin a run, or make sure that the one in the folder is the same; what it left half written goes."""
    if not run.exists():
        run.begin(settings)
    elif run.settings() != settings:
        raise IrsimGymError(f"{run.folder} holds a run with other settings; name another folder")
    elif not resume and not run.finished() and files.list_checkpoints(run.checkpoints):
        raise IrsimGymError(f"{run.folder} holds an unfinished run; go on with it by --resume or name another folder")
    for name in WRITTEN:
        remove_leftovers(run.folder / name)


def _learn(run: Run, settings: Settings, model: BaseAlgorithm, progress: files.Progress, console: Console) -> None:
    """Learn to the end, or to a signal; either way leave a checkpoint."""
    wanted, stop = settings.hyperparameters, StopRequest()
    for partial in run.checkpoints.glob(f"{files.PARTIAL}*"):
        shutil.rmtree(partial)
    model.set_logger(Logger(str(run.folder), [TensorBoardOutputFormat(str(run.folder / "tensorboard"))]))

    def save() -> Path:
        return files.save_checkpoint(run.checkpoints, model, progress)

    watch = Watch(progress, wanted.n_timesteps, wanted.checkpoint_every, save, stop, console)
    with stop.listening():
        try:
            left = wanted.n_timesteps - model.num_timesteps
            model.learn(max(left, 0), callback=watch, reset_num_timesteps=False)
            watch.note()
        except StopLearningError:
            assert stop.signal is not None
            raise TrainingInterruptedError(
                f"stopped after {progress.steps:,} steps; nothing is lost", stop.signal
            ) from None
        finally:
            watch.finish()
            model.logger.close()
        last = save()
        watch.tell()
        if (last / files.NORMALIZATION).is_file():
            write_bytes(run.folder / files.NORMALIZATION, (last / files.NORMALIZATION).read_bytes())
        files.export_policy(run.policy, model)
    if stop.signal is not None:
        raise TrainingInterruptedError(f"stopped after all {progress.steps:,} steps; the run is finished", stop.signal)


def _write_log(run: Run, progress: files.Progress) -> None:
    rows = ({name: row.get(name, "") for name in LOG_COLUMNS} for row in progress.history)
    write_csv(run.folder / "training.csv", LOG_COLUMNS, rows)
