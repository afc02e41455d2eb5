"""Field types shared by kinds and specs: one declaration gives validation, schema, table and kernel record."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from typing import Any, TypeVar, cast, dataclass_transform

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as pydantic_dataclass
from pydantic.fields import FieldInfo

OPTIONS_CONFIG = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)

REQUIRED: Any = ...

LARGEST = 1e7
"""Greatest magnitude of a number in a file: with larger ones, products and squares in single precision overflow."""

T = TypeVar("T")


def option(
    default: Any = REQUIRED,
    *,
    meaning: str,
    unit: str = "",
    consequence: str = "",
    **bounds: Any,
) -> Any:
    """Declare one option.

    Args:
        default: Value of a key that is not given; ``REQUIRED`` when it must be.
        meaning: What the option does, one sentence.
        unit: SI unit without brackets, e.g. ``"m"``.
        consequence: What a bad value leads to, where validation cannot know.
        **bounds: pydantic's constraints: ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``allow_inf_nan``, ...
    """
    extra: dict[str, Any] = {"unit": unit, "consequence": consequence}
    return Field(default, description=meaning, json_schema_extra=extra, **bounds)


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(option,))
def kind(cls: type[T]) -> type[T]:
    """Make a class a kind: a frozen, strictly validated dataclass of its options.

    A kind may have a method ``problems()`` that yields (key, message) for each option that does not fit the others;
    the reader of scenarios reports them with their lines. An empty key means the kind as a whole. One with
    ``takes_more = True`` takes options that it does not declare as well, unchecked: see ``more_options``.
    """
    config = ConfigDict(**{**OPTIONS_CONFIG, "extra": "allow"}) if getattr(cls, "takes_more", False) else OPTIONS_CONFIG
    made: Any = pydantic_dataclass(frozen=True, kw_only=True, config=config)(cls)
    return cast("type[T]", made)


def more_options(options: Any) -> dict[str, Any]:
    """Return what a file gives beyond the options that a kind declares, by key; a copy."""
    declared = option_fields(type(options))
    return {key: copy.deepcopy(value) for key, value in vars(options).items() if key not in declared}


def defaults(cls: type[T]) -> T:
    """Return a kind with all its options at their defaults (type checkers do not see those of ``option``)."""
    return cls()


def option_fields(cls: type[Any]) -> dict[str, FieldInfo]:
    """Return the options of a kind or spec by their names in YAML."""
    return dict(cls.__pydantic_fields__)


def unordered_ranges(options: Any, *names: str, least: float = -math.inf) -> Iterator[tuple[str, str]]:
    """Yield a problem for each option ``[low, high]`` that is the wrong way round or begins below ``least``."""
    for name in names:
        low, high = getattr(options, name)
        if low > high:
            yield name, f"must be [low, high] with low <= high, got [{low:g}, {high:g}]"
        elif low < least:
            yield name, f"must be >= {least:g}, got [{low:g}, {high:g}]"


def crossed_bounds(
    low: Sequence[float], high: Sequence[float], low_name: str = "range_low", high_name: str = "range_high"
) -> Iterator[tuple[str, str]]:
    """Yield a problem if a component of the lower bounds lies above that of the upper ones."""
    if any(a > b for a, b in zip(low, high, strict=True)):
        shown = [f"[{', '.join(f'{value:g}' for value in bounds)}]" for bounds in (low, high)]
        yield low_name, f"must not exceed {high_name}, got {shown[0]} and {shown[1]}"
