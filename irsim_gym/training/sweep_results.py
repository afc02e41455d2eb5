"""What a sweep has found: a row for each condition, over its seeds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from rich.text import Text

from irsim_gym.errors import UnreadableFileError
from irsim_gym.evaluation.tables import plain, print_table, titled_table, write_csv, write_json
from irsim_gym.outside_files import json_object, reading
from irsim_gym.training.sweep_file import SweepTrial

TABLE, RESULT = "sweep.csv", "result.json"
FIGURES = ("success", "steps", "training_seconds")


def write_result(place: Path, point: Mapping[str, Any]) -> None:
    """Write the last score of a training, which tells that it has ended."""
    write_json(place / RESULT, plain({name: point[name] for name in FIGURES}))


def read_result(place: Path) -> dict[str, Any] | None:
    """Return the result of a training; None where it has not ended."""
    try:
        with reading(place / RESULT, "result of a training"):
            found = json_object(place / RESULT)
            return {**found, "success": float(found["success"])}
    except UnreadableFileError:
        return None


def write_sweep(folder: Path, trials: Sequence[SweepTrial], results: Sequence[Mapping[str, Any]]) -> None:
    """Write ``sweep.csv``, a row for each training."""
    names = _names(trials)
    rows = [
        {"training": number, "seed": trial.seed}
        | {name: _text(trial.condition.get(name, "")) for name in names}
        | {name: result.get(name, "") for name in FIGURES}
        for number, (trial, result) in enumerate(zip(trials, results, strict=True))
    ]
    write_csv(folder / TABLE, ["training", "seed", *names, *FIGURES], rows)


def show_sweep(trials: Sequence[SweepTrial], results: Sequence[Mapping[str, Any]], title: str) -> None:
    """Print a row for each condition, the best one first: its success over the seeds."""
    conditions: dict[str, tuple[SweepTrial, list[float]]] = {}
    for trial, result in zip(trials, results, strict=True):
        key = json.dumps(trial.condition, sort_keys=True, default=str)
        conditions.setdefault(key, (trial, []))[1].append(100.0 * result["success"])
    names = [name for name in _names(trials) if len({_text(one.condition.get(name)) for one in trials}) > 1]
    n_seeds = len({trial.seed for trial in trials})
    table = titled_table(f"{title}: success on dev levels [%], {n_seeds} seeds each")
    for head in (*(names or ["scenario"]), "median", "lowest", "highest"):
        table.add_column(Text(head.replace("_", "_\n").replace(".", ".\n")), justify="right")
    for trial, shares in sorted(conditions.values(), key=lambda one: -median(one[1])):
        values = [_text(trial.condition.get(name, "-")) for name in names or ["scenario"]]
        figures = (f"{share:.1f}" for share in (median(shares), min(shares), max(shares)))
        table.add_row(*map(Text, (*values, *figures)))
    print_table(table)


def _names(trials: Sequence[SweepTrial]) -> list[str]:
    return list(dict.fromkeys(name for trial in trials for name in trial.condition))


def _text(value: object) -> str:
    return json.dumps(value) if isinstance(value, list | dict) else str(value)
