"""Converts plain data to typed options, and reports all mistakes with their paths."""

import dataclasses
import functools
import math
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar, Union, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from irsim_gym.base.errors import Problem, ScenarioError, UnknownNameError, nearest, suggestion
from irsim_gym.base.options import LARGEST, OPTIONS_CONFIG, drawn_problems, option_fields
from irsim_gym.base.registry import Registry
from irsim_gym.scenario.checking.needless import NEEDLESS, mapping_of
from irsim_gym.scenario.checking.whereabouts import elsewhere, unknown_key
from irsim_gym.scenario.specs.colors import as_text, color_problem
from irsim_gym.scenario.text import messages
from irsim_gym.scenario.text.expressions import evaluate
from irsim_gym.scenario.text.source import Place, Source, read_file

MAX_PROBLEMS = 200

T = TypeVar("T")


class Bad:
    """The result for an invalid value, which has been reported."""

    def __repr__(self) -> str:
        return "BAD"


BAD = Bad()


class Report:
    """Collects the problems of one source.

    Args:
        strict: Whether unknown keys are problems; else they are ignored and listed.
    """

    def __init__(self, source: Source, *, strict: bool = True) -> None:
        self.source = source
        self.strict = strict
        self.could_be_lenient = False
        self.may_pend = False
        """Whether behaviours may be registered later."""
        self.problems: dict[Problem, None] = dict.fromkeys(source.problems)
        self.doubts: dict[Problem, None] = {}
        self.ignored: dict[Problem, None] = dict.fromkeys(source.ignored)
        self._unread = {(problem.line, problem.path) for problem in source.problems}

    @classmethod
    def of_file(cls, file: Path) -> Self:
        """Read a file that is no scenario: there, repeated keys are problems.

        In scenarios, the last of two equal sections counts, with a warning.
        """
        report = cls(read_file(file))
        report.problems |= dict.fromkeys(problem for problem, _ in report.source.repeats)
        return report

    @property
    def mapping(self) -> Mapping[str, Any]:
        """The data of the source; empty if it is no mapping."""
        return self.source.data if isinstance(self.source.data, Mapping) else {}

    def check(self) -> None:
        """Raise all problems.

        Raises:
            ScenarioError: If there are any. The message lists every problem with its line.
        """
        if self.problems:
            raise ScenarioError(self.source.title, list(self.problems))

    def refuse_unknown(self, data: Mapping[str, Any], known: Sequence[str], place: Place = ()) -> None:
        """Report the keys of a mapping that are not known."""
        for key in data:
            if key not in known:
                self.add((*place, key), f"unknown key{suggestion(str(key), known)}; known: {', '.join(known)}")

    def add(self, place: Place, message: str) -> None:
        """Report a problem once; problems beyond a limit are omitted."""
        if any(place[:n] in self.source.unknown for n in range(1, len(place) + 1)):
            return  # it follows from an unknown value, which is reported already
        problem = self.source.problem(place, message)
        if (problem.line, problem.path) in self._unread:
            return  # it could not be read, which is reported already
        _collect(self.problems, problem, "problems")

    def ignore(self, place: Place, message: str) -> None:
        """Report an ignored key; keys beyond a limit are omitted."""
        _collect(self.ignored, self.source.problem(place, message), "keys")

    def refuse(self, place: Place, message: str) -> None:
        """Report an unused key; an error if the reader is strict."""
        if self.strict:
            self.add(place, message)
            self.could_be_lenient = True
        else:
            self.ignore(place, message)

    def doubt(self, place: Place, message: str) -> None:
        """Report a suspicious but allowed value once."""
        self.doubts[self.source.problem(place, message)] = None

    @property
    def is_full(self) -> bool:
        """Whether further problems will be omitted."""
        return len(self.problems) > MAX_PROBLEMS


def _collect(found: dict[Problem, None], problem: Problem, what: str) -> None:
    if len(found) < MAX_PROBLEMS:
        found[problem] = None
    elif len(found) == MAX_PROBLEMS:
        found[Problem(0, "", f"more than {MAX_PROBLEMS} {what}: the rest is not shown")] = None


def frozen(value: object) -> Any:
    """Return plain data with tuples in place of lists."""
    return tuple(frozen(item) for item in value) if isinstance(value, list | tuple) else value


def read_numbers(value: object) -> Any:
    """Return a value with all expressions in it (``pi/2``) evaluated, also inside lists."""
    if isinstance(value, list | tuple):
        return [read_numbers(item) for item in value]
    if isinstance(value, str):
        number = evaluate(value)
        return value if number is None else number
    return value


def build(cls: type[T], data: object, place: Place, report: Report, *, skip: Iterable[str] = ()) -> T | None:
    """Make an instance of a kind or spec; return None after reporting all problems.

    Args:
        cls: A class made by ``options.kind``.
        data: The data in the file; None counts as an empty mapping.
        skip: Keys to ignore because the caller reads them, such as ``name``.
    """
    data = {} if data is None else data
    if not isinstance(data, Mapping):
        hint = (
            " (leave the '-' out)" if isinstance(data, list) and any(isinstance(one, Mapping) for one in data) else ""
        )
        report.add(place, f"must be a mapping of options, got {messages.show(data)}{hint}")
        return None
    fields, ignored = option_fields(cls), set(skip)
    open_ended = getattr(cls, "takes_more", False)
    spelt = {} if open_ended else check_keys(data, [*fields, *ignored], place, report)
    more = [key for key in data if key not in fields and key not in ignored] if open_ended else []
    values: dict[str, Any] = {key: data[key] for key in more}
    is_good = True
    for key, info in fields.items():
        own = spelt.get(key, key)
        if key not in ignored and own in data and data[own] is None and _takes_null(info):
            values[key] = None
        elif key not in ignored and data.get(own) is not None:
            read = read_color if key.endswith("color") else read_field
            values[key] = read(info, data[own], (*place, own), report)
            is_good = is_good and values[key] is not BAD
        elif info.is_required() and key not in ignored:
            report.add((*place, key), "is required")
            is_good = False
    return _construct(cls, values, place, report) if is_good else None


def _takes_null(info: FieldInfo) -> bool:
    """Return whether ``null`` is a value of an option, different from omitting it."""
    # Elsewhere null means "not given". The one such option is ``bbox_inches``, where matplotlib tells both apart.
    return not info.is_required() and info.default is not None and type(None) in get_args(info.annotation)


def _construct(cls: type[T], values: Mapping[str, object], place: Place, report: Report) -> T | None:
    try:
        made = cls(**values)
    except ValidationError as error:
        for record in error.errors():
            where = (*place, *(part for part in record["loc"] if isinstance(part, str | int)))
            report.add(where, messages.translate(record, record.get("input"), Any))
        return None
    problems = [*drawn_problems(made), *(made.problems() if hasattr(made, "problems") else ())]
    for key, message in problems:
        report.add((*place, key) if key else place, message)
    return None if problems else made


def check_keys(data: Mapping[str, object], known: Iterable[str], place: Place, report: Report) -> dict[str, str]:
    """Report unused keys; return misspelt keys by the known keys that they resemble.

    Values of misspelt keys are read as well, so that their mistakes are reported too. Keys that are valid elsewhere are
    excluded, and so are all keys if the reader is not strict, because they are ignored then.
    """
    known, needless = list(known), NEEDLESS.get(mapping_of(place), {})
    spelt: dict[str, str] = {}
    for key in data:
        if key in needless and key not in known:
            report.ignore((*place, key), needless[key])
        elif key not in known and not report.is_full:
            report.refuse((*place, key), unknown_key(key, known))
            near = None if elsewhere(key, known) or not report.strict else nearest(key, known)
            if near is not None and near not in data:
                spelt.setdefault(near, key)
    return spelt


def read_field(info: FieldInfo, value: object, place: Place, report: Report) -> Any:
    """Return the validated value of one option; BAD after reporting problems."""
    ready = prepare(info.annotation, value, place, report)
    if ready is BAD:
        return BAD
    try:
        result = _adapter(_Declared(info)).validate_python(ready)
    except ValidationError as error:
        _report_errors(error, info, ready, place, report)
        return BAD
    huge = list(_huge(result, place))
    for where, number in huge:
        report.add(where, f"must lie between -{LARGEST:g} and {LARGEST:g}, got {messages.show(number)}")
    return BAD if huge else result


def _huge(value: object, place: Place) -> Iterator[tuple[Place, float]]:
    """Yield the numbers of an option that are too large to compute with; infinity is allowed, as no limit."""
    if isinstance(value, tuple):
        for i, item in enumerate(value):
            yield from _huge(item, (*place, i))
    elif isinstance(value, float) and LARGEST < abs(value) < math.inf:
        yield place, value


def read_color(info: FieldInfo, value: object, place: Place, report: Report) -> Any:
    """Return the value of a colour option as text; BAD after reporting problems."""
    text = as_text(read_numbers(value)) if isinstance(value, list | tuple) else value
    if isinstance(text, list | tuple):
        report.add(place, f"must be a name, '#rrggbb', or 3 or 4 numbers from 0 to 1, got {messages.show(value)}")
        return BAD
    color = read_field(info, text, place, report)
    problem = color_problem(color) if isinstance(color, str) else ""
    if problem:
        report.add(place, problem)
    return BAD if problem else color


class _Declared:
    """A field that is hashable by identity, so that its validator is cached."""

    def __init__(self, info: FieldInfo) -> None:
        self.info = info

    def __hash__(self) -> int:
        return id(self.info)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Declared) and other.info is self.info


@functools.lru_cache(maxsize=1024)
def _adapter(declared: _Declared) -> TypeAdapter[Any]:
    info = declared.info
    hint: Any = info.annotation
    for constraint in info.metadata:
        hint = Annotated[hint, constraint]
    if dataclasses.is_dataclass(info.annotation):
        return TypeAdapter(hint)
    return TypeAdapter(hint, config=OPTIONS_CONFIG)


def _report_errors(error: ValidationError, info: FieldInfo, value: object, place: Place, report: Report) -> None:
    if len(_branches(info.annotation)) > 1:
        report.add(place, f"must be {messages.describe(info.annotation)}, got {messages.show(value)}")
        return
    for record in error.errors():
        if record["type"] == "too_short" and len(record["input"]) >= record["ctx"]["min_length"]:
            continue  # pydantic counts only valid elements; the invalid ones are reported themselves
        inner = tuple(part for part in record["loc"] if isinstance(part, int))
        report.add((*place, *inner), messages.translate(record, record.get("input"), _hint_at(info.annotation, inner)))


def _branches(hint: object) -> list[object]:
    if get_origin(hint) in (Union, types.UnionType):
        return [arg for arg in get_args(hint) if arg is not type(None)]
    return [hint]


def _hint_at(hint: object, inner: tuple[int, ...]) -> object:
    """Return the type declared for an element of a list."""
    hint = _branches(hint)[0]
    if hasattr(hint, "__metadata__"):
        return _hint_at(get_args(hint)[0], inner)
    if not inner or get_origin(hint) is not tuple:
        return hint
    args = get_args(hint)
    index = 0 if len(args) == 2 and args[1] is Ellipsis else min(inner[0], len(args) - 1)
    return _hint_at(args[index], inner[1:])


def prepare(hint: object, value: object, place: Place, report: Report) -> Any:
    """Prepare a value for pydantic's strict types: make tuples, evaluate expressions, build nested options."""
    branches = _branches(hint)
    if len(branches) > 1:
        keeps_text = str in branches or any(branch is Any for branch in branches)
        return frozen(value if keeps_text else read_numbers(value))
    hint = branches[0]
    if hasattr(hint, "__metadata__"):
        return prepare(get_args(hint)[0], value, place, report)
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        built = build(hint, value, place, report)
        return BAD if built is None else built
    if hint in (float, int) and isinstance(value, str):
        number = evaluate(value)
        return value if number is None else number
    if get_origin(hint) is tuple and isinstance(value, list | tuple):
        return _prepare_tuple(hint, value, place, report)
    return frozen(value)


def _prepare_tuple(hint: object, value: list[Any] | tuple[Any, ...], place: Place, report: Report) -> object:
    args = get_args(hint)
    if len(args) == 2 and args[1] is Ellipsis:
        hints = [args[0]] * len(value)
    elif len(args) == len(value):
        hints = list(args)
    else:
        report.add(place, f"must be {messages.describe(hint)}, got {messages.show(value)}")
        return BAD
    items = [prepare(one, item, (*place, i), report) for i, (one, item) in enumerate(zip(hints, value, strict=True))]
    return BAD if any(item is BAD for item in items) else tuple(items)


def build_named(
    registry: Registry, data: object, place: Place, report: Report, *, default: str | None = None, synonym: str = "name"
) -> Any:
    """Make an instance of a registered kind from ``{name: ..., option: ...}``; return None after reporting problems.

    Args:
        default: Name for a mapping without one; None requires a name.
        synonym: A second key that may hold the name.
    """
    if not isinstance(data, Mapping):
        example = data if isinstance(data, str) and data in registry else next(iter(registry.names()), "...")
        report.add(place, f"must be a mapping such as {{name: {example}}}, got {messages.show(data)}")
        return None
    key = "name" if "name" in data or synonym not in data else synonym
    name = data.get(key, default)
    if name is None:
        report.add((*place, "name"), f"is required: {messages.choices(registry.names())}")
        return None
    if not isinstance(name, str):
        report.add((*place, key), f"must be {messages.choices(registry.names())}, got {messages.show(name)}")
        return None
    try:
        entry = registry.entry(name)
    except UnknownNameError as error:
        extra = "" if "did you mean" in str(error) else f"; known: {', '.join(registry.names())}"
        report.add((*place, key), f"{error}{extra}")
        return None
    return build(entry.kind, data, place, report, skip={"name", key})
