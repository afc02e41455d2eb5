"""What a sweep trains: every combination of seeds, hyper-parameters, weights of rewards, scenarios and parameters."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError, ScenarioError
from irsim_gym.scenario.messages import show
from irsim_gym.scenario.validation import Report
from irsim_gym.training.hyperparameters import TEAM_MODES
from irsim_gym.training.training_request import TrainingRequest
from irsim_gym.training.trial_settings import write_settings

LISTS = ("hyperparameters", "rewards", "parameters")
"""Mappings of a key to one value or a list of values."""
KEYS = ("scenario", "algorithm", "task", "file", "team", "steps", "seeds", "dev_levels", *LISTS)
MOST_TRIALS = 10_000
Values = dict[str, Any]


@dataclass(frozen=True)
class SweepTrial:
    """One training of a sweep.

    Attributes:
        scenario: Name, id or path.
        seed: Its seed.
        hyperparameters: Values by key, with dots for mappings in mappings.
        rewards: Factors of the weights of rewards.
        parameters: Values of the scenario's parameters.
    """

    scenario: str
    seed: int
    hyperparameters: Mapping[str, Any]
    rewards: Mapping[str, float]
    parameters: Mapping[str, Any]

    @property
    def condition(self) -> Values:
        """What it has in common with those of other seeds, by the names of the table's columns."""
        factors = {f"reward.{name}": factor for name, factor in self.rewards.items()}
        return {"scenario": self.scenario, **self.parameters, **self.hyperparameters, **factors}


@dataclass(frozen=True)
class Sweep:
    """What a sweep file says.

    Attributes:
        file: The file.
        scenarios: Names, ids or paths.
        algorithm: As ``--algorithm`` takes it.
        task: Task in place of the scenarios' own.
        base: File of hyper-parameters in place of the shipped one.
        team: The mode of teams; None where one robot learns.
        steps: Training steps; None for those of the hyper-parameters.
        seeds: Seeds.
        dev_levels: Levels of ``dev`` that checkpoints are scored on.
        lists: Values by part (``LISTS``) and key.
    """

    file: str
    scenarios: tuple[str, ...]
    algorithm: str
    task: str | None
    base: str | None
    team: str | None
    steps: int | None
    seeds: tuple[int, ...]
    dev_levels: int
    lists: Mapping[str, Mapping[str, tuple[Any, ...]]]

    def asked(self, trial: SweepTrial) -> TrainingRequest:
        """Return what a trial trains, apart from its hyper-parameters and rewards."""
        return TrainingRequest(
            trial.scenario,
            self.algorithm,
            trial.seed,
            self.steps,
            self.task,
            None if self.base is None else Path(self.base),
            self.team,
            dict(trial.parameters),
        )

    def trials(self) -> list[SweepTrial]:
        """Return all trainings, those with the same condition beside each other."""
        found = []
        for scenario in self.scenarios:
            for combination in itertools.product(*(_combinations(self.lists[part]) for part in LISTS)):
                chosen = dict(zip(LISTS, combination, strict=True))
                found += [SweepTrial(scenario, seed, **chosen) for seed in self.seeds]
        return found


def _combinations(lists: Mapping[str, Sequence[Any]]) -> list[Values]:
    return [dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())]


def read_sweep(file: Path) -> Sweep:
    """Read a sweep file, and try each of its values.

    Raises:
        ScenarioError: It cannot be used; the error lists every problem with its line and key.
    """
    report = Report.of_file(file)
    data = report.mapping
    if not data:
        report.add((), f"must be a mapping with the key 'scenario', got {show(report.source.data)}")
    report.refuse_unknown(data, KEYS)
    sweep = Sweep(
        str(file),
        _scenarios(data.get("scenario"), report) if data else (),
        _text("algorithm", data, report) or "ppo",
        _text("task", data, report),
        _text("file", data, report),
        _text("team", data, report, TEAM_MODES),
        _whole("steps", data, report, None),
        _seeds(data.get("seeds", [0]), report),
        _whole("dev_levels", data, report, 300) or 300,
        {part: _lists(part, data.get(part), report) for part in LISTS},
    )
    if not report.problems:
        _try_values(sweep, report)
    report.check()
    return sweep


def _scenarios(value: object, report: Report) -> tuple[str, ...]:
    names = value if isinstance(value, list) else [value]
    if names and all(isinstance(name, str) for name in names):
        return tuple(names)
    report.add(("scenario",), f"must be the name or path of a scenario, or a list of these, got {show(value)}")
    return ()


def _text(key: str, data: Mapping[str, Any], report: Report, known: Sequence[str] = ()) -> str | None:
    value = data.get(key)
    if value is None or (isinstance(value, str) and (not known or value in known)):
        return value
    report.add((key,), f"must be {' or '.join(known) if known else 'text'}, got {show(value)}")
    return None


def _whole(key: str, data: Mapping[str, Any], report: Report, usual: int | None) -> int | None:
    value = data.get(key, usual)
    if value is None or (isinstance(value, int) and not isinstance(value, bool) and value >= 1):
        return value
    report.add((key,), f"must be a whole number >= 1, got {show(value)}")
    return usual


def _seeds(value: object, report: Report) -> tuple[int, ...]:
    """Return the seeds: a list of them, or how many, from 0 on."""
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return tuple(range(value))
    if isinstance(value, list) and value and all(type(one) is int and one >= 0 for one in value):
        found = tuple(value)
        if len(set(found)) == len(found):
            return found
    report.add(("seeds",), f"must be a list of different seeds >= 0, or how many, got {show(value)}")
    return ()


def _lists(part: str, data: object, report: Report) -> Mapping[str, tuple[Any, ...]]:
    """Return the values of each key; a single value is a list of one."""
    if data is None:
        return {}
    if not isinstance(data, Mapping):
        report.add((part,), f"must be a mapping of keys to values or lists of values, got {show(data)}")
        return {}
    found = {}
    for key, value in data.items():
        values = value if isinstance(value, list) else [value]
        if not values:
            report.add((part, key), "needs at least one value")
        for one in values if part == "rewards" else ():
            if isinstance(one, bool) or not isinstance(one, int | float) or one < 0:
                report.add((part, key), f"is a factor >= 0 of the weight, or a list of these, got {show(one)}")
        found[key] = tuple(values)
    return found


def _try_values(sweep: Sweep, report: Report) -> None:
    """Make the settings of each value by itself."""
    n_trials = len(sweep.trials())
    if n_trials > MOST_TRIALS:
        report.add((), f"makes {n_trials:,} trainings; {MOST_TRIALS:,} at most")
        return
    for scenario in sweep.scenarios:
        for place, chosen in _one_by_one(sweep):
            trial = SweepTrial(scenario, sweep.seeds[0], **chosen)
            for message in _problems(sweep, trial):
                report.add(place, message)


def _one_by_one(sweep: Sweep) -> Iterator[tuple[tuple[str, ...], Mapping[str, Values]]]:
    """Yield the place of each value, and what a trial has that has only this one; first of one that has none."""
    none: Mapping[str, Values] = {part: {} for part in LISTS}
    yield ("scenario",), none
    for part, lists in sweep.lists.items():
        for key, values in lists.items():
            for value in values:
                yield (part, key), {**none, part: {key: value}}


def _problems(sweep: Sweep, trial: SweepTrial) -> list[str]:
    """Return what is wrong with the settings of a trial."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            asked = sweep.asked(trial)
            values = dict(trial.hyperparameters), dict(trial.rewards)
            write_settings(Path(folder), asked, asked.settings(), *values).settings()
    except ScenarioError as error:
        return [problem.message for problem in error.problems]
    except IrsimGymError as error:
        return [str(error)]
    return []
