"""Tuning: Optuna chooses trials from a space, or goes through a grid. The trials are ordinary training runs."""

import json
import math
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.extras import require
from irsim_gym.base.imports import import_modules
from irsim_gym.base.outside_files import json_object, reading, remove
from irsim_gym.evaluation.protocol.tables import PLAIN, plain, write_json
from irsim_gym.evaluation.requests.inputs import check_folder
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError, ctrl_c_as_error
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, remove_state
from irsim_gym.evaluation.saved_policies.snapshot import listed
from irsim_gym.training.curves.score import score_run
from irsim_gym.training.requests.request_checks import check_request
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.searches import tuning_results as results
from irsim_gym.training.searches.search_space import SearchSpace, read_space, shipped_space
from irsim_gym.training.searches.trial_settings import check_space, trial_settings
from irsim_gym.training.settings.folders import setting_differences, sole_writer
from irsim_gym.training.settings.run import Run, Settings

JOURNAL, CONFIG, TRIALS = "study.log", "tune.json", "trials"
SEARCHED = 40
"""Number of trials of a search, if none is given."""
FINISHED_FIRST, FIRST_PRUNED = 5, 3
"""Number of trials that finish before any is pruned, and the first checkpoint at which a trial can be pruned."""


@dataclass(frozen=True)
class Tuning:
    """What is tuned, and where.

    Attributes:
        request: Arguments of the training that is tuned.
        space: Search space.
        is_grid: Whether the trials are all combinations of the space.
        folder: Folder of the study.
        dev_levels: Number of ``dev`` levels on which each checkpoint is scored.
        modules: Modules that ``--import`` names.
    """

    request: TrainingRequest
    space: SearchSpace
    is_grid: bool
    folder: Path
    dev_levels: int = 300
    modules: tuple[str, ...] = ()

    def trial_folder(self, trial: Any) -> Path:
        """Return the folder of a trial of Optuna."""
        return self.folder / TRIALS / f"{trial.user_attrs['trial']:04d}"

    def study(self) -> Any:
        """Open the study on disk, in any process. Trials of a grid are not pruned."""
        import optuna
        from optuna.storages import journal

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        file, first = str(self.folder / JOURNAL), sys.maxsize if self.is_grid else FINISHED_FIRST
        # Optuna's default lock uses symbolic links, which need privileges on Windows.
        backend = journal.JournalFileBackend(file, lock_obj=journal.JournalFileOpenLock(file))
        pruner = optuna.pruners.MedianPruner(n_startup_trials=first, n_warmup_steps=FIRST_PRUNED)
        options: dict[str, Any] = {"study_name": "tune", "direction": "maximize", "load_if_exists": True}
        return optuna.create_study(storage=optuna.storages.JournalStorage(backend), pruner=pruner, **options)


def run_tuning(
    request: TrainingRequest,
    trials: int | None = None,
    *,
    scenarios: Sequence[str] = (),
    space: Path | None = None,
    grid: bool = False,
    out: Path | None = None,
    overwrite: bool = False,
    workers: int = 1,
    **options: Any,
) -> Path:
    """Run trials until the study has the given number, and return the folder of the study.

    An existing study continues, and an interrupted trial resumes from its newest checkpoint. With one trial at a time,
    drawn values depend on the seed and the previous trials only, so an interrupted study ends as an uninterrupted one.

    Args:
        request: Arguments of the training that is tuned.
        trials: Total number of trials of the study; None for 40, or all of a grid.
        scenarios: Scenarios of the trials, if there are several; the first is that of the request.
        space: File of the search space; None for the shipped one of the algorithm.
        grid: Train all combinations of the space, which has lists of values only.
        out: Folder of the study; None for the default folder.
        overwrite: Replace the study in the folder.
        workers: Number of trials at a time.
        **options: ``dev_levels`` and ``modules`` of the ``Tuning``.

    Raises:
        IrsimGymError: If an argument is invalid, the folder holds another study, a process was killed, or Optuna is
            not installed.
        TrainingInterruptedError: If Ctrl-C or SIGTERM stops it. The same command continues the study.
    """
    require("tune", "irsim-gym tune")
    names = list(dict.fromkeys(scenarios)) or [request.scenario]
    check_request(request, lambda: check_folder(out), lambda: None if space is None else read_space(space, grid=grid))
    settings = request.settings()
    chosen = read_space(space or shipped_space(settings.algorithm), names, grid=grid)
    check_space(request, chosen, names)
    run = request.folder(settings)
    tuning = Tuning(request, chosen, grid, out or run.with_name(f"tune-{run.name}"), **options)
    points = chosen.grid() if grid else []
    n_trials = min(trials or len(points), len(points)) if grid else trials or SEARCHED
    try:
        text = "stopped at once; finished trials and the newest checkpoint are kept"
        with sole_writer(tuning.folder), ctrl_c_as_error(text):
            _begin(tuning, settings, names, overwrite)
            _enqueue(tuning, n_trials, points)
            _run_all(tuning, workers)
    except TrainingInterruptedError as stop:
        raise TrainingInterruptedError(f"{stop}. To continue, run the same command.", stop.signal) from None
    _show(tuning, n_trials)
    return tuning.folder


def _show(tuning: Tuning, n_trials: int) -> None:
    """Print the results.

    Raises:
        IrsimGymError: If trials have not ended.
    """
    ended = results.ended_trials(tuning.study())
    if len(ended) < n_trials:
        left = n_trials - len(ended)
        raise IrsimGymError(f"{left} trials have not ended, as a process was killed: run the same command again")
    results.show_trials(ended, tuning.request.scenario)
    print(f"trials: {tuning.folder / TRIALS}; table: {tuning.folder / results.TABLE}")


def _begin(tuning: Tuning, settings: Settings, scenarios: Sequence[str], overwrite: bool) -> None:
    """Check that the folder holds no other study, and write the settings of this one.

    Raises:
        IrsimGymError: If the folder holds another study, or other files.
    """
    folder, path = tuning.folder, tuning.folder / CONFIG
    digests = [replace(tuning.request, scenario=name).settings().snapshot().digest for name in scenarios]
    now: dict[str, Any] = {"settings": settings.to_plain(), "digests": digests, "dev_levels": tuning.dev_levels}
    now |= {"space": {"/".join(axis): vars(domain) for axis, domain in tuning.space.axes.items()}}
    now = json.loads(json.dumps(plain({**now, "grid": tuning.is_grid})))
    is_replaced = overwrite and path.is_file()
    if is_replaced:
        for name in (JOURNAL, CONFIG, TRIALS, *results.RESULTS):
            remove(folder / name)
    if path.is_file():
        with reading(path, "file with the settings of a study"):
            before = json_object(path)
            changed = setting_differences(Settings.from_plain(before["settings"]), settings)
        changed += [key for key in now if key != "settings" and before.get(key) != now[key]]
        if changed:
            raise IrsimGymError(
                f"{folder} holds a study with other settings ({listed(changed)}); choose another folder with --out, or "
                "replace the study with --overwrite"
            )
    elif folder.exists() and any(folder.iterdir()) and not is_replaced:
        raise IrsimGymError(f"{folder} holds something other than a study: choose another folder with --out")
    else:
        write_json(path, now)


def _enqueue(tuning: Tuning, n_trials: int, points: Sequence[dict[str, Any]]) -> None:
    """Enqueue the trials to do by their numbers: with the values of the grid, those drawn before, or none yet.

    Optuna's ``GridSampler`` gives processes side by side the same values, and knows no trials that are repeated.
    """
    from optuna.trial import TrialState

    study = tuning.study()
    open_trials = study.get_trials(deepcopy=False, states=(TrialState.RUNNING, TrialState.WAITING))
    values = dict(enumerate(points)) | {item.user_attrs["trial"]: item.params for item in open_trials if item.params}
    for trial in open_trials:
        study._storage.set_trial_state_values(trial._trial_id, TrialState.FAIL)
    ended = {trial.user_attrs["trial"] for trial in results.ended_trials(study)}
    left = [number for number in range(n_trials) if number not in ended]
    Console(stderr=True).print(f"{n_trials} trials, {len(left)} of them to do, in {tuning.folder}", **PLAIN)
    for number in left:
        study.enqueue_trial(values.get(number, {}), user_attrs={"trial": number})


def _run_all(tuning: Tuning, workers: int) -> None:
    """Run the enqueued trials one after another in this process, or side by side in processes.

    A signal stops the processes by SIGTERM alone, at which trainings write a checkpoint.
    """
    if workers == 1:
        work(tuning)
        return
    before, processes = signal.signal(signal.SIGTERM, signal.default_int_handler), list[Any]()
    try:
        for _ in range(workers):
            processes.append(get_context("spawn").Process(target=_work_apart, args=(tuning,)))
            processes[-1].start()
        for process in processes:
            process.join()
    finally:
        for process in processes:
            process.terminate()
            process.join()
        signal.signal(signal.SIGTERM, before)


def _work_apart(tuning: Tuning) -> None:
    """Run enqueued trials in a process of its own, which Ctrl-C reaches while it trains, beside the SIGTERM."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    import_modules(tuning.modules)
    with suppress(TrainingInterruptedError, KeyboardInterrupt):
        work(tuning, quiet=True)


def work(tuning: Tuning, *, quiet: bool = False) -> None:
    """Run enqueued trials until there are none, and write the results after each. An interrupted trial stays open."""
    import optuna

    study, states, console = tuning.study(), optuna.trial.TrialState, Console(stderr=True)
    while study.get_trials(deepcopy=False, states=(states.WAITING,)):
        trial = study.ask()
        if "trial" not in trial.user_attrs:  # another process has begun the last one
            study.tell(trial, state=states.FAIL)
            return
        ending, scores = _run_trial(tuning, trial, console, quiet)
        success = scores[max(scores)] if scores else math.nan
        for name, value in {"success": success, "ending": ending}.items():
            trial.set_user_attr(name, value)
        if ending == results.FINISHED:
            study.tell(trial, success)
        else:
            study.tell(trial, state=states.PRUNED if ending.startswith("pruned") else states.FAIL)
        console.print(f"trial {trial.user_attrs['trial']}: success {success:.1%}, {ending}", **PLAIN)
        for checkpoint in list_checkpoints(Run(tuning.trial_folder(trial)).checkpoints):
            remove_state(checkpoint)
        ended = results.ended_trials(study)
        best = results.best_of(ended)
        results.write_trials(tuning.folder, ended, best and tuning.trial_folder(best))


def _run_trial(tuning: Tuning, trial: Any, console: Console, quiet: bool) -> tuple[str, dict[int, float]]:
    """Train a trial, and return how it ended, and its success by the number of the checkpoint.

    A training whose hyper-parameters or rewards do not suit it ends with one of several errors, such as a ValueError
    of PyTorch for weights that are NaN. The other trials go on.
    """
    import optuna

    number, run, ending = trial.user_attrs["trial"], Run(tuning.trial_folder(trial)), "refused"
    scores = dict[int, float]()
    seed = int(np.random.SeedSequence((tuning.request.seed, number)).generate_state(1)[0])
    trial.study.sampler = optuna.samplers.TPESampler(seed=seed)
    drawn = tuning.space.draw(trial)
    values = ", ".join(f"{name}={results.value_text(value)}" for name, value in trial.params.items())
    console.print(f"trial {number}: {values}", **PLAIN)

    def report(run: Run, *, to_study: bool = True) -> None:
        """Note new scores, tell the study, and stop the trial if the study prunes it."""
        for point in score_run(run, levels=tuning.dev_levels, console=Console(quiet=True), picture=False):
            checkpoint = int(point["steps"]) // settings.hyperparameters.checkpoint_every
            if to_study and checkpoint and checkpoint not in scores:
                trial.report(point["success"], checkpoint)
            scores[checkpoint] = point["success"]
        if to_study and trial.should_prune():
            raise optuna.TrialPruned

    try:
        settings = trial_settings(tuning.request, drawn, run.folder)
        ending = "failed"
        if run.exists():
            report(run)
        how: dict[str, Any] = {"device": tuning.request.device, "console": Console(stderr=True, quiet=quiet)}
        train(settings, run.folder, resume=run.exists(), on_checkpoint=report, **how)
        report(run, to_study=False)
    except TrainingInterruptedError:
        raise
    except optuna.TrialPruned:
        return f"pruned at {max(scores)}", scores
    except (IrsimGymError, ValueError, RuntimeError) as error:
        return f"{ending}: {str(error) or type(error).__name__}", scores
    return results.FINISHED, scores
