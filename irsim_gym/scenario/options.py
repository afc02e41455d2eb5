"""Field types shared by kinds and specs: one declaration gives validation, schema, table and kernel record."""

from __future__ import annotations

from typing import Any, TypeVar, cast, dataclass_transform

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as pydantic_dataclass

OPTIONS_CONFIG = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)

REQUIRED: Any = ...

T = TypeVar("T")


def option(
    default: Any = REQUIRED,
    *,
    meaning: str,
    unit: str = "",
    consequence: str = "",
    planned: bool = False,
    **bounds: Any,
) -> Any:
    """Declare one option.

    Args:
        default: Value of a key that is not given; ``REQUIRED`` when it must be.
        meaning: What the option does, one sentence.
        unit: SI unit without brackets, e.g. ``"m"``.
        consequence: What a bad value leads to, where validation cannot know.
        planned: True for a key that is known but does not work yet; giving it another value than
            its default is refused.
        **bounds: pydantic's constraints: ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``allow_inf_nan``, ...
    """
    extra: dict[str, Any] = {"unit": unit, "consequence": consequence, "planned": planned}
    return Field(default, description=meaning, json_schema_extra=extra, **bounds)


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(option,))
def kind(cls: type[T]) -> type[T]:
    """Make a class a kind: a frozen, strictly validated dataclass of its options."""
    made: Any = pydantic_dataclass(frozen=True, kw_only=True, config=OPTIONS_CONFIG)(cls)
    return cast("type[T]", made)


def defaults(cls: type[T]) -> T:
    """Return a kind with all its options at their defaults (type checkers do not see those of ``option``)."""
    return cls()
