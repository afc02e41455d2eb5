"""Training with Stable-Baselines3, interruptible at any moment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import torch
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import remove_leftovers, write_bytes, write_csv
from irsim_gym.extras import require
from irsim_gym.sb3 import LogCallback
from irsim_gym.training import checkpoint as files
from irsim_gym.training.checkpoint_files import (
    NORMALIZATION,
    RunProgress,
    list_checkpoints,
    load_progress,
    newest_checkpoint,
    remove_partial,
)
from irsim_gym.training.cloning import clone_behavior
from irsim_gym.training.engine_checks import check_engine
from irsim_gym.training.environment import compile_kernels
from irsim_gym.training.fine_tuning import copy_weights
from irsim_gym.training.folders import check_replaceable, setting_differences
from irsim_gym.training.interruption import stopped_at_end, stopped_early
from irsim_gym.training.models import curriculum_of, new_model, resolve_device, restored_model
from irsim_gym.training.monitoring import StopLearningError, StopRequest, TrainingMonitor, tensorboard_logger
from irsim_gym.training.ray_session import prepare
from irsim_gym.training.run import TRACKING, Run, Settings
from irsim_gym.training.snapshot import Snapshot, differences, listed
from irsim_gym.training.tracking import begin_log, log_of

WRITTEN = (
    *("config.json", "training.csv", NORMALIZATION, "policy.zip", "curve.json", "curve.csv", "curve.png"),
    TRACKING,
)
"""Files in a run's folder that are written under another name first."""
LOG_COLUMNS = ("steps", "training_seconds", "episode_return", "episode_steps", "success", "idle_share")


def train(
    settings: Settings,
    folder: Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    device: str | None = None,
    console: Console | None = None,
    on_checkpoint: Callable[[Run], object] | None = None,
    address: str | None = None,
    log: Sequence[str] = (),
) -> Run:
    """Train an agent and leave checkpoints, logs and the final policy in ``folder``.

    A finished run is not changed. With ``resume``, an interrupted run continues from its newest checkpoint;
    for PPO the result equals that of a run that was never interrupted. It uses its own copy of the scenario,
    and says so where the scenario has changed. Nothing is written before the model is made.

    Args:
        settings: What is trained.
        folder: The run's folder.
        resume: Go on with the run in the folder.
        overwrite: Replace the run in the folder.
        device: Where the networks are this time; None for what the settings say.
        console: Where progress is shown; None for standard error.
        on_checkpoint: Called after each checkpoint but the last, while the clock of the training stands. It changes
            nothing in what is learned; what it raises ends the run there, unfinished.
        address: A Ray cluster, for a run with RLlib; None for this machine.
        log: Where the log goes beside TensorBoard: ``"wandb"``, ``"mlflow"``.

    Raises:
        IrsimGymError: The folder holds another run, or one that should be resumed, or is a file.
        TrainingInterruptedError: Ctrl-C or SIGTERM; a checkpoint was written.
    """
    run, screen = Run(folder), console or Console(stderr=True)
    if run.folder.is_file():
        raise IrsimGymError(f"{run.folder} is a file; choose a folder with --out")
    now = settings.snapshot()
    if overwrite:
        check_replaceable(run)
    elif run.exists():
        _check(run, settings, now, resume, screen)
    goes_on = run.exists() and not overwrite
    if goes_on and run.finished():
        _tidy(run)
        return run
    used = run.own_settings() if goes_on else settings
    newest = newest_checkpoint(run.checkpoints) if goes_on else None
    _check_engine(used, address, log)
    logged = log_of(run, settings, log, goes_on=goes_on)
    model, progress = _model(used, newest, device, screen)
    _begin(run, settings, now, goes_on=goes_on)
    try:
        _learn_with(used, address, logged)(run, used, model, progress, newest, screen, on_checkpoint)
    finally:
        logged.close()
        _write_log(run, progress)
        _close(model)
    return run


def _close(model: BaseAlgorithm) -> None:
    env = model.get_env()
    if env is not None:
        env.close()


def _begin(run: Run, settings: Settings, now: Snapshot, *, goes_on: bool) -> None:
    """Write down the settings, in place of what another run left in the folder, unless the run goes on."""
    if run.exists() and not goes_on:
        run.clear()
    if not goes_on:
        run.begin(settings, now)
    _tidy(run)


def _learn_with(settings: Settings, address: str | None, logged: LogCallback) -> Callable[..., None]:
    """Return what learns, with the engine of a run."""
    if settings.engine is None:
        return partial(_learn, logged=logged)
    from irsim_gym.training.rllib_train import learn

    return partial(learn, address=address)


def _check_engine(settings: Settings, address: str | None, log: Sequence[str]) -> None:
    """Make sure that the engine can train this, and prepare what has to come before Ray is imported."""
    check_engine(settings)
    if settings.engine is not None:
        if log:
            raise IrsimGymError("--log is for Stable-Baselines3: with --engine rllib read training.csv and the curve")
        require("rllib", "--engine rllib")
        prepare(address)


def _tidy(run: Run) -> None:
    """Remove what a killed process left half written."""
    for name in WRITTEN:
        remove_leftovers(run.folder / name)


def _check(run: Run, settings: Settings, now: Snapshot, resume: bool, screen: Console) -> None:
    """Raise unless the run in the folder has the requested settings and can be resumed."""
    before = run.snapshot()
    changed = [] if before is None else [*differences(before, now), *run.changes_in_others(settings)]
    found = [*setting_differences(run.settings(), settings), *([] if resume else changed)]
    ways = "choose another folder with --out, or replace the run with --overwrite"
    if found:
        raise IrsimGymError(f"{run.folder} holds a run with other settings ({listed(found)}); {ways}")
    if not resume and not run.finished() and list_checkpoints(run.checkpoints):
        raise IrsimGymError(f"{run.folder} holds an unfinished run; continue it with --resume, {ways}")
    if changed:
        message = f"the scenario has changed since this run began ({listed(changed)}); it uses its copy, {run.copy}"
        screen.print(message, markup=False, highlight=False, soft_wrap=True)


def _model(
    settings: Settings, newest: Path | None, device: str | None, screen: Console
) -> tuple[BaseAlgorithm, RunProgress]:
    """Return the model that learns, a new one or that of a checkpoint, and how far it is."""
    if device is not None:
        settings = replace(settings, hyperparameters=replace(settings.hyperparameters, device=device))
    torch.set_num_threads(settings.hyperparameters.torch_threads)
    resolve_device(settings.hyperparameters.device)
    compile_kernels(settings)
    if newest is not None and settings.engine is None:
        return restored_model(settings, newest)
    model = new_model(settings)
    if newest is not None:
        return model, load_progress(newest)
    if settings.origin is not None:
        copy_weights(model, settings)
    if settings.hyperparameters.clone is None:
        return model, RunProgress()
    seconds, cpu_seconds = clone_behavior(model, settings, screen)
    return model, RunProgress(training_seconds=seconds, cpu_seconds=cpu_seconds)


def _learn(
    run: Run,
    settings: Settings,
    model: BaseAlgorithm,
    progress: RunProgress,
    newest: Path | None,
    console: Console,
    on_checkpoint: Callable[[Run], object] | None,
    *,
    logged: LogCallback,
) -> None:
    """Learn to the end, or to a signal; either way leave a checkpoint."""
    begin_log(run, logged)
    curriculum = curriculum_of(settings, newest)
    wanted, stop = settings.hyperparameters, StopRequest()
    remove_partial(run.checkpoints)
    model.set_logger(tensorboard_logger(run))

    def save() -> Path:
        levels = None if curriculum is None else curriculum.levels
        return files.save_checkpoint(run.checkpoints, model, progress, levels)

    def save_and_show() -> None:
        written = save()
        if on_checkpoint is not None and stop.signal is None:
            on_checkpoint(run)
            files.restore_random(model, files.load_state(written))  # loading a policy seeds the global generators

    watch = TrainingMonitor(progress, wanted.n_timesteps, wanted.checkpoint_every, save_and_show, stop, console)
    callbacks: list[BaseCallback] = [watch, logged, *filter(None, [curriculum])]
    with stop.listening():
        try:
            left = wanted.n_timesteps - model.num_timesteps
            model.learn(max(left, 0), callback=callbacks, reset_num_timesteps=False)
            watch.update_progress()
        except StopLearningError:
            assert stop.signal is not None
            raise stopped_early(progress.steps, stop.signal) from None
        finally:
            watch.finish()
            model.logger.close()
        last = save()
        watch.print_line()
        if (last / NORMALIZATION).is_file():
            write_bytes(run.folder / NORMALIZATION, (last / NORMALIZATION).read_bytes())
        files.export_policy(run.policy, model)
    if stop.signal is not None:
        raise stopped_at_end(progress.steps, stop.signal)


def _write_log(run: Run, progress: RunProgress) -> None:
    rows = ({name: row.get(name, "") for name in LOG_COLUMNS} for row in progress.history)
    write_csv(run.folder / "training.csv", LOG_COLUMNS, rows)
