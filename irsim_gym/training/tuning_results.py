"""The results of a tuning: a table, a figure, and the settings of the best trial."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.text import Text

from irsim_gym.evaluation.tables import print_table, titled_table, write_csv, write_figure, write_text
from irsim_gym.training.trial_settings import HYPERPARAMETERS, TASK

TABLE, PICTURE = "trials.csv", "trials.png"
BEST, BEST_TASK = "best_hyperparameters.yaml", "best_task.yaml"
RESULTS = (TABLE, PICTURE, BEST, BEST_TASK)
SHOWN = 10
"""Number of trials in the printed table."""
COLUMNS = 4
"""Number of panels in a row of the figure."""
ACCENT, PALE = "#2166ac", "#9aa5b1"


@dataclass(frozen=True)
class TuningTrial:
    """A trial of a tuning.

    Attributes:
        number: Number of the trial, from 0.
        drawn: Drawn values by name.
        success: Success at the end of the training; None if the trial was pruned or refused, or failed.
        scores: Success at each checkpoint, by its number from 1.
        refused: Reason why its settings could not be trained; empty if they could.
        failed: Message of the error that ended its training; empty if there was none.
    """

    number: int
    drawn: Mapping[str, Any]
    success: float | None
    scores: Mapping[int, float]
    refused: str = ""
    failed: str = ""

    @property
    def latest(self) -> float:
        """Latest success; NaN without any score."""
        if self.success is not None:
            return self.success
        return self.scores[max(self.scores)] if self.scores else math.nan

    @property
    def ending(self) -> str:
        """How the trial ended: ``refused``, ``failed``, ``finished``, or ``pruned at`` a checkpoint."""
        if self.refused or self.failed:
            return "refused" if self.refused else "failed"
        return "finished" if self.success is not None else f"pruned at {max(self.scores, default=0)}"


def best_of(trials: Sequence[TuningTrial]) -> TuningTrial | None:
    """Return the first finished trial with the greatest success; None if no trial has finished."""
    done = [trial for trial in trials if trial.success is not None]
    return max(done, key=lambda trial: trial.latest, default=None)


def write_trials(folder: Path, trials: Sequence[TuningTrial], title: str) -> None:
    """Write ``trials.csv`` and ``trials.png``."""
    names = list(dict.fromkeys(name for trial in trials for name in trial.drawn))
    rows = [
        {"trial": trial.number, "success": trial.latest, "ending": trial.ending, "why": trial.refused or trial.failed}
        | {name: trial.drawn.get(name, "") for name in names}
        for trial in trials
    ]
    write_csv(folder / TABLE, ["trial", "success", "ending", *names, "why"], rows)
    _draw(folder / PICTURE, trials, names, title)


def keep_best(folder: Path, place: Path) -> None:
    """Copy the settings of the best trial from its folder ``place`` to the study's ``folder``."""
    write_text(folder / BEST, (place / HYPERPARAMETERS).read_text(encoding="utf-8"))
    if (place / TASK).is_file():
        write_text(folder / BEST_TASK, (place / TASK).read_text(encoding="utf-8"))


def show_trials(trials: Sequence[TuningTrial], title: str) -> None:
    """Print the best trials and the first one, which has the original settings if the search space contains them."""
    order = sorted(trials, key=_rank)
    shown = order[:SHOWN] + [trial for trial in order[SHOWN:] if trial.number == 0]
    names = list(dict.fromkeys(name for trial in shown for name in trial.drawn))
    ended = sum(trial.ending.startswith("pruned") for trial in trials)
    table = titled_table(f"{title}: {len(trials)} trials, {ended} of them pruned; the best")
    for head in ("trial", "success [%]", "ending", *names):
        table.add_column(Text(head.replace("_", "_\n").replace(".", ".\n")), justify="right")
    for trial in shown:
        success = "-" if math.isnan(trial.latest) else f"{100.0 * trial.latest:.1f}"
        values = (value_text(trial.drawn.get(name, "-")) for name in names)
        table.add_row(*map(Text, (str(trial.number), success, trial.ending, *values)))
    print_table(table)


def _rank(trial: TuningTrial) -> tuple[bool, float]:
    """Return the key that sorts trials: finished ones first, then by success; those without any score are last."""
    return trial.success is None, math.inf if math.isnan(trial.latest) else -trial.latest


def value_text(value: object) -> str:
    """Return a drawn value as text, with four significant digits."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _draw(path: Path, trials: Sequence[TuningTrial], names: Sequence[str], title: str) -> None:
    """Draw success over trials, with the best so far, and over each drawn value. Pruned trials are hollow."""
    from matplotlib.figure import Figure

    rows = math.ceil(len(names) / COLUMNS)
    figure = Figure(figsize=(9.6, 2.8 + 2.1 * rows), dpi=120, layout="constrained")
    grid = figure.add_gridspec(1 + rows, COLUMNS, height_ratios=[1.3] + [1.0] * rows)
    axes = figure.add_subplot(grid[0, :])
    _scatter(axes, [trial.number for trial in trials], trials)
    done = [trial for trial in trials if trial.success is not None]
    best = [max(one.latest for one in done[: i + 1]) for i in range(len(done))]
    axes.step([one.number for one in done], [100.0 * one for one in best], where="post", color=ACCENT, lw=1.0)
    axes.set(xlabel="trial", ylabel="success on dev levels [%]")
    words = f"{title}: hollow trials were pruned, the line is the best so far"
    axes.set_title(words, loc="left", fontsize=10, parse_math=False)
    for i, name in enumerate(names):
        panel = figure.add_subplot(grid[1 + i // COLUMNS, i % COLUMNS], sharey=axes)
        _scatter(panel, [trial.drawn.get(name) for trial in trials], trials)
        panel.set_xlabel(name, fontsize=8, parse_math=False)
        panel.tick_params(labelsize=7)
    for panel in figure.axes:
        panel.spines[["top", "right"]].set_visible(False)
    write_figure(path, figure)


def _scatter(axes: Any, values: Sequence[Any], trials: Sequence[TuningTrial]) -> None:
    """Draw success over drawn values. Values other than numbers appear in the order in which they were drawn."""
    known = [(value, trial) for value, trial in zip(values, trials, strict=True) if not math.isnan(trial.latest)]
    if not all(isinstance(value, int | float) and not isinstance(value, bool) for value, _ in known):
        known = [(str(value), trial) for value, trial in known]
    for is_done in (False, True):
        part = [(value, 100.0 * trial.latest) for value, trial in known if (trial.success is not None) == is_done]
        if part:
            face, edge = (ACCENT, ACCENT) if is_done else ("none", PALE)
            axes.scatter(*zip(*part, strict=True), s=14, facecolors=face, edgecolors=edge)
