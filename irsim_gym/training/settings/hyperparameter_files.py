"""Hyper-parameter files, and their validation, which reports all problems at once with lines and suggestions."""

import functools
import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError, ScenarioError, nearest, suggestion
from irsim_gym.base.options import option_fields
from irsim_gym.evaluation.saved_policies.algorithms import ALGORITHMS, Algorithm
from irsim_gym.scenario.checking.validation import Report, read_field
from irsim_gym.scenario.text.composer import Fatal, compose
from irsim_gym.scenario.text.expressions import evaluate
from irsim_gym.scenario.text.messages import choices, show
from irsim_gym.scenario.text.source import Place, Source
from irsim_gym.training.settings import algorithm_options as declared

DEFAULT = "default"
MAX_NAMES = 24
"""Largest number of known arguments that a message lists."""
SWITCHES = ("training", "norm_obs", "norm_reward")
"""Boolean arguments of VecNormalize."""
_ENTRY = re.compile(r"irsim_gym/[^/]+-v0(/[^/]+)?")
_PLAIN_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
_DEVICE = re.compile(r"auto|cpu|mps|cuda(:\d+)?")


def read_hyperparameters(
    file: Path, algorithm: Algorithm, environment_id: str, task: str | None, below: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the hyper-parameters of a file for an environment and a task, laid over others.

    The entry of the environment overrides ``default``, and the entry ``ID/TASK`` overrides both.

    Args:
        file: Path of the YAML file. All its entries are checked.
        algorithm: The algorithm that the file is for.
        environment_id: Name of the environment's entry.
        task: Name of the task; None for the scenario's own, which has no entry.
        below: Values that those of the file replace, key by key.

    Raises:
        ScenarioError: If the file is invalid. The message lists every problem with its line.
    """
    report = Report.of_file(file)
    entries = {name: _entry(name, entry, algorithm, report) for name, entry in report.mapping.items()}
    if not isinstance(report.source.data, Mapping):
        report.add((), f"must be a mapping with the entry '{DEFAULT}', got {show(report.source.data)}")
    names = [DEFAULT, environment_id] if task is None else [DEFAULT, environment_id, f"{environment_id}/{task}"]
    present = [name for name in names if name in entries]
    chosen = {**below, **{key: value for name in present for key, value in entries[name].items()}}
    if not report.problems:
        _check_together(chosen, algorithm, present[-1] if present else DEFAULT, report)
    report.check()
    return chosen


def change_hyperparameters(
    chosen: Mapping[str, Any], changes: Mapping[str, object], algorithm: Algorithm
) -> dict[str, Any]:
    """Return hyper-parameters with single changes, as ``--hp KEY=VALUE`` gives them.

    Args:
        chosen: The hyper-parameters.
        changes: Values, text as YAML, by key; a dotted key such as ``policy_kwargs.net_arch`` is inside of a mapping.
        algorithm: The algorithm that they are for.

    Raises:
        ScenarioError: If a change is invalid. The message lists every problem.
    """
    changed, report = dict(chosen), Report(Source("--hp", {}))
    for key, value in changes.items():
        try:
            changed = with_value(changed, key, compose(value).data if isinstance(value, str) else value)
        except Fatal as error:
            report.add((DEFAULT, key), f"{error}: got {show(value)}")
    keys = dict.fromkeys(key.split(".")[0] for key in changes)
    values = _entry(DEFAULT, {key: changed[key] for key in keys if key in changed}, algorithm, report)
    if not report.problems:
        _check_together({**changed, **values}, algorithm, DEFAULT, report)
    if report.problems:
        problems = [replace(problem, path=problem.path.removeprefix(f"{DEFAULT}.")) for problem in report.problems]
        raise ScenarioError("--hp", problems)
    return {**changed, **values}


def with_value(data: Mapping[str, Any], key: str, value: object) -> dict[str, Any]:
    """Return a copy of nested mappings in which a dotted key has the given value."""
    first, _, rest = key.partition(".")
    inner = data.get(first)
    below = with_value(inner if isinstance(inner, Mapping) else {}, rest, value) if rest else value
    return {**data, first: below}


def _entry(name: str, entry: object, algorithm: Algorithm, report: Report) -> dict[str, Any]:
    """Return the checked values of one entry."""
    if name != DEFAULT and not _ENTRY.fullmatch(name):
        is_key = name in option_fields(declared.RunKeys) or name in _arguments(algorithm)
        others = [DEFAULT, re.sub(r"-v\d+(?=/|$)", "-v0", name)] if "/" in name else [DEFAULT]
        hint = f" (it belongs below '{DEFAULT}:')" if is_key else suggestion(name, others)
        report.add((name,), f"no entry{hint}; entries are '{DEFAULT}', ids such as irsim_gym/maze-v0, and ID/TASK")
        if is_key:
            return {}
    if not isinstance(entry, Mapping):
        report.add((name,), f"must be a mapping of hyper-parameters, got {show(entry)}")
        return {}
    run_keys, arguments = option_fields(declared.RunKeys), _arguments(algorithm)
    values: dict[str, Any] = {}
    for key, value in entry.items():
        place: Place = (name, key)
        if key in run_keys:
            values[key] = _own_value(key, value, place, report)
        elif key in declared.GIVEN_ELSEWHERE:
            report.add(place, declared.GIVEN_ELSEWHERE[key])
        elif key.endswith("_class"):
            report.add(place, declared.NOT_IN_FILES)
        elif key == "policy_kwargs":
            values[key] = _policy(value, algorithm, place, report)
        elif key in arguments:
            values[key] = _argument(key, value, algorithm, place, report)
        else:
            report.add(place, _unknown(key, [*run_keys, *arguments], algorithm))
    return values


def _unknown(key: str, keys: list[str], algorithm: Algorithm) -> str:
    others = [other.name for other in ALGORITHMS.values() if other is not algorithm and key in _arguments(other)]
    if others:
        return f"is a key of {', '.join(others)}, not of {algorithm.name}"
    near = nearest(key, keys)
    if near is not None:
        return f"unknown key (did you mean '{near}'?)"
    return f"unknown key of {algorithm.name}; known: {', '.join(sorted(keys))}"


@functools.cache
def _arguments(algorithm: Algorithm) -> tuple[str, ...]:
    """Return the arguments of an algorithm that a file may set; none if the algorithm is not installed."""
    try:
        parameters = inspect.signature(algorithm.load()).parameters
    except IrsimGymError:  # its package is missing
        return ()
    left_out = {*declared.GIVEN_ELSEWHERE, "device"}
    return tuple(name for name in parameters if name not in left_out and not name.endswith("_class"))


def _own_value(key: str, value: object, place: Place, report: Report) -> Any:
    if key == "normalize":
        return _normalize(value, place, report)
    info = option_fields(declared.RunKeys)[key]
    checked_value = read_field(info, _whole(value) if info.annotation is int else value, place, report)
    if key == "device" and isinstance(checked_value, str) and not _DEVICE.fullmatch(checked_value):
        report.add(place, _no_device(checked_value))
    return checked_value


def check_device(name: str) -> None:
    """Check the name of a device of PyTorch; whether it is there is not checked.

    Raises:
        IrsimGymError: If it is no such name.
    """
    if not _DEVICE.fullmatch(name):
        raise IrsimGymError(f"device {_no_device(name)}")


def _no_device(name: str) -> str:
    near = suggestion("cuda" if name.lower() == "gpu" else name, ["auto", "cpu", "cuda", "mps"])
    return f"must be auto, cpu, cuda, cuda:1 (and so on) or mps, got {show(name)}{near}"


def _argument(key: str, value: object, algorithm: Algorithm, place: Place, report: Report) -> Any:
    """Return an argument of the algorithm, as plain data."""
    info = option_fields(declared.AlgorithmKeys).get(key)
    if info is None:
        return value  # new in the library, or a mapping that the library checks itself
    if key == "train_freq":
        return _train_freq(value, place, report)
    if isinstance(value, str) and key in declared.SCHEDULES and evaluate(value) is None:
        return _schedule(value, place, report)
    if isinstance(value, str) and key in declared.AUTOMATIC and evaluate(value) is None:
        return _automatic(key, value, algorithm, place, report)
    is_whole = info.annotation is int
    return read_field(info, _whole(value) if is_whole else _number(value), place, report)


def _whole(value: object) -> Any:
    """Convert a whole number in another form, such as ``1e6``, which YAML reads as text, to an int."""
    number = evaluate(value) if isinstance(value, str) else value
    return int(number) if isinstance(number, float) and number.is_integer() else value


def _number(value: object) -> Any:
    """Convert a number that YAML reads as text, such as ``1e-3``; return other values unchanged."""
    number = evaluate(value) if isinstance(value, str) else None
    return value if number is None else number


def _schedule(value: str, place: Place, report: Report) -> Any:
    kind, _, number = value.rpartition("_")
    is_number = _PLAIN_NUMBER.fullmatch(number) is not None and float(number) > 0
    if kind == "lin" and is_number:
        return value
    near = f" (did you mean 'lin_{number}'?)" if kind and is_number else ""
    report.add(place, f"must be a number > 0, or lin_<number> for a linear fall to 0, got {show(value)}{near}")
    return value


def _automatic(key: str, value: str, algorithm: Algorithm, place: Place, report: Report) -> Any:
    adjusts = "target_entropy" in _arguments(algorithm)
    number = evaluate(value.removeprefix("auto_")) if value.startswith("auto_") and key == "ent_coef" else None
    if adjusts and (value == "auto" or (number is not None and number > 0)):
        return value
    form = " or auto_<number>" if key == "ent_coef" else ""
    report.add(place, f"must be a number{f', auto{form}' if adjusts else ''}, got {show(value)}")
    return value


def _train_freq(value: Any, place: Place, report: Report) -> Any:
    number = _whole(value[0] if isinstance(value, list) and len(value) == 2 else value)
    is_number = isinstance(number, int) and not isinstance(number, bool) and number >= 1
    if is_number and not isinstance(value, list):
        return number
    if is_number and value[1] in ("step", "episode"):
        return [number, value[1]]
    report.add(place, f"must be a whole number >= 1 (steps), or such as [1, episode], got {show(value)}")
    return value


def _normalize(value: object, place: Place, report: Report) -> Any:
    if value is None or isinstance(value, bool):
        return value
    if not isinstance(value, Mapping):
        report.add(place, f"must be true, false or a mapping of arguments of VecNormalize, got {show(value)}")
        return None
    from stable_baselines3.common.vec_env import VecNormalize

    names = [name for name in inspect.signature(VecNormalize).parameters if name != "venv"]
    for key, entry in value.items():
        number = _number(entry)
        if key not in names:
            report.add((*place, key), f"unknown argument of VecNormalize{suggestion(key, names)}")
        elif key == "norm_obs_keys":
            if not isinstance(entry, list):
                report.add((*place, key), f"must be a list of observations, got {show(entry)}")
        elif key in SWITCHES:
            if not isinstance(entry, bool):
                report.add((*place, key), f"must be true or false, got {show(entry)}")
        elif isinstance(number, bool) or not isinstance(number, int | float) or number <= 0:
            report.add((*place, key), f"must be a number > 0, got {show(entry)}")
    return {key: _number(entry) for key, entry in value.items()}


def _policy(value: object, algorithm: Algorithm, place: Place, report: Report) -> Any:
    """Return the checked arguments of the policy."""
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        report.add(place, f"must be a mapping of arguments of the policy, got {show(value)}")
        return {}
    names, fields = _policy_arguments(algorithm), option_fields(declared.PolicyKeys)
    values: dict[str, Any] = {}
    for key, entry in value.items():
        where = (*place, key)
        values[key] = entry
        if key.endswith("_class"):
            report.add(where, declared.NOT_IN_FILES)
        elif names and key not in names:
            examples = ", ".join(sorted(names)[:MAX_NAMES])
            report.add(where, f"unknown argument of the policy{suggestion(key, names) or f'; known: {examples}'}")
        elif key == "net_arch":
            _check_layers(entry, where, report)
        elif key == "activation_fn":
            if entry not in declared.ACTIVATIONS:
                near = suggestion(entry, declared.ACTIVATIONS) if isinstance(entry, str) else ""
                report.add(where, f"must be {choices(declared.ACTIVATIONS)}, got {show(entry)}{near}")
        elif key.endswith("_kwargs"):
            values[key] = _numbers(entry, where, report)
        elif key in fields:
            info = fields[key]
            values[key] = read_field(info, _whole(entry) if info.annotation is int else _number(entry), where, report)
    return values


@functools.cache
def _policy_arguments(algorithm: Algorithm) -> tuple[str, ...]:
    """Return the arguments of an algorithm's policies; none if the algorithm is not installed."""
    try:
        policies = algorithm.load().policy_aliases.values()
    except IrsimGymError:  # its package is missing
        return ()
    names = dict.fromkeys(name for policy in policies for name in _arguments_of(policy))
    apart = ("observation_space", "action_space", "lr_schedule")
    return tuple(name for name in names if name not in apart and not name.endswith("_class"))


def _arguments_of(kind: type[Any]) -> Iterator[str]:
    """Yield the names of a class's arguments; with ``**kwargs``, also those of its base classes."""
    for cls in kind.__mro__:
        parameters = inspect.signature(cls).parameters.values()
        yield from (each.name for each in parameters if each.kind is not inspect.Parameter.VAR_KEYWORD)
        if all(each.kind is not inspect.Parameter.VAR_KEYWORD for each in parameters):
            return


def _numbers(value: object, place: Place, report: Report) -> Any:
    """Return a mapping of arguments, after converting numbers that YAML reads as text."""
    if not isinstance(value, Mapping):
        report.add(place, f"must be a mapping, got {show(value)}")
        return {}
    return {key: _number(entry) for key, entry in value.items()}


def _check_layers(value: object, place: Place, report: Report) -> None:
    parts = value.items() if isinstance(value, Mapping) else [("", value)]
    for key, layers in parts:
        where = (*place, key) if key else place
        if key not in ("", "pi", "vf", "qf"):
            report.add(where, f"must be pi, vf or qf{suggestion(key, ('pi', 'vf', 'qf'))}")
        is_list = isinstance(layers, list) and all(type(size) is int and size >= 1 for size in layers)
        if not is_list:
            report.add(where, f"must be a list of widths of layers such as [64, 64], got {show(layers)}")


def _check_together(chosen: Mapping[str, Any], algorithm: Algorithm, entry: str, report: Report) -> None:
    """Report values that contradict each other."""
    frequency, n_envs = chosen.get("train_freq"), chosen.get("n_envs", 1)
    if isinstance(frequency, list) and frequency[1] == "episode" and n_envs > 1:
        report.add((entry, "train_freq"), f"counts episodes with one world only (n_envs is {n_envs}); give steps")
    if "n_epochs" in _arguments(algorithm) and chosen.get("normalize_advantage", True):
        for name, rows in (("batch_size", chosen.get("batch_size", 2)), ("n_steps", chosen.get("n_steps", 2) * n_envs)):
            if rows < 2:
                report.add((entry, name), "makes minibatches of one row, whose advantages cannot be normalised")
