"""The search space of a tuning: ranges and choices of hyper-parameters and reward weights, from a YAML file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from irsim_gym.errors import IrsimGymError, suggestion
from irsim_gym.scenario.messages import show
from irsim_gym.scenario.options import kind, option
from irsim_gym.scenario.validation import Report, build
from irsim_gym.training.hyperparameters import hyperparameters_folder

DIGITS = 4
"""Significant digits of drawn numbers."""
LINEAR = "lin_"
"""Prefix of a linear schedule in a hyper-parameter file."""
REWARD = "reward."
"""Prefix of the names of rewards among the parameters of a trial."""

Values = dict[str, Any]


class OptunaTrial(Protocol):
    """The methods of a trial of Optuna that draw parameters."""

    def suggest_float(self, name: str, low: float, high: float, *, log: bool = False) -> float:
        """Return a number from ``low`` to ``high``."""

    def suggest_int(self, name: str, low: int, high: int, *, log: bool = False) -> int:
        """Return an integer from ``low`` to ``high``, both included."""

    def suggest_categorical(self, name: str, choices: Sequence[Any]) -> Any:
        """Return one of the choices."""


@kind
class Range:
    """A range of numbers."""

    low: int | float = option(meaning="The smallest value.")
    high: int | float = option(meaning="The largest value.")
    log: bool = option(False, meaning="Draw the logarithm evenly.")
    schedule: Literal["linear"] | None = option(None, meaning="The value falls linearly to 0 during the run.")

    def problems(self) -> list[tuple[str, str]]:
        """Return the contradictions between the options, each with its key."""
        found = [] if self.low < self.high else [("high", f"must be greater than low, got {show(self.high)}")]
        return [*found, *([("low", "must be > 0 with log: true")] if self.log and self.low <= 0 else [])]

    def draw(self, name: str, trial: OptunaTrial) -> Any:
        """Draw a value, and return it as a hyper-parameter file contains it."""
        if isinstance(self.low, int) and isinstance(self.high, int):
            found: float = trial.suggest_int(name, self.low, self.high, log=self.log)
        else:
            found = float(f"{trial.suggest_float(name, self.low, self.high, log=self.log):.{DIGITS}g}")
        return self._written(found)

    def ends(self) -> tuple[Any, Any]:
        """Return the smallest and the largest value, as a hyper-parameter file contains them."""
        return self._written(self.low), self._written(self.high)

    def _written(self, number: float) -> Any:
        return f"{LINEAR}{number!r}" if self.schedule == "linear" else number

    def to_parameter(self, value: object) -> Any:
        """Return the trial's parameter that yields a value of a hyper-parameter file.

        Raises:
            ValueError: If the value is not in the range.
        """
        is_linear = isinstance(value, str) and value.startswith(LINEAR)
        number = float(str(value).removeprefix(LINEAR))
        if is_linear != (self.schedule == "linear") or not self.low <= number <= self.high:
            raise ValueError(f"{value} is none of these")
        return int(number) if isinstance(self.low, int) and isinstance(self.high, int) else number


@dataclass(frozen=True)
class Choices:
    """A set of values of any kind."""

    values: tuple[Any, ...]

    def draw(self, name: str, trial: OptunaTrial) -> Any:
        """Draw one of the values."""
        return self._labels()[trial.suggest_categorical(name, list(self._labels()))]

    def ends(self) -> tuple[Any, ...]:
        """Return all values."""
        return self.values

    def to_parameter(self, value: object) -> Any:
        """Return the trial's parameter that yields a value.

        Raises:
            ValueError: If the value is not among the choices.
        """
        for label, known in self._labels().items():
            if known == value:
                return label
        raise ValueError(f"{value} is none of these")

    def _labels(self) -> dict[Any, Any]:
        """Return the values by their labels in Optuna, which are JSON texts for lists and mappings."""
        return {json.dumps(one) if isinstance(one, list | dict) else one: one for one in self.values}


@dataclass(frozen=True)
class SearchSpace:
    """The search space of a tuning.

    Attributes:
        hyperparameters: Ranges and choices of hyper-parameters by key; dots separate the keys of nested mappings.
        rewards: Ranges of factors on the weights of rewards, by reward.
        file: Path of the file.
    """

    hyperparameters: Mapping[str, Range | Choices]
    rewards: Mapping[str, Range]
    file: str

    def draw(self, trial: OptunaTrial) -> tuple[Values, Values]:
        """Draw hyper-parameters by key, and factors on weights by reward."""
        drawn = {key: one.draw(key, trial) for key, one in self.hyperparameters.items()}
        return drawn, {name: one.draw(REWARD + name, trial) for name, one in self.rewards.items()}

    def to_parameters(self, hyperparameters: Mapping[str, Any]) -> tuple[Values, list[str]]:
        """Return the trial's parameters that yield the current settings, and the names of those outside the space.

        Args:
            hyperparameters: Current hyper-parameters, as a file contains them.
        """
        current: dict[str, tuple[Range | Choices, Any]] = {
            **{key: (one, value_of(hyperparameters, key)) for key, one in self.hyperparameters.items()},
            **{REWARD + name: (one, 1.0) for name, one in self.rewards.items()},
        }
        found, outside = {}, []
        for name, (one, value) in current.items():
            try:
                found[name] = one.to_parameter(value)
            except ValueError:
                outside.append(name)
        return found, outside

    def to_plain(self) -> Values:
        """Return the space as plain data."""
        parts = {**self.hyperparameters, **{REWARD + name: one for name, one in self.rewards.items()}}
        return {name: list(one.values) if isinstance(one, Choices) else vars(one) for name, one in parts.items()}


def value_of(data: Mapping[str, Any], key: str) -> Any:
    """Return the value of a dotted key in nested mappings; None if there is none."""
    found: Any = data
    for part in key.split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    return found


def with_value(data: Mapping[str, Any], key: str, value: object) -> Values:
    """Return a copy of nested mappings in which a dotted key has the given value."""
    first, _, rest = key.partition(".")
    inner = data.get(first)
    own = with_value(inner if isinstance(inner, Mapping) else {}, rest, value) if rest else value
    return {**data, first: own}


def shipped_space(algorithm: str) -> Path:
    """Return the file of the shipped search space of an algorithm.

    Raises:
        IrsimGymError: If no space is shipped for the algorithm.
    """
    folder = hyperparameters_folder() / "spaces"
    file = folder / f"{algorithm}.yaml"
    if not file.is_file():
        known = ", ".join(sorted(one.stem for one in folder.glob("*.yaml")))
        raise IrsimGymError(f"no search space for {algorithm} is shipped (only for {known}): give one with --space")
    return file


def read_space(file: Path) -> SearchSpace:
    """Read a search space from a YAML file.

    Raises:
        ScenarioError: If the file is invalid. The message lists every problem with its line.
    """
    report = Report.of_file(file)
    data = report.mapping
    parts = ("hyperparameters", "rewards")
    if not data:
        report.add((), f"must be a mapping with {' and '.join(parts)}, got {show(report.source.data)}")
    for key in data:
        if key not in parts:
            report.add((key,), f"must be {' or '.join(parts)}{suggestion(str(key), parts)}")
    hyperparameters, rewards = (_entries(part, data.get(part), report) for part in parts)
    report.check()
    return SearchSpace(
        hyperparameters, {name: one for name, one in rewards.items() if isinstance(one, Range)}, str(file)
    )


def _entries(part: str, data: object, report: Report) -> dict[str, Range | Choices]:
    """Return the ranges and choices of one section of the file."""
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
