"""The search space of a tuning: ranges and choices of hyper-parameters and reward weights, from a YAML file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

from irsim_gym.errors import IrsimGymError, suggestion
from irsim_gym.scenario.messages import show
from irsim_gym.scenario.options import kind, option, option_fields
from irsim_gym.scenario.source import Place
from irsim_gym.scenario.validation import Report, build
from irsim_gym.training.algorithm_options import AlgorithmKeys, PolicyKeys, RunKeys
from irsim_gym.training.hyperparameters import hyperparameters_folder

DIGITS = 4
"""Significant digits of drawn numbers."""
LINEAR = "lin_"
"""Prefix of a linear schedule in a hyper-parameter file."""
REWARD = "reward."
"""Prefix of the names of rewards among the parameters of a trial."""
DECLARED: Mapping[str, tuple[type[Any], ...]] = {"": (RunKeys, AlgorithmKeys), "policy_kwargs": (PolicyKeys,)}
"""Tables of the hyper-parameters, by the mapping in which they stand."""

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
    """A range of numbers. If both limits are integers, all values are."""

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
        found: float
        if isinstance(self.low, int) and isinstance(self.high, int):
            found = trial.suggest_int(name, self.low, self.high, log=self.log)
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
        is_whole = isinstance(self.low, int) and isinstance(self.high, int)
        is_between = self.low <= number <= self.high and (number.is_integer() or not is_whole)
        if is_linear != (self.schedule == "linear") or not is_between:
            raise ValueError(f"{value} is none of these")
        return int(number) if is_whole else number


@dataclass(frozen=True)
class Choices:
    """A set of values of any kind."""

    values: tuple[Any, ...]

    def draw(self, name: str, trial: OptunaTrial) -> Any:
        """Draw one of the values."""
        labels = self._labels()
        return labels[trial.suggest_categorical(name, list(labels))]

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

    def repeats(self) -> Iterator[tuple[int, Any]]:
        """Yield the index of each value that equals an earlier one, or has its label, with the earlier one."""
        for i, value in enumerate(self.values):
            for earlier in self.values[:i]:
                if value == earlier or _label(value) == _label(earlier):
                    yield i, earlier
                    break

    def _labels(self) -> dict[Any, Any]:
        """Return the values by their labels in Optuna."""
        return {_label(one): one for one in self.values}


def _label(value: object) -> Any:
    """Return the label of a choice in Optuna: a JSON text for a list or mapping, else the value itself."""
    return json.dumps(value) if isinstance(value, list | dict) else value


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
    if not hyperparameters and not rewards and not report.problems:
        report.add((), f"is empty: give {' or '.join(parts)} a range or choices")
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
        made: Range | Choices | None
        if part == "rewards":
            made = _factors(value, (part, key), report)
        elif isinstance(value, list):
            made = _choices(value, (part, key), report)
        else:
            made = _range(value, (part, key), report)
        if made is not None:
            found[key] = made
    return found


def _factors(value: object, place: Place, report: Report) -> Range | None:
    """Return the range of factors on the weight of a reward; None after reporting problems."""
    made = build(Range, value, place, report)
    if made is None:
        return None
    if made.low < 0 or made.schedule is not None:
        report.add(place, "is a factor >= 0 of the weight, without a schedule")
    return replace(made, low=float(made.low), high=float(made.high))


def _choices(values: list[Any], place: Place, report: Report) -> Choices:
    """Return the choices of a hyper-parameter, after reporting problems."""
    made = Choices(tuple(values))
    if len(values) < 2:
        report.add(place, f"needs at least two choices, got {show(values)}")
    for i, earlier in made.repeats():
        report.add((*place, i), f"must differ from the other choices, got {show(values[i])} beside {show(earlier)}")
    return made


def _range(value: object, place: Place, report: Report) -> Range | None:
    """Return the range of a hyper-parameter, with limits of its type; None after reporting problems."""
    made = build(Range, value, place, report)
    wanted = _number_type(str(place[-1]))
    if made is None or wanted is None:
        return made
    limits: dict[str, int | float] = {"low": made.low, "high": made.high}
    broken = [key for key, limit in limits.items() if wanted is int and limit != int(limit)]
    for key in broken:
        report.add((*place, key), f"must be a whole number, got {show(limits[key])}")
    return None if broken else replace(made, low=wanted(made.low), high=wanted(made.high))


def _number_type(name: str) -> type[int] | type[float] | None:
    """Return the type of the numbers that a hyper-parameter takes; None if none is declared."""
    mapping, _, key = name.rpartition(".")
    if mapping == "normalize":
        return float
    for table in DECLARED.get(mapping, ()):
        if key in option_fields(table):
            hint = option_fields(table)[key].annotation
            hints = get_args(hint) or (hint,)
            return int if int in hints else float if float in hints else None
    return None
