"""The search space of a tuning: ranges and lists of values for all that trials may change, from a YAML file."""

import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.options import kind, option, option_fields
from irsim_gym.scenario.checking.validation import Report, build
from irsim_gym.scenario.text.messages import show
from irsim_gym.training.settings.algorithm_options import AlgorithmKeys, PolicyKeys, RunKeys
from irsim_gym.training.settings.hyperparameters import hyperparameters_folder

DIGITS = 4
"""Significant digits of drawn numbers."""
LINEAR = "lin_"
"""Prefix of a linear schedule in a hyper-parameter file."""
PARTS = {"hyperparameters": "", "rewards": "reward.", "parameters": "parameter.", "seeds": "seed"}
"""Prefix of the names of parameters of a trial, by section of the file."""
MOST_TRIALS = 10_000
"""Largest number of combinations of a grid."""
DECLARED: Mapping[str, tuple[type[Any], ...]] = {"": (RunKeys, AlgorithmKeys), "policy_kwargs": (PolicyKeys,)}
"""Tables of the hyper-parameters, by the mapping in which they stand."""

Axis = tuple[str, ...]
"""Section of the file, and the key in it; ``("scenario",)`` and ``("seeds",)`` have no key."""


@kind
class Range:
    """A range of numbers. If both limits are integers, all values are."""

    low: int | float = option(meaning="The smallest value.")
    high: int | float = option(meaning="The largest value.")
    log: bool = option(False, meaning="Draw the logarithm evenly.")
    schedule: Literal["linear"] | None = option(None, meaning="The value falls linearly to 0 during the run.")

    def problems(self) -> list[tuple[str, str]]:
        """Return the contradictions between the options, each with its key."""
        problems = [] if self.low < self.high else [("high", f"must be greater than low, got {show(self.high)}")]
        return [*problems, *([("low", "must be > 0 with log: true")] if self.log and self.low <= 0 else [])]

    def ends(self) -> tuple[Any, ...]:
        """Return the smallest and the largest value, as a hyper-parameter file contains them."""
        return self._written(self.low), self._written(self.high)

    def draw(self, name: str, trial: Any) -> Any:
        """Let a trial of Optuna draw a value, and return it as a hyper-parameter file contains it."""
        if isinstance(self.low, int):
            return self._written(trial.suggest_int(name, self.low, self.high, log=self.log))
        return self._written(float(f"{trial.suggest_float(name, self.low, self.high, log=self.log):.{DIGITS}g}"))

    def _written(self, number: float) -> Any:
        return number if self.schedule is None else f"{LINEAR}{number!r}"


@dataclass(frozen=True)
class Choices:
    """A list of values of any kind."""

    values: tuple[Any, ...]

    @property
    def labels(self) -> list[Any]:
        """The values as Optuna knows them: a JSON text for a list or mapping, else the value itself."""
        return [json.dumps(value) if isinstance(value, list | dict) else value for value in self.values]

    def ends(self) -> tuple[Any, ...]:
        """Return all values."""
        return self.values

    def draw(self, name: str, trial: Any) -> Any:
        """Let a trial of Optuna draw one of the values."""
        return self.values[self.labels.index(trial.suggest_categorical(name, self.labels))]


@dataclass(frozen=True)
class SearchSpace:
    """The search space of a tuning.

    Attributes:
        axes: Ranges and lists of values. Dots in keys of hyper-parameters separate the keys of nested mappings.
        file: Path of the file.
    """

    axes: Mapping[Axis, Range | Choices]
    file: str

    def draw(self, trial: Any) -> dict[Axis, Any]:
        """Let a trial of Optuna draw a value for each axis, and return the values as files contain them."""
        return {axis: domain.draw(name_of(axis), trial) for axis, domain in self.axes.items()}

    def grid(self) -> list[dict[str, Any]]:
        """Return the parameters of a trial for each combination of lists; the last axis changes fastest."""
        lists = {name_of(axis): domain.labels for axis, domain in self.axes.items() if isinstance(domain, Choices)}
        return [dict(zip(lists, point, strict=True)) for point in itertools.product(*lists.values())]


def name_of(axis: Axis) -> str:
    """Return the name of the parameter of a trial."""
    return "".join((PARTS.get(axis[0], axis[0]), *axis[1:]))


def shipped_space(algorithm: str) -> Path:
    """Return the file of the shipped search space of an algorithm.

    Raises:
        IrsimGymError: If no space is shipped for the algorithm.
    """
    files = {file.stem: file for file in sorted((hyperparameters_folder() / "spaces").glob("*.yaml"))}
    if algorithm not in files:
        shipped = ", ".join(files)
        raise IrsimGymError(f"no search space for {algorithm} is shipped (only for {shipped}): give one with --space")
    return files[algorithm]


def read_space(file: Path, scenarios: Sequence[str] = (), *, grid: bool = False) -> SearchSpace:
    """Read a search space from a YAML file.

    Args:
        scenarios: Scenarios of the trials, a further axis if there are several.
        grid: Refuse ranges, and too many combinations.

    Raises:
        ScenarioError: If the file is invalid. The message lists every problem with its line.
    """
    report, axes = Report.of_file(file), dict[Axis, Range | Choices]()
    if not report.mapping:
        report.add((), f"must be a mapping with {', '.join(PARTS)}, got {show(report.source.data)}")
    report.refuse_unknown(report.mapping, tuple(PARTS))
    if len(scenarios) > 1:
        axes["scenario",] = Choices(tuple(scenarios))
    for axis, value in _entries(report):
        domain = _range(value, axis, report) if isinstance(value, Mapping) else _choices(value, axis, report)
        if domain is not None:
            axes[axis] = domain
            _check_values(domain, axis, report)
        if grid and not isinstance(domain, Choices):
            report.add(axis, "is a range: --grid needs a value or a list of values")
    if not axes and not report.problems:
        report.add((), f"is empty: give {' or '.join(PARTS)} a range or values")
    size = math.prod(len(domain.ends()) for domain in axes.values())
    if grid and size > MOST_TRIALS:
        report.add((), f"makes {size:,} trials; {MOST_TRIALS:,} at most")
    report.check()
    return SearchSpace(axes, str(file))


def _entries(report: Report) -> Iterator[tuple[Axis, object]]:
    """Yield the axes of a file, the seeds last."""
    for part in (part for part in PARTS if report.mapping.get(part) is not None):
        section = report.mapping[part]
        if part == "seeds":
            yield (part,), [*range(section)] if type(section) is int else section
        elif isinstance(section, Mapping):
            yield from (((part, str(key)), value) for key, value in section.items())
        else:
            report.add((part,), f"must be a mapping, got {show(section)}")


def _check_values(domain: Range | Choices, axis: Axis, report: Report) -> None:
    for value in domain.ends():
        if axis[0] == "rewards" and (type(value) not in (int, float) or value < 0):
            report.add(axis, f"is a factor >= 0 of the weight, without a schedule, got {show(value)}")
        if axis[0] == "seeds" and (type(value) is not int or value < 0):
            report.add(axis, f"must be a list of seeds >= 0, or how many, got {show(value)}")


def _choices(value: object, axis: Axis, report: Report) -> Choices:
    """Return the values of an axis, after reporting problems. Optuna would mix up values that are equal."""
    domain = Choices(tuple(value) if isinstance(value, list) else (value,))
    if not domain.values:
        report.add(axis, "needs at least one value")
    for i, label in enumerate(domain.labels):
        if domain.labels.index(label) < i:
            report.add((*axis, i), f"must differ from the other values, got {show(domain.values[i])} again")
    return domain


def _range(value: object, axis: Axis, report: Report) -> Range | None:
    """Return the range of an axis; None after reporting problems. Its numbers are whole if both limits are.

    That a hyper-parameter takes numbers with a fraction counts for more than how the file writes them.
    """
    domain, (mapping, _, key) = build(Range, value, axis, report), axis[-1].rpartition(".")
    if domain is None:
        return None
    tables = DECLARED.get(mapping, ()) if axis[0] == "hyperparameters" else ()
    declared = [fields[key].annotation for fields in map(option_fields, tables) if key in fields]
    is_whole = type(domain.low) is type(domain.high) is int and axis[0] != "rewards" and mapping != "normalize"
    if is_whole and not any(float in (get_args(hint) or (hint,)) for hint in declared):
        return domain
    return replace(domain, low=float(domain.low), high=float(domain.high))
