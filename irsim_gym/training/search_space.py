"""What tuning tries: ranges and choices of hyper-parameters and of the weights of rewards, from a YAML file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from irsim_gym.errors import IrsimGymError, ScenarioError, suggestion
from irsim_gym.scenario.messages import show
from irsim_gym.scenario.options import kind, option
from irsim_gym.scenario.source import read_file
from irsim_gym.scenario.validation import Report, build
from irsim_gym.training.hyperparameters import hyperparameters_folder

DIGITS = 4
"""Significant digits of drawn numbers."""
LINEAR = "lin_"
REWARD = "reward."
"""What names of rewards begin with among those of drawn values."""

Values = dict[str, Any]


class DrawsValues(Protocol):
    """What draws values: a trial of Optuna."""

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        """Return a number between two others."""

    def suggest_int(self, name: str, low: int, high: int, *, log: bool = False) -> int:
        """Return a whole number between two others, these included."""

    def suggest_categorical(self, name: str, choices: Sequence[Any]) -> Any:
        """Return one of several values."""


@kind
class Range:
    """Numbers between two others."""

    low: int | float = option(meaning="The least value.")
    high: int | float = option(meaning="The greatest value.")
    log: bool = option(False, meaning="Draw the logarithm evenly.")
    schedule: Literal["linear"] | None = option(None, meaning="The value falls linearly to 0 during the run.")

    def problems(self) -> list[tuple[str, str]]:
        """Return what does not fit together."""
        found = [] if self.low < self.high else [("high", f"must be greater than low, got {show(self.high)}")]
        return [*found, *([("low", "must be > 0 with log: true")] if self.log and self.low <= 0 else [])]

    def draw(self, name: str, trial: DrawsValues) -> Any:
        """Return a value as it stands in a hyper-parameter file."""
        if isinstance(self.low, int) and isinstance(self.high, int):
            found: float = trial.suggest_int(name, self.low, self.high, log=self.log)
        else:
            found = float(f"{trial.suggest_float(name, self.low, self.high, log=self.log):.{DIGITS}g}")
        return self._written(found)

    def ends(self) -> tuple[Any, Any]:
        """Return its least and its greatest value, as they stand in a hyper-parameter file."""
        return self._written(self.low), self._written(self.high)

    def _written(self, number: float) -> Any:
        return f"{LINEAR}{number!r}" if self.schedule == "linear" else number

    def place_of(self, value: object) -> Any:
        """Return what draws a value of a hyper-parameter file.

        Raises:
            ValueError: It is not among those that can be drawn.
        """
        is_linear = isinstance(value, str) and value.startswith(LINEAR)
        number = float(str(value).removeprefix(LINEAR))
        if is_linear != (self.schedule == "linear") or not self.low <= number <= self.high:
            raise ValueError(f"{value} is none of these")
        return int(number) if isinstance(self.low, int) and isinstance(self.high, int) else number


@dataclass(frozen=True)
class Choices:
    """Some values of any kind."""

    values: tuple[Any, ...]

    def draw(self, name: str, trial: DrawsValues) -> Any:
        """Return one of the values."""
        return self._labels()[trial.suggest_categorical(name, list(self._labels()))]

    def ends(self) -> tuple[Any, ...]:
        """Return all values."""
        return self.values

    def place_of(self, value: object) -> Any:
        """Return what draws a value.

        Raises:
            ValueError: It is not among those that can be drawn.
        """
        for label, known in self._labels().items():
            if known == value:
                return label
        raise ValueError(f"{value} is none of these")

    def _labels(self) -> dict[Any, Any]:
        """Return the values by what Optuna knows them by: lists and mappings by their JSON."""
        return {json.dumps(one) if isinstance(one, list | dict) else one: one for one in self.values}


@dataclass(frozen=True)
class SearchSpace:
    """What may be drawn.

    Attributes:
        hyperparameters: By key; those of a mapping with a dot.
        rewards: Factors of the weights of rewards, by their names.
        file: Where it is from.
    """

    hyperparameters: Mapping[str, Range | Choices]
    rewards: Mapping[str, Range]
    file: str

    def draw(self, trial: DrawsValues) -> tuple[Values, Values]:
        """Return hyper-parameters by key, and factors of weights by the names of rewards."""
        drawn = {key: one.draw(key, trial) for key, one in self.hyperparameters.items()}
        return drawn, {name: one.draw(REWARD + name, trial) for name, one in self.rewards.items()}

    def present(self, hyperparameters: Mapping[str, Any]) -> tuple[Values, list[str]]:
        """Return what draws the present settings, and the names of those that cannot be drawn.

        Args:
            hyperparameters: The present ones, as they stand in a file.
        """
        asked: dict[str, tuple[Range | Choices, Any]] = {
            **{key: (one, value_of(hyperparameters, key)) for key, one in self.hyperparameters.items()},
            **{REWARD + name: (one, 1.0) for name, one in self.rewards.items()},
        }
        found, outside = {}, []
        for name, (one, value) in asked.items():
            try:
                found[name] = one.place_of(value)
            except ValueError:
                outside.append(name)
        return found, outside

    def to_plain(self) -> Values:
        """Return it as plain data."""
        parts = {**self.hyperparameters, **{REWARD + name: one for name, one in self.rewards.items()}}
        return {name: list(one.values) if isinstance(one, Choices) else vars(one) for name, one in parts.items()}


def value_of(data: Mapping[str, Any], key: str) -> Any:
    """Return the value of a key, with dots for mappings in mappings; None where there is none."""
    found: Any = data
    for part in key.split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    return found


def with_value(data: Mapping[str, Any], key: str, value: object) -> Values:
    """Return a copy of nested mappings in which a key, with dots, has a value."""
    first, _, rest = key.partition(".")
    inner = data.get(first)
    own = with_value(inner if isinstance(inner, Mapping) else {}, rest, value) if rest else value
    return {**data, first: own}


def shipped_space(algorithm: str) -> Path:
    """Return the file of the shipped space of an algorithm.

    Raises:
        IrsimGymError: There is none.
    """
    folder = hyperparameters_folder() / "spaces"
    file = folder / f"{algorithm}.yaml"
    if not file.is_file():
        known = ", ".join(sorted(one.stem for one in folder.glob("*.yaml")))
        raise IrsimGymError(f"no search space for {algorithm} is shipped (only for {known}): give one with --space")
    return file


def read_space(file: Path) -> SearchSpace:
    """Read a space.

    Raises:
        ScenarioError: It cannot be used; the error lists every problem with its line.
    """
    source = read_file(file)
    report = Report(source)
    report.refuse_repeats()
    data = source.data if isinstance(source.data, Mapping) else {}
    parts = ("hyperparameters", "rewards")
    if not data or not isinstance(source.data, Mapping):
        report.add((), f"must be a mapping with {' and '.join(parts)}, got {show(source.data)}")
    for key in data:
        if key not in parts:
            report.add((key,), f"must be {' or '.join(parts)}{suggestion(str(key), parts)}")
    hyperparameters, rewards = (_entries(part, data.get(part), report) for part in parts)
    if report.problems:
        raise ScenarioError(source.title, list(report.problems))
    return SearchSpace(
        hyperparameters, {name: one for name, one in rewards.items() if isinstance(one, Range)}, str(file)
    )


def _entries(part: str, data: object, report: Report) -> dict[str, Range | Choices]:
    """Return what one part of the file says."""
    if data is None:
        return {}
    if not isinstance(data, Mapping):
        report.add((part,), f"must be a mapping, got {show(data)}")
        return {}
    found: dict[str, Range | Choices] = {}
    for key, value in data.items():
        place = (part, key)
        if isinstance(value, list) and part == "hyperparameters":
            if len(value) < 2:
                report.add(place, f"needs at least two choices, got {show(value)}")
            found[key] = Choices(tuple(value))
            continue
        made = build(Range, value, place, report)
        if made is None:
            continue
        if part == "rewards":
            if made.low < 0 or made.schedule is not None:
                report.add(place, "is a factor >= 0 of the weight, without a schedule")
            made = replace(made, low=float(made.low), high=float(made.high))
        found[key] = made
    return found
