"""The results of a tuning: a table, a CSV file, and the settings of the best trial."""

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import yaml

from irsim_gym.evaluation.protocol.tables import figure_table, plain, print_table, write_csv, write_text
from irsim_gym.training.searches.trial_settings import TASK
from irsim_gym.training.settings.run import Run

TABLE, BEST, BEST_TASK = "trials.csv", "best_hyperparameters.yaml", "best_task.yaml"
RESULTS = (TABLE, BEST, BEST_TASK)
COLUMNS = ("trial", "success", "ending")
"""Attributes of a trial of Optuna that has ended: its number, which it keeps when it is repeated after an interruption,
its latest success or NaN, and how it ended: ``finished``, ``pruned at N``, ``refused: WHY`` or ``failed: WHY``."""
FINISHED = "finished"
SHOWN = 10
"""Number of rows in the printed table."""


def ended_trials(study: Any) -> list[Any]:
    """Return the trials of a study that have ended, in the order of their numbers."""
    ended = [one for one in study.get_trials(deepcopy=False) if one.state.is_finished() and "ending" in one.user_attrs]
    return sorted(ended, key=lambda trial: trial.user_attrs["trial"])


def ranked(trials: Sequence[Any]) -> list[list[Any]]:
    """Return the trials in groups that differ in the seed alone, the group with the greatest median success first.

    Groups in which no trial has finished come after the others, and those without any score last.
    """
    groups: dict[str, list[Any]] = {}
    for trial in trials:
        groups.setdefault(str({**trial.params, "seed": None}), []).append(trial)
    return sorted(groups.values(), key=_rank)


def _rank(group: Sequence[Any]) -> tuple[bool, float]:
    finished = [trial for trial in group if trial.user_attrs["ending"] == FINISHED]
    return not finished, -median(_scores(finished or group) or [-math.inf])


def _scores(trials: Sequence[Any]) -> list[float]:
    return [trial.user_attrs["success"] for trial in trials if not math.isnan(trial.user_attrs["success"])]


def best_of(trials: Sequence[Any]) -> Any:
    """Return the first finished trial of the best group; None if no trial has finished."""
    ordered = (trial for group in ranked(trials) for trial in group)
    return next((trial for trial in ordered if trial.user_attrs["ending"] == FINISHED), None)


def write_trials(folder: Path, trials: Sequence[Any], best: Path | None) -> None:
    """Write ``trials.csv``, and the settings of the best trial, which its folder has."""
    names = list(dict.fromkeys(name for trial in trials for name in trial.params))
    rows = [{**dict.fromkeys(names, ""), **trial.user_attrs, **trial.params} for trial in trials]
    write_csv(folder / TABLE, [*COLUMNS, *names], rows)
    if best is not None:
        hyperparameters = plain(Run(best).settings().hyperparameters.to_plain())
        write_text(folder / BEST, yaml.safe_dump({"default": hyperparameters}, sort_keys=False))
        if (best / TASK).is_file():
            write_text(folder / BEST_TASK, (best / TASK).read_text(encoding="utf-8"))


def show_trials(trials: Sequence[Any], title: str) -> None:
    """Print the best trials.

    Trials that differ in the seed alone share a row, with the median of their success and its range.
    """
    texts = {name: {value_text(trial.params.get(name)) for trial in trials} for name in trials[0].params}
    names = [name for name in texts if name != "seed" and len(texts[name]) > 1]
    n_pruned = sum(trial.user_attrs["ending"].startswith("pruned") for trial in trials)
    rows = []
    for group in ranked(trials)[:SHOWN]:
        scores = [100.0 * score for score in _scores(group)]
        spread = f" [{min(scores):.1f}, {max(scores):.1f}]" if len(scores) > 1 else ""
        numbers = ", ".join(str(trial.user_attrs["trial"]) for trial in group)
        ending = ", ".join(dict.fromkeys(trial.user_attrs["ending"].partition(":")[0] for trial in group))
        values = (value_text(group[0].params.get(name)) for name in names)
        rows.append((numbers, f"{median(scores):.1f}{spread}" if scores else "-", ending, *values))
    heads = [head.replace("_", "_\n").replace(".", ".\n") for head in ("trial", "success [%]", "ending", *names)]
    print_table(figure_table(f"{title}: {len(trials)} trials, {n_pruned} of them pruned; the best", heads, rows))


def value_text(value: object) -> str:
    """Return a drawn value as text, with four significant digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
