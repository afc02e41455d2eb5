"""Numbers written as expressions: digits, pi, ``+ - * /``, brackets, ``min``, ``max``, ``floor`` and ``$name``."""

import math
import re
from collections.abc import Callable, Mapping

LONGEST = 80
_NUMBER = r"[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?"
_TOKEN = re.compile(rf"[ ]*({_NUMBER}|pi|min|max|floor|\$[A-Za-z_][A-Za-z0-9_]*|[-+*/(),])[ ]*", re.ASCII)
_FUNCTIONS: dict[str, Callable[..., float | int]] = {"min": min, "max": max, "floor": math.floor}

Number = float | int
Values = Mapping[str, Number]


def evaluate(text: str, values: Values | None = None) -> Number | None:
    """Return the value of an expression such as ``-3*pi/4``; None if the text is not an expression.

    Only whole numbers without division, and ``floor``, give an ``int``. Non-finite values give None.

    Args:
        values: Values of ``$name``.
    """
    tokens = _tokens(text)
    if not tokens:
        return None
    try:
        value, position = _sum(tokens, 0, values or {})
    except (IndexError, KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return value if position == len(tokens) and math.isfinite(value) else None


def names_in(text: str) -> tuple[str, ...]:
    """Return the names after ``$`` in a text of expression tokens; empty for other texts."""
    return tuple(token[1:] for token in _tokens(text) if token[0] == "$")


def _tokens(text: str) -> list[str]:
    tokens: list[str] = []
    position = 0 if len(text) <= LONGEST else len(text)
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            return []
        tokens.append(match.group(1))
        position = match.end()
    return tokens


def _sum(tokens: list[str], position: int, values: Values) -> tuple[Number, int]:
    value, position = _product(tokens, position, values)
    while position < len(tokens) and tokens[position] in "+-":
        sign = tokens[position]
        term, position = _product(tokens, position + 1, values)
        value = value + term if sign == "+" else value - term
    return value, position


def _product(tokens: list[str], position: int, values: Values) -> tuple[Number, int]:
    value, position = _factor(tokens, position, values)
    while position < len(tokens) and tokens[position] in "*/":
        sign = tokens[position]
        factor, position = _factor(tokens, position + 1, values)
        value = value * factor if sign == "*" else value / factor
    return value, position


def _factor(tokens: list[str], position: int, values: Values) -> tuple[Number, int]:
    token = tokens[position]
    if token in "+-":
        value, position = _factor(tokens, position + 1, values)
        return (-value if token == "-" else value), position
    if token == "(":
        value, position = _sum(tokens, position + 1, values)
        return value, _closed(tokens, position)
    if token in _FUNCTIONS:
        return _call(tokens, position, values)
    if token == "pi":
        return math.pi, position + 1
    if token[0] == "$":
        return values[token[1:]], position + 1
    return (int(token) if token.isdigit() else float(token)), position + 1


def _call(tokens: list[str], position: int, values: Values) -> tuple[Number, int]:
    """Return ``min(a, b, ...)``, ``max(a, b, ...)`` or ``floor(a)``."""
    function = _FUNCTIONS[tokens[position]]
    found: list[Number] = []
    if tokens[position + 1] != "(":
        raise ValueError(tokens[position])
    position += 1
    while not found or tokens[position] == ",":
        value, position = _sum(tokens, position + 1, values)
        found.append(value)
    return function(*found), _closed(tokens, position)


def _closed(tokens: list[str], position: int) -> int:
    if tokens[position] != ")":
        raise ValueError(tokens[position])
    return position + 1
