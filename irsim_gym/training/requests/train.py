"""Training with Stable-Baselines3 that can be interrupted at any time."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import torch
from rich.console import Console
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.protocol.tables import PLAIN, remove_leftovers, write_bytes, write_csv
from irsim_gym.evaluation.requests.inputs import check_folder
from irsim_gym.evaluation.requests.interruption import StopRequest, TrainingInterruptedError
from irsim_gym.evaluation.saved_policies import checkpoint_files as stored
from irsim_gym.evaluation.saved_policies.snapshot import Snapshot, differences, listed
from irsim_gym.sb3 import LogCallback, MirrorCallback
from irsim_gym.training.runs import checkpoint as files
from irsim_gym.training.runs import models
from irsim_gym.training.runs.cloning import clone_behavior
from irsim_gym.training.runs.environment import compile_kernels
from irsim_gym.training.runs.fine_tuning import copy_weights
from irsim_gym.training.runs.monitoring import StopLearningError, TrainingMonitor, tensorboard_logger
from irsim_gym.training.settings.folders import check_replaceable, setting_differences, sole_writer
from irsim_gym.training.settings.run import FILES, Run, Settings

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
) -> Run:
    """Train a policy, and write checkpoints, logs and the final policy to ``folder``.

    A finished run does not change. With ``resume``, an interrupted run continues from its newest checkpoint. With PPO,
    its result equals that of an uninterrupted run. A resumed run uses its own copy of the scenario, and prints a
    message if the scenario has changed. Nothing is written before the model exists.

    Args:
        folder: Folder of the run.
        resume: Continue the run in the folder.
        overwrite: Replace the run in the folder.
        device: Device of the networks for this call; None for that of the settings.
        console: Console for the progress; None for standard error.
        on_checkpoint: Function that is called after each checkpoint but the last. Its time does not count as training
            time, and it does not affect the result, unless it returns True: then the run ends there. If it raises, the
            run stops unfinished.

    Raises:
        IrsimGymError: If the folder is a file, holds another run or one that has to be resumed, or another process
            trains into it; or the networks diverge.
        TrainingInterruptedError: If Ctrl-C, SIGTERM or SIGHUP stops the training. A checkpoint is on disk.
    """
    run, screen = Run(folder), console or Console(stderr=True)
    check_folder(run.folder)
    with sole_writer(run.folder):
        now = settings.snapshot()
        if overwrite:
            check_replaceable(run)
        elif run.exists():
            _check_run(run, settings, now, resume, screen)
        resumed = run.exists() and not overwrite
        if resumed and run.finished():
            _remove_leftovers(run)
            return run
        used = run.own_settings() if resumed else settings
        newest = stored.newest_checkpoint(run.checkpoints) if resumed else None
        model, progress = _model(used, newest, device, screen)
        _begin(run, settings, now, resumed=resumed)
        try:
            _learn(run, used, model, progress, screen, on_checkpoint)
        finally:
            rows = ({name: row.get(name, "") for name in LOG_COLUMNS} for row in progress.history)
            write_csv(run.folder / "training.csv", LOG_COLUMNS, rows)
            env = model.get_env()
            if env is not None:
                env.close()
        return run


def _begin(run: Run, settings: Settings, now: Snapshot, *, resumed: bool) -> None:
    """Prepare the folder of a run. Unless it is resumed, replace an existing run and write the settings."""
    if run.exists() and not resumed:
        run.clear()
    if not resumed:
        run.begin(settings, now)
    _remove_leftovers(run)


def _remove_leftovers(run: Run) -> None:
    """Remove the temporary files of a killed process."""
    for name in FILES:
        remove_leftovers(run.folder / name)


def _check_run(run: Run, settings: Settings, now: Snapshot, resume: bool, screen: Console) -> None:
    """Check that the run in the folder has the requested settings, and that an unfinished one is to be resumed."""
    before = run.snapshot()
    changed = [] if before is None else [*differences(before, now), *run.changes_in_others(settings)]
    differing = [*setting_differences(run.settings(), settings), *([] if resume else changed)]
    ways = "choose another folder with --out, or replace the run with --overwrite"
    if differing:
        raise IrsimGymError(f"{run.folder} holds a run with other settings ({listed(differing)}); {ways}")
    if not resume and not run.finished() and stored.list_checkpoints(run.checkpoints):
        raise IrsimGymError(f"{run.folder} holds an unfinished run; continue it with --resume, {ways}")
    if changed:
        message = f"the scenario has changed since this run began ({listed(changed)}); it uses its copy, {run.copy}"
        screen.print(message, **PLAIN)


def _model(
    settings: Settings, newest: Path | None, device: str | None, screen: Console
) -> tuple[BaseAlgorithm, stored.RunProgress]:
    """Return the model to train, which is new or restored from a checkpoint, and the progress of the run."""
    if device is not None:
        settings = replace(settings, hyperparameters=replace(settings.hyperparameters, device=device))
    torch.set_num_threads(settings.hyperparameters.torch_threads)
    models.resolve_device(settings.hyperparameters.device)
    compile_kernels(settings)
    if newest is not None:
        return models.restored_model(settings, newest)
    model = models.new_model(settings)
    if settings.origin is not None:
        copy_weights(model, settings)
    if settings.hyperparameters.clone is None:
        return model, stored.RunProgress()
    seconds, cpu_seconds = clone_behavior(model, settings, screen)
    return model, stored.RunProgress(training_seconds=seconds, cpu_seconds=cpu_seconds)


def _learn(
    run: Run,
    settings: Settings,
    model: BaseAlgorithm,
    progress: stored.RunProgress,
    console: Console,
    on_checkpoint: Callable[[Run], object] | None,
) -> None:
    """Learn until the end of the run or until a signal, and write a checkpoint in both cases."""
    hyper, stop = settings.hyperparameters, StopRequest()
    stored.remove_partial(run.checkpoints)
    model.set_logger(tensorboard_logger(run))

    def save() -> Path:
        models.check_finite(run, settings, model)
        return files.save_checkpoint(run.checkpoints, model, progress)

    def save_and_show() -> None:
        written = save()
        if on_checkpoint is not None and stop.signal is None:
            ends_here = on_checkpoint(run) is True
            files.restore_random(model, files.load_state(written))  # loading a policy seeds the global generators
            if ends_here:
                raise StopLearningError

    watch = TrainingMonitor(progress, hyper.n_timesteps, hyper.checkpoint_every, save_and_show, stop, console)
    mirrored = MirrorCallback(seed=settings.seed) if settings.hyperparameters.mirror else None
    callbacks: list[BaseCallback] = [watch, LogCallback(), *filter(None, [mirrored])]
    with stop.listening():
        try:
            left = hyper.n_timesteps - model.num_timesteps
            model.learn(max(left, 0), callback=callbacks, reset_num_timesteps=False)
            watch.update_progress()
        except StopLearningError:
            if stop.signal is not None:
                message = f"stopped after {progress.steps:,} steps; nothing is lost"
                raise TrainingInterruptedError(message, stop.signal) from None
        except (ValueError, RuntimeError):
            models.check_finite(run, settings, model)
            raise
        finally:
            watch.finish()
            model.logger.close()
        last = save()
        watch.print_line()
        if (last / stored.NORMALIZATION).is_file():
            write_bytes(run.folder / stored.NORMALIZATION, (last / stored.NORMALIZATION).read_bytes())
        files.export_policy(run.policy, model)
        (last / stored.REPLAY_BUFFER).unlink(missing_ok=True)
    if stop.signal is not None:
        message = f"stopped after all {progress.steps:,} steps; the run is finished"
        raise TrainingInterruptedError(message, stop.signal)
