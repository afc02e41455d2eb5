"""Tuning of hyper-parameters and reward weights. Optuna chooses the trials, which are ordinary training runs."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.tables import PLAIN, plain, write_json
from irsim_gym.extras import require
from irsim_gym.outside_files import json_object, reading, remove
from irsim_gym.scenario.messages import show
from irsim_gym.training.checkpoint_files import list_checkpoints, remove_state
from irsim_gym.training.folders import sole_writer
from irsim_gym.training.inputs import check_folder
from irsim_gym.training.interruption import TrainingInterruptedError, ctrl_c_as_error
from irsim_gym.training.request_checks import check_request
from irsim_gym.training.run import Run, Settings
from irsim_gym.training.score import Point, score_run
from irsim_gym.training.search_space import SearchSpace, Values, read_space, shipped_space
from irsim_gym.training.snapshot import listed
from irsim_gym.training.train import train
from irsim_gym.training.training_request import TrainingRequest
from irsim_gym.training.trial_settings import check_space, write_settings
from irsim_gym.training.tuning_results import (
    BEST,
    BEST_TASK,
    RESULTS,
    TuningTrial,
    best_of,
    keep_best,
    show_trials,
    value_text,
    write_trials,
)

JOURNAL, CONFIG, TRIALS = "study.log", "tune.json", "trials"
REFUSED, FAILED = "refused", "failed"
"""Attributes of a trial with the reason why its settings cannot be trained, or with the error of its training."""
FINISHED_FIRST, FIRST_PRUNED = 5, 3
"""Number of trials that finish before any is pruned, and the first checkpoint at which a trial can be pruned."""
CONFIRMED = 5
"""Number of seeds that confirm the best settings. The best seed of many trials may have been lucky."""


@dataclass(frozen=True)
class Tuning:
    """A study on disk.

    Attributes:
        request: Arguments of the training that is tuned.
        settings: Settings of this training, with which the first trial runs if the search space contains them.
        space: Search space.
        dev_levels: Number of ``dev`` levels on which each checkpoint is scored.
        folder: Folder of the study.
        optuna: The imported library.
        modules: Modules that ``--import`` names.
        console: Console for the progress.
    """

    request: TrainingRequest
    settings: Settings
    space: SearchSpace
    dev_levels: int
    folder: Path
    optuna: Any
    modules: tuple[str, ...] = ()
    console: Console = field(default_factory=lambda: Console(stderr=True))

    def to_plain(self) -> Values:
        """Return all that the trials depend on, as plain data."""
        found = {"settings": self.settings.to_plain(), "scenario": self.settings.snapshot().digest}
        return dict(plain({**found, "space": self.space.to_plain(), "dev_levels": self.dev_levels}))

    def trial_folder(self, number: int) -> Path:
        """Return the folder of a trial."""
        return self.folder / TRIALS / f"{number:04d}"


def run_tuning(
    request: TrainingRequest,
    trials: int,
    *,
    space: Path | None = None,
    out: Path | None = None,
    overwrite: bool = False,
    dev_levels: int = 300,
    modules: Sequence[str] = (),
) -> Path:
    """Run trials until the study has the given number, and return the folder of the study.

    An existing study continues, and an interrupted trial resumes from its newest checkpoint. The drawn values depend on
    the seed and the previous trials only, so an interrupted study gives the same result as an uninterrupted one.

    Args:
        request: Arguments of the training that is tuned.
        trials: Total number of trials of the study.
        space: File of the search space; None for the shipped one of the algorithm.
        out: Folder of the study; None for the default folder.
        overwrite: Replace the study in the folder.
        dev_levels: Number of ``dev`` levels on which each checkpoint is scored.
        modules: Modules that ``--import`` names, for the command that confirms the best settings.

    Raises:
        IrsimGymError: If an argument is invalid, the folder holds another study, or Optuna is not installed.
        TrainingInterruptedError: If Ctrl-C or SIGTERM stops it. The same command continues the study.
    """
    optuna = _optuna()
    check_request(request, lambda: check_folder(out), lambda: None if space is None else read_space(space))
    settings = request.settings()
    chosen = read_space(space or shipped_space(settings.algorithm))
    check_space(request, settings, chosen)
    run = request.folder(settings)
    folder = out or run.with_name(f"tune-{run.name}")
    tuning = Tuning(request, settings, chosen, dev_levels, folder, optuna, tuple(modules))
    try:
        told = "stopped at once; finished trials and the newest checkpoint are kept"
        with sole_writer(folder), ctrl_c_as_error(told):
            _begin(tuning, overwrite)
            found = _run_trials(tuning, _study(tuning), trials)
    except TrainingInterruptedError as stop:
        raise TrainingInterruptedError(f"{stop}. To continue, run the same command.", stop.signal) from None
    show_trials(found, request.scenario)
    print(f"trials: {tuning.folder / TRIALS}; table and picture: {', '.join(RESULTS[:2])} in {tuning.folder}")
    if best_of(found) is not None:
        print(f"to confirm the best by {CONFIRMED} other seeds:\n{_confirm_command(tuning)}")
    return tuning.folder


def _confirm_command(tuning: Tuning) -> str:
    """Return the command, for a shell, that trains other seeds than that of the trials with the best settings."""
    request, is_weighted = tuning.request, bool(tuning.space.rewards)
    task = str(tuning.folder / BEST_TASK) if is_weighted else request.task
    words = ["irsim-gym", "train", request.scenario, "--seed", str(request.seed + 1), "--seeds", str(CONFIRMED)]
    words += ["--hyperparameters", str(tuning.folder / BEST)]
    words += [] if task is None else ["--task", task]
    words += [] if request.algorithm is None else ["--algorithm", request.algorithm]
    for name, value in (request.parameters or {}).items():
        words += ["--set", f"{name}={value}"]
    for module in tuning.modules:
        words += ["--import", module]
    return shlex.join([*words, *([] if request.strict else ["--lenient"])])


def _optuna() -> Any:
    """Import and return Optuna.

    Raises:
        MissingExtraError: If it is not installed.
    """
    require("tune", "irsim-gym tune")
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def _begin(tuning: Tuning, overwrite: bool) -> None:
    """Check that the folder holds no other study, and write the settings of this one.

    Raises:
        IrsimGymError: If the folder holds another study, or other files.
    """
    folder, now = tuning.folder, tuning.to_plain()
    path = folder / CONFIG
    if overwrite and path.is_file():
        for name in (JOURNAL, *RESULTS, TRIALS, CONFIG):
            remove(folder / name)
    if path.is_file():
        with reading(path, "file with the settings of a study"):
            before = json_object(path)
        changed = _differences(before, now, ())
        if changed:
            raise IrsimGymError(
                f"{folder} holds a study with other settings ({listed(changed)}); choose another folder with --out, or "
                "replace the study with --overwrite"
            )
    elif folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise IrsimGymError(f"{folder} holds something other than a study: choose another folder with --out")
    else:
        write_json(path, now)


def _differences(before: object, now: object, place: tuple[str, ...]) -> list[str]:
    """Return the keys in which two nested mappings differ, with both values."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        keys = dict.fromkeys([*before, *now])
        return [one for key in keys for one in _differences(before.get(key), now.get(key), (*place, key))]
    return [] if before == now else [f"{'.'.join(place)} {show(before)}, asked for: {show(now)}"]


def _study(tuning: Tuning) -> Any:
    """Open the study on disk. A new one begins with the current settings, if the search space contains them."""
    optuna, states = tuning.optuna, tuning.optuna.trial.TrialState
    backends, file = optuna.storages.journal, str(tuning.folder / JOURNAL)
    # Optuna's default lock uses symbolic links, which need privileges on Windows.
    journal = backends.JournalFileBackend(file, lock_obj=backends.JournalFileOpenLock(file))
    study = optuna.create_study(
        study_name="tune",
        storage=optuna.storages.JournalStorage(journal),
        direction="maximize",
        pruner=optuna.pruners.MedianPruner(n_startup_trials=FINISHED_FIRST, n_warmup_steps=FIRST_PRUNED),
        load_if_exists=True,
    )
    for trial in study.get_trials(deepcopy=False, states=(states.RUNNING,)):
        study.tell(trial.number, state=states.FAIL)
        study.enqueue_trial(trial.params)
    if not study.get_trials(deepcopy=False):
        found, outside = tuning.space.to_parameters(tuning.settings.hyperparameters.to_plain())
        if outside:
            missing = f"{tuning.space.file} does not contain the current values of {', '.join(outside)}"
            tuning.console.print(f"{missing}: the first trial draws them", **PLAIN)
        study.enqueue_trial(found)
    return study


def _run_trials(tuning: Tuning, study: Any, trials: int) -> list[TuningTrial]:
    """Run trials until there are enough, update the results on disk after each, and return all trials."""
    found = _trials(tuning, study)
    while len(found) < trials:
        number = len(found)
        seed = int(np.random.SeedSequence((tuning.request.seed, number)).generate_state(1)[0])
        study.sampler = tuning.optuna.samplers.TPESampler(seed=seed)
        trial = study.ask()
        drawn = tuning.space.draw(trial)
        values = ", ".join(f"{name}={value_text(value)}" for name, value in trial.params.items())
        tuning.console.print(f"trial {number}, {number + 1} of {trials}: {values}", **PLAIN)
        _conduct(tuning, study, trial, tuning.trial_folder(number), drawn)
        found = _trials(tuning, study)
        write_trials(tuning.folder, found, tuning.request.scenario)
        best = best_of(found)
        if best is not None:
            keep_best(tuning.folder, tuning.trial_folder(best.number))
    return found


def _conduct(tuning: Tuning, study: Any, trial: Any, folder: Path, drawn: tuple[Values, Values]) -> None:
    """Run a trial, and tell the study how it ended. Only an interrupted trial stays open.

    A training whose hyper-parameters or rewards do not suit it ends with one of several errors, such as a ValueError
    of PyTorch for weights that are NaN. The other trials go on.
    """
    states, reason = tuning.optuna.trial.TrialState, REFUSED
    try:
        wanted = write_settings(folder, tuning.request, tuning.settings, *drawn).settings()
        reason = FAILED
        value = _run_trial(tuning, trial, wanted, folder)
    except TrainingInterruptedError:
        raise
    except (IrsimGymError, ValueError, RuntimeError) as error:
        message = str(error) or type(error).__name__
        trial.set_user_attr(reason, message)
        study.tell(trial, state=states.FAIL)
        tuning.console.print(f"{reason}: {message}", **PLAIN)
    else:
        study.tell(trial, value, state=states.PRUNED if value is None else None)
    for checkpoint in list_checkpoints(Run(folder).checkpoints):
        remove_state(checkpoint)


def _run_trial(tuning: Tuning, trial: Any, wanted: Settings, place: Path) -> float | None:
    """Train a trial, and return its success on ``dev`` levels; None if it is pruned."""
    run, reported = Run(place), set[int]()

    def report(run: Run) -> None:
        """Report new scores to the study, and stop the trial if the study prunes it."""
        for point in _score(tuning, run):
            number = int(point["steps"]) // wanted.hyperparameters.checkpoint_every
            if number and number not in reported:
                trial.report(point["success"], number)
                reported.add(number)
        if trial.should_prune():
            raise tuning.optuna.TrialPruned

    value: float | None = None
    try:
        if run.exists():
            report(run)
        how: dict[str, Any] = {"resume": run.exists(), "device": tuning.request.device, "console": tuning.console}
        train(wanted, place, on_checkpoint=report, **how)
        value = _score(tuning, run)[-1]["success"]
    except tuning.optuna.TrialPruned:
        last = max(reported)
        tuning.console.print(f"pruned: worse than the median of the trials before, at checkpoint {last}", **PLAIN)
    return value


def _score(tuning: Tuning, run: Run) -> list[Point]:
    return score_run(run, levels=tuning.dev_levels, console=Console(quiet=True), picture=False)


def _trials(tuning: Tuning, study: Any) -> list[TuningTrial]:
    """Return the trials of a study, without interrupted ones, which are repeated under another number."""
    states = tuning.optuna.trial.TrialState
    found: list[TuningTrial] = []
    for one in study.get_trials(deepcopy=False):
        reasons = {name: one.user_attrs.get(name, "") for name in (REFUSED, FAILED)}
        if one.state in (states.COMPLETE, states.PRUNED) or any(reasons.values()):
            value = one.value if one.state == states.COMPLETE else None
            scores = dict(one.intermediate_values)
            found.append(TuningTrial(len(found), dict(one.params), value, scores, **reasons))
    return found
