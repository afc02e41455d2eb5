"""Options of kinds and specs: one declaration gives validation, schema, table and kernel record."""

import copy
import copyreg
import inspect
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar, cast, dataclass_transform

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as pydantic_dataclass
from pydantic.fields import FieldInfo

from irsim_gym.base import families

OPTIONS_CONFIG = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)

REQUIRED: Any = ...

LARGEST = 1e7
"""Maximum magnitude of a number in a file; much larger ones overflow in products, squares and single precision."""

T = TypeVar("T")

Drawn = float | tuple[float, float]
"""Type of an option that is one number, or the two ends between which each level draws it; see ``Bounds``."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of an option of type ``Drawn``: ``time: Annotated[Drawn, Bounds(0.0, 10.0)] = option(0.0, ...)``.

    Attributes:
        ge: The least number, in the [unit] of the option.
        le: The greatest, likewise.
    """

    ge: float
    le: float


def drawn_ends(options: object) -> dict[str, tuple[float, float]]:
    """Return the ends between which each level draws the options of type ``Drawn``, by name; equal for one number."""
    names = [name for name, info in option_fields(type(options)).items() if info.annotation == Drawn]
    values = {name: getattr(options, name) for name in names}
    return {name: value if isinstance(value, tuple) else (value, value) for name, value in values.items()}


def drawn_problems(options: object) -> Iterator[tuple[str, str]]:
    """Yield a problem for each option of type ``Drawn`` with ends in the wrong order or beyond its bounds."""
    for name, (low, high) in drawn_ends(options).items():
        said = option_fields(type(options))[name].metadata
        bounds = next((item for item in said if isinstance(item, Bounds)), Bounds(-math.inf, math.inf))
        shown = f"{low:g}" if low == high else f"[{low:g}, {high:g}]"
        if low > high:
            yield name, f"must be [low, high] with low <= high, got {shown}"
        elif low < bounds.ge or high > bounds.le:
            yield name, f"must lie from {bounds.ge:g} to {bounds.le:g}, got {shown}"


def option(default: Any = REQUIRED, *, meaning: str, unit: str = "", consequence: str = "", **bounds: Any) -> Any:
    """Declare one option.

    Args:
        default: Value if the key is not given; ``REQUIRED`` if it must be given.
        meaning: What the option does, in one sentence.
        unit: SI unit without brackets, e.g. ``"m"``.
        consequence: Effect of a bad value that validation cannot detect.
        **bounds: pydantic's constraints: ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``allow_inf_nan``, ...
    """
    extra: dict[str, Any] = {"unit": unit, "consequence": consequence}
    return Field(default, description=meaning, json_schema_extra=extra, **bounds)


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(option,))
def kind(cls: type[T]) -> type[T]:
    """Turn a class into a kind: a frozen, strictly validated dataclass of its options.

    A kind may have a method ``problems()`` that yields (key, message) for each option that conflicts with others; the
    reader of scenarios reports them with their lines. An empty key means the kind as a whole. A kind with
    ``takes_more = True`` also accepts options that it does not declare, without checks: see ``more_options``.
    """
    config = ConfigDict(**{**OPTIONS_CONFIG, "extra": "allow"}) if getattr(cls, "takes_more", False) else OPTIONS_CONFIG
    made: Any = pydantic_dataclass(frozen=True, kw_only=True, config=config)(cls)
    return cast("type[T]", made)


def more_options(options: object) -> dict[str, Any]:
    """Return a copy of the given options that the kind does not declare, by key."""
    declared = option_fields(type(options))
    return {key: copy.deepcopy(value) for key, value in vars(options).items() if key not in declared}


def defaults(cls: type[T]) -> T:
    """Return a kind with all options at their defaults (type checkers do not see the defaults of ``option``)."""
    return cls()


def option_fields(cls: type[Any]) -> dict[str, FieldInfo]:
    """Return the options of a kind or spec by their names in YAML."""
    return dict(cls.__pydantic_fields__)


def unordered_ranges(options: object, *names: str, least: float = -math.inf) -> Iterator[tuple[str, str]]:
    """Yield a problem for each option ``[low, high]`` with low > high or low < ``least``."""
    for name in names:
        low, high = getattr(options, name)
        if low > high:
            yield name, f"must be [low, high] with low <= high, got [{low:g}, {high:g}]"
        elif low < least:
            yield name, f"must be >= {least:g}, got [{low:g}, {high:g}]"


def crossed_bounds(
    low: Sequence[float], high: Sequence[float], low_name: str = "range_low", high_name: str = "range_high"
) -> Iterator[tuple[str, str]]:
    """Yield a problem if a lower bound exceeds its upper bound."""
    if any(a > b for a, b in zip(low, high, strict=True)):
        shown = [f"[{', '.join(f'{value:g}' for value in bounds)}]" for bounds in (low, high)]
        yield low_name, f"must not exceed {high_name}, got {shown[0]} and {shown[1]}"


def kind_of_function(
    family: str, name: str, function: Callable[..., object], base: type[Any], leading: Sequence[str], **members: object
) -> type[Any]:
    """Return a kind whose options are those of ``base`` and the keyword-only parameters of a function.

    The class gets the members ``function`` and ``own_options``, which returns the function's keywords for an instance.
    A function with ``**more`` accepts any further options in the file, without checks.

    Args:
        family: Name of the family in messages.
        name: Name of the kind in YAML.
        base: Base class of all such kinds.
        leading: Names of the function's parameters before its options, for messages.
        **members: Further members of the class.

    Raises:
        TypeError: If the function's parameters do not have this form.
    """
    parameters = function_parameters(family, name, function)
    options = _function_options(family, name, parameters, base, leading)
    keys, takes_more = tuple(options), any(one.kind is one.VAR_KEYWORD for one in parameters)

    def own_options(chosen: object) -> dict[str, Any]:
        values = {key: getattr(chosen, key) for key in keys}
        return {**values, **more_options(chosen)} if takes_more else values

    members = {"function": staticmethod(function), "own_options": staticmethod(own_options), **members}
    return make_kind(family, name, function, base, options, takes_more=takes_more, **members)


class MadeKind(type):
    """The class of kinds that are made from functions. No module has them, so pickles hold their family and name."""

    registered: tuple[str, str]


copyreg.pickle(MadeKind, lambda made: (families.kind_named, made.registered))


def make_kind(
    family: str,
    name: str,
    written: Callable[..., object],
    base: type[Any],
    options: dict[str, tuple[Any, Any]],
    **members: object,
) -> type[Any]:
    """Return a kind made from a function or class of a plugin; its member ``called`` names it in messages.

    Args:
        family: Name of the family in messages.
        name: Name of the kind in YAML.
        written: The function or class, for its docstring.
        base: Base class of all such kinds.
        options: Type and declaration of each option.
        **members: Further members of the class, such as ``function``.
    """
    words = [*name.split("_"), family.split()[-1]]
    made = MadeKind(
        "".join(word.capitalize() for word in words),
        (base,),
        {
            "__doc__": inspect.getdoc(written) or f"The {family} '{name}'.",
            "__module__": written.__module__,
            "__annotations__": {key: hint for key, (hint, _) in options.items()},
            **{key: declared for key, (_, declared) in options.items()},
            "called": f"{family} '{name}'",
            "only_kernels": False,
            "registered": (family, name),
            **members,
        },
    )
    return kind(made)


def function_parameters(family: str, name: str, function: Callable[..., object]) -> list[inspect.Parameter]:
    """Return the parameters of a function with their types.

    Raises:
        TypeError: If a type annotation cannot be evaluated at run time.
    """
    try:
        return list(inspect.signature(function, eval_str=True).parameters.values())
    except NameError as error:
        raise TypeError(f"{family} '{name}': the types of its parameters must exist when it runs ({error})") from None


def _function_options(
    family: str, name: str, parameters: Sequence[inspect.Parameter], base: type[Any], leading: Sequence[str]
) -> dict[str, tuple[Any, Any]]:
    """Return type and declaration of each keyword-only parameter."""
    plain = [one for one in parameters if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)]
    keywords = [one for one in parameters if one.kind is one.KEYWORD_ONLY]
    more = [one for one in parameters if one.kind is one.VAR_KEYWORD]
    if len(plain) != len(leading) or len(plain) + len(keywords) + len(more) != len(parameters):
        shown = ", ".join(str(one) for one in parameters)
        raise TypeError(
            f"{family} '{name}': the parameters must be {', '.join(leading)}, a '*', and the options, or '**' for any, "
            f"got ({shown})"
        )
    options = {}
    for one in keywords:
        if hasattr(base, one.name) or one.name in option_fields(base) or one.name == "name":
            raise TypeError(f"{family} '{name}': every {family} has '{one.name}' already; name the option differently")
        if one.annotation is one.empty:
            raise TypeError(f"{family} '{name}': the option '{one.name}' needs a type, such as {one.name}: float = 1.0")
        default = REQUIRED if one.default is one.empty else one.default
        options[one.name] = one.annotation, option(default, meaning=f"Option of '{name}'.")
    return options
