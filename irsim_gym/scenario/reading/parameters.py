"""Parameters of a scenario: declared in the section ``parameters``, used as ``$name`` in the rest of the file."""

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError, UnknownKeywordError, UnknownParameterError, suggestion
from irsim_gym.base.options import kind, option
from irsim_gym.scenario.checking.validation import BAD, Report, build, read_numbers
from irsim_gym.scenario.specs.keywords import RETIRED, meant
from irsim_gym.scenario.specs.library import every_scenario
from irsim_gym.scenario.text.expressions import evaluate, names_in
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import WRAPPER, Place, Source

SECTION = "parameters"
PERTURBED, PREDICT, SHIELDED = BESIDE = "disturbances", "predict", "shield"
"""What each scenario has beside its parameters: disturbances and a shield of all learners, see ``perturbations``, and
the option of its section ``task``.
"""
ARGUMENTS = frozenset(
    (
        *("scenario", "id", "name", "task", "parameters", "seed", "split", "level", "mode", "team", "kwargs"),
        *("num_envs", "n_envs", "n_worlds", "worlds_are", "num_threads", "render_mode"),
        *("record", "save_ani", "columns", "wrappers"),
        *("max_steps", "max_episode_steps", "max_cycles", "outer_limit", "autoreset_mode", "autoreset"),
        *("respawn", "world_steps", "padded", "team_state", "strict"),
        *("black_death", "numpy_infos"),
        *("disable_env_checker", "vectorization_mode", "vector_kwargs"),
        *("env_kwargs", "start_index", "monitor_dir", "monitor_kwargs"),
        *("wrapper_class", "wrapper_kwargs", "vec_env_cls", "vec_env_kwargs"),
    )
)
"""Names of arguments of functions that make environments, which parameters must not have."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_WITHIN = re.compile(r"\$\{[ ]*([A-Za-z_][A-Za-z0-9_]*)[ ]*\}", re.ASCII)
_BARE = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)", re.ASCII)

Value = bool | int | float | str


@kind
class ParameterSpec:
    """One parameter."""

    default: bool | int | float | str = option(
        meaning="Value if none is given. It sets the type: a whole number (a number if min, max or a choice is "
        "not whole), a number, true or false, or text."
    )
    min: float | None = option(None, meaning="Minimum value, for numbers.")
    max: float | None = option(None, meaning="Maximum value, for numbers.")
    choices: tuple[bool | int | float | str, ...] | None = option(None, min_length=1, meaning="Allowed values.")
    unit: str = option("", meaning="SI unit, for the reader.")
    meaning: str = option(min_length=1, meaning="What the parameter does, in one sentence; shown in messages.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of conflicting options."""
        bounds = [key for key in ("min", "max") if getattr(self, key) is not None]
        is_number = self.value_type in (int, float)
        if bounds and self.choices is not None:
            yield "choices", "cannot stand beside min or max"
        elif bounds and not is_number:
            yield bounds[0], f"is for numbers, but the default is {show(self.default)}"
        elif len(bounds) == 2 and self.min > self.max:  # type: ignore[operator]
            yield "min", f"must not exceed max, got {self.min:g} and {self.max:g}"
        elif any(type(self.convert(one)) is not self.value_type for one in self.choices or ()):
            yield "choices", f"must be of the type of the default, {show(self.default)}"
        elif self.refusal(self.convert(self.default)):
            yield "default", self.refusal(self.convert(self.default))

    @property
    def value_type(self) -> type[bool | int | float | str]:
        """Type of its values: that of the default, but float for an int default with fractional bounds or choices."""
        others = (self.min, self.max, *(self.choices or ()))
        is_whole = all(not isinstance(one, float) or one.is_integer() for one in others)
        return float if type(self.default) is int and not is_whole else type(self.default)

    @property
    def allowed(self) -> str:
        """Description of the allowed values."""
        if self.choices is not None:
            shown = [show(one) for one in self.choices]
            return " or ".join([", ".join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)
        words = {bool: "true or false", int: "a whole number", float: "a number", str: "text"}[self.value_type]
        if self.min is not None and self.max is not None:
            return f"{words} from {self.min:g} to {self.max:g}"
        bounds = ((">=", self.min), ("<=", self.max))
        return words + "".join(f" {sign} {bound:g}" for sign, bound in bounds if bound is not None)

    def convert(self, value: object) -> Any:
        """Convert a value to the parameter's type if possible; numbers may be text, e.g. ``"pi/2"``."""
        value = value.item() if isinstance(value, np.generic) else value
        if isinstance(value, str) and isinstance(self.default, bool):
            return {"true": True, "false": False}.get(value.strip().lower(), value)
        if isinstance(value, str) and not isinstance(self.default, str):
            value = read_numbers(value)
        if self.value_type is float and type(value) is int:
            return float(value) if abs(value) < 1e300 else math.inf
        return value

    def refusal(self, value: Any) -> str:
        """Return why a converted value is invalid; empty if it is valid."""
        good = type(value) is self.value_type
        if good and type(value) in (int, float):
            low, high = -math.inf if self.min is None else self.min, math.inf if self.max is None else self.max
            good = low <= value <= high and (type(value) is int or math.isfinite(value))
        if good and self.choices is not None:
            good = value in [self.convert(one) for one in self.choices]
        near = suggestion(value, [str(one) for one in self.choices or ()]) if isinstance(value, str) else ""
        shown = str(value) if isinstance(value, float) and self.value_type is int else show(value)
        return "" if good else f"must be {self.allowed}, got {shown}{near}"


def is_free(name: str) -> bool:
    """Return whether a parameter may have this name, which no argument of an environment has."""
    return name not in ARGUMENTS and name not in BESIDE


def fill_in(source: Source, given: Mapping[str, object], *, strict: bool = True) -> tuple[Source, dict[str, Value]]:
    """Replace ``$name`` by the values of parameters; return the new data, and the values.

    Args:
        source: The data of a file; the result contains its problems.
        given: Values that replace defaults.
        strict: Whether unused keys are problems; else they are ignored and reported.

    Raises:
        UnknownParameterError: If a given name is not declared; the message lists the declared names.
        ScenarioError: If a given value is not allowed; the message lists the allowed values.
    """
    report = Report(source, strict=strict)
    declared = _declarations(source, report)
    asked = {name: value for name, value in given.items() if name not in RETIRED or RETIRED[name] != value}
    values = _chosen(source, declared, asked)
    filler = _Filler(declared, values, report)
    data = filler.sections(source.data, ())
    for place, name in _sections(source.data):
        if name in values and name not in filler.used:
            report.add((*place, name), "is declared but never used")
    found: dict[str, Any] = {"problems": tuple(report.problems), "ignored": tuple(report.ignored)}
    return replace(source, data=data, unknown=frozenset(filler.unknown), origins=filler.origins, **found), values


@contextmanager
def given_as_keywords() -> Iterator[None]:
    """Convert the error about an unknown parameter to one about an unknown keyword argument."""
    try:
        yield
    except UnknownParameterError as error:
        raise UnknownKeywordError.of(error.name, str(error)) from None


def describe_parameters(source: Source, values: Mapping[str, Value] | None = None) -> list[str]:
    """Return a line for each parameter: name, value (default: its default), allowed values and meaning."""
    declared = _declarations(source, Report(source))
    return _lines({name: spec for name, spec in declared.items() if spec is not None}, values or {})


def _lines(specs: Mapping[str, ParameterSpec], values: Mapping[str, Value]) -> list[str]:
    shown = {name: f"{name} = {show(values.get(name, spec.default))}" for name, spec in specs.items()}
    units = {name: f" [{spec.unit}]" if spec.unit else "" for name, spec in specs.items()}
    cells = [(shown[name] + units[name], spec.allowed, spec.meaning) for name, spec in specs.items()]
    first, second = (max((len(row[i]) for row in cells), default=0) for i in (0, 1))
    return [f"{value:<{first}}   {allowed:<{second}}   {meaning}" for value, allowed, meaning in cells]


def _sections(data: object) -> Iterator[tuple[Place, str]]:
    """Yield the path of the section and the name of each parameter."""
    inner = data.get(WRAPPER) if isinstance(data, Mapping) else None
    for around, place in ((data, (SECTION,)), (inner, (WRAPPER, SECTION))):
        section = around.get(SECTION) if isinstance(around, Mapping) else None
        for name in section if isinstance(section, Mapping) else ():
            yield place, name


def _declarations(source: Source, report: Report) -> dict[str, ParameterSpec | None]:
    """Return the declared parameters; None for an invalid declaration, which is reported."""
    declared: dict[str, ParameterSpec | None] = {}
    inner = source.data.get(WRAPPER) if isinstance(source.data, Mapping) else None
    for around, place in ((source.data, (SECTION,)), (inner, (WRAPPER, SECTION))):
        section = around.get(SECTION) if isinstance(around, Mapping) else None
        if section is not None and not isinstance(section, Mapping):
            report.add(place, f"must be a mapping such as {{n: {{default: 4, meaning: ...}}}}, got {show(section)}")
            continue
        for name, data in (section or {}).items():
            declared[name] = _declaration(name, data, (*place, name), report)
    return declared


def _declaration(name: str, data: object, place: Place, report: Report) -> ParameterSpec | None:
    if _NAME.fullmatch(name) is None:
        report.add(place, "a name consists of letters, digits and _, and does not begin with a digit")
    elif not is_free(name):
        report.add(place, "environments have an argument of this name; choose another one")
    elif not isinstance(data, Mapping):
        report.add(place, f"must be a mapping such as {{default: 4, meaning: ...}}, got {show(data)}")
    else:
        numbers = {key: read_numbers(data[key]) for key in ("default", "choices") if key in data}
        texts = [value for value in numbers.values() if isinstance(value, str) and _BARE.search(value)]
        if not texts:
            return build(ParameterSpec, {**data, **numbers}, place, report)
        report.add((*place, "default"), "a parameter cannot depend on other parameters")
    return None


def _chosen(
    source: Source, declared: Mapping[str, ParameterSpec | None], given: Mapping[str, object]
) -> dict[str, Value]:
    """Return the value of each validly declared parameter."""
    specs = {name: spec for name, spec in declared.items() if spec is not None}
    known = "\n".join(f"    {line}" for line in _lines(specs, {}))
    listed = f"; it has\n{known}" if known else "; it has none"
    unknown = [name for name in given if name not in declared]
    values = {name: spec.convert(given.get(name, spec.default)) for name, spec in specs.items()}
    if unknown:
        names = ", ".join(f"'{name}'{meant(name, declared)}" for name in unknown)
        refused = {name: specs[name].refusal(values[name]) for name in given if name in specs}
        wrong = "".join(f"; '{name}' {refusal}" for name, refusal in refused.items() if refusal)
        shipped = {str(file): name for name, file in every_scenario().items()}
        title = shipped.get(source.file, source.title)
        raise UnknownParameterError(unknown[0], f"{title} has no parameter {names}{wrong}{listed}")
    problems = sorted(
        source.problem((*place, name), specs[name].refusal(values[name]))
        for place, name in _sections(source.data)
        if name in given and name in specs and specs[name].refusal(values[name])
    )
    if problems:
        last = problems[-1]
        problems[-1] = Problem(last.line, last.path, f"{last.message}; its parameters are\n{known}")
        raise ScenarioError(source.title, problems)
    return values


class _Filler:
    """Replaces ``$name`` in the values of a file.

    Attributes:
        used: Names of the parameters that are used.
        unknown: Paths of values that cannot be evaluated, or of the whole list that contains one.
        origins: Original text of evaluated values, by path.
    """

    def __init__(
        self, declared: Mapping[str, ParameterSpec | None], values: Mapping[str, Value], report: Report
    ) -> None:
        self.used: set[str] = set()
        self.unknown: set[Place] = set()
        self.origins: dict[Place, str] = {}
        self._declared, self._values, self._report = declared, values, report
        self._numbers = {name: value for name, value in values.items() if not isinstance(value, str | bool)}

    def sections(self, data: object, place: Place) -> Any:
        """Return the file with all sections filled in except ``parameters``."""
        if not isinstance(data, Mapping):
            return data
        filled = {}
        for name, section in data.items():
            if name == WRAPPER and not place:
                filled[name] = self.sections(section, (WRAPPER,))
            else:
                filled[name] = section if name == SECTION else self._known(section, (*place, name), name == "custom")
        return filled

    def _known(self, value: object, place: Place, is_custom: bool) -> object:
        """Return a filled-in value; None, as if it were not given, if it cannot be evaluated."""
        filled = self._value(value, place, is_custom)
        if filled is BAD:
            self.unknown.add(place)
        return None if filled is BAD else filled

    def _value(self, value: object, place: Place, is_custom: bool) -> object:
        if isinstance(value, Mapping):
            return {key: self._known(item, (*place, key), is_custom) for key, item in value.items()}
        if isinstance(value, list):
            if place[-1] == "obstacle_map":
                return value  # many cells, none with parameters
            items = [self._value(item, (*place, i), is_custom) for i, item in enumerate(value)]
            return BAD if any(item is BAD for item in items) else items
        if not isinstance(value, str) or "$" not in value:
            return value
        filled = self._text(value, place, is_custom)
        if filled is not BAD and filled != value:
            self.origins[place] = value
        return filled

    def _text(self, text: str, place: Place, is_custom: bool) -> object:
        """Return the value of a text with ``$``; BAD after reporting problems."""
        within, names = _WITHIN.findall(text), names_in(text)
        bare = [name for name in _BARE.findall(text) if name in self._declared]
        unknown = [name for name in (*within, *names) if name not in self._declared]
        if unknown and is_custom:
            return text
        if unknown:
            self._report.add(place, self._unknown(unknown[0]))
            return BAD
        self.used.update(within, names, bare)
        if any(name not in self._values for name in (*within, *names)):
            return BAD  # the invalid declaration is reported already
        if within:
            return _WITHIN.sub(lambda match: _plain(self._values[match.group(1)]), text)
        if names:
            return self._expression(text, names, place)
        if bare and not is_custom:
            self._report.add(place, f"is not an expression; within text, write ${{{bare[0]}}}, got {show(text)}")
        return text

    def _expression(self, text: str, names: tuple[str, ...], place: Place) -> object:
        if text.strip() == f"${names[0]}":
            return self._values[names[0]]
        for name in names:
            if name not in self._numbers:
                self._report.add(place, f"'{name}' is {show(self._values[name])}, which is not a number")
                return BAD
        value = evaluate(text, self._numbers)
        if value is None:
            settings = ", ".join(f"{name} = {show(self._numbers[name])}" for name in dict.fromkeys(names))
            self._report.add(place, f"cannot be evaluated with {settings}, got {show(text)}")
        return BAD if value is None else value

    def _unknown(self, name: str) -> str:
        near = suggestion(name, self._declared)
        shown = ", ".join(declared[:40] for declared in list(self._declared)[:6])
        others = f"; declared: {shown}" if shown else f": there is no section '{SECTION}'"
        return f"no parameter named '{name[:40]}'{near or others}"


def _plain(value: Value) -> str:
    """Return a value as part of a text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)
