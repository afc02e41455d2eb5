"""Words for error messages about a file."""

import dataclasses
import re
import types
from collections.abc import Iterable, Mapping
from typing import Any, Literal, Union, get_args, get_origin

from irsim_gym.base.errors import suggestion

LONGEST = 40
NUMBERS = re.compile(r"[-+.\d]+(\s+[-+.\d]+)+")


def show(value: object) -> str:
    """Return a value as YAML text, shortened."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"'{_cut(value)}'"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return _cut("[" + ", ".join(show(item) for item in value[:8]) + (", ..." if len(value) > 8 else "") + "]")
    if dataclasses.is_dataclass(value):
        return "a mapping"
    return _cut(_number(value))


def with_parameters(name: str, parameters: Mapping[str, object]) -> str:
    """Return a scenario's name with the values of its parameters: ``circle_swap (n_robots = 8)``."""
    values = ", ".join(f"{key} = {show(value)}" for key, value in parameters.items())
    return f"{name} ({values})" if values else name


def _number(value: object) -> str:
    try:
        return f"{value:.6g}" if isinstance(value, float) else str(value)
    except ValueError:  # an integer with thousands of digits
        return "a huge number"


def _cut(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def choices(names: Iterable[str]) -> str:
    """Return ``'a', 'b' or 'c'``."""
    quoted = [f"'{name}'" for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}" if quoted else "nothing"


def describe(hint: Any) -> str:
    """Return a description of a type: ``a list of 3 numbers``."""
    origin, args = get_origin(hint), get_args(hint)
    if hasattr(hint, "__metadata__"):
        return describe(args[0])
    if origin is Literal:
        return choices(str(arg) for arg in args)
    if origin in (Union, types.UnionType):
        return " or ".join(describe(arg) for arg in args if arg is not type(None))
    if origin is tuple:
        return _describe_tuple(args)
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "text", dict: "a mapping"}
    return names.get(origin or hint, "a mapping" if dataclasses.is_dataclass(hint) else "a value")


def _describe_tuple(args: tuple[Any, ...]) -> str:
    many = len(args) == 2 and args[1] is Ellipsis
    inner = describe(args[0]) if args else "a value"
    plural = {"a number": "numbers", "a whole number": "whole numbers", "text": "texts"}.get(inner)
    if plural is None:
        plural = f"lists{inner.removeprefix('a list')}" if inner.startswith("a list") else "values"
    return f"a list of {plural}" if many else f"a list of {len(args)} {plural}"


def translate(error: Any, value: Any, hint: Any) -> str:
    """Return our message for one of pydantic's error records.

    Args:
        error: The record, as ``ValidationError.errors()`` gives it.
        hint: The declared type of the option.
    """
    kind, context = error["type"], error.get("ctx", {})
    bounds = {"greater_than": (">", "gt"), "greater_than_equal": (">=", "ge"), "less_than": ("<", "lt")}
    bounds["less_than_equal"] = ("<=", "le")
    if kind in bounds:
        sign, name = bounds[kind]
        return f"must be {sign} {context[name]:g}, got {show(value)}"
    if kind == "literal_error":
        return _literal(value, hint)
    if kind == "finite_number":
        return f"must be finite, got {show(value)}"
    if kind in ("too_short", "too_long"):
        sign, bound = ("least", "min_length") if kind == "too_short" else ("most", "max_length")
        return f"must have at {sign} {context[bound]} values, got {context['actual_length']}"
    if kind == "string_too_short":
        return "must not be empty"
    if kind == "string_too_long":
        return f"must have at most {context['max_length']} characters"
    if kind in ("value_error", "assertion_error"):
        return str(error["msg"]).removeprefix("Value error, ").removeprefix("Assertion failed, ")
    simple = {"float_type": "a number", "int_type": "a whole number", "int_from_float": "a whole number"}
    simple |= {"bool_type": "true or false", "string_type": "text", "tuple_type": describe(hint), "missing": ""}
    if kind.startswith("int_") and isinstance(value, float):
        return f"must be a whole number, got {value!r}"
    if simple.get(kind):
        return f"must be {simple[kind]}, got {show(value)}{_hint(value)}"
    return f"must be {describe(hint)}, got {show(value)}{_hint(value)}"


def _literal(value: object, hint: object) -> str:
    names = [str(name) for name in literal_values(hint)]
    near = suggestion(value, names) if isinstance(value, str) else ""
    return f"must be {choices(names)}, got {show(value)}{near}"


def literal_values(hint: object) -> tuple[Any, ...]:
    """Return the choices of a ``Literal``, which may be inside a union."""
    if get_origin(hint) is Literal:
        return get_args(hint)
    return tuple(value for arg in get_args(hint) for value in literal_values(arg))


def _hint(value: object) -> str:
    if isinstance(value, str) and value.lower().lstrip("+-") in ("inf", "infinity"):
        return " (infinity is written .inf)"
    if isinstance(value, str) and NUMBERS.fullmatch(value):
        return " (numbers of a list are divided by commas)"
    return ""
