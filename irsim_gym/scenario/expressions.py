"""Numbers written as expressions: digits, pi, ``+ - * /`` and brackets, nothing else."""

from __future__ import annotations

import math
import re

LONGEST = 80
_TOKEN = re.compile(r"[ ]*([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?|pi|[-+*/()])[ ]*")


def evaluate(text: str) -> float | int | None:
    """Return the value of an expression such as ``-3*pi/4``; None when the text is not one.

    Only whole numbers without division give an ``int``. A value that is not finite is None.
    """
    tokens = _tokens(text) if len(text) <= LONGEST else []
    if not tokens:
        return None
    try:
        value, position = _sum(tokens, 0)
    except (IndexError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return value if position == len(tokens) and math.isfinite(value) else None


def _tokens(text: str) -> list[str]:
    tokens, position = [], 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            return []
        tokens.append(match.group(1))
        position = match.end()
    return tokens


def _sum(tokens: list[str], position: int) -> tuple[float | int, int]:
    value, position = _product(tokens, position)
    while position < len(tokens) and tokens[position] in "+-":
        sign = tokens[position]
        term, position = _product(tokens, position + 1)
        value = value + term if sign == "+" else value - term
    return value, position


def _product(tokens: list[str], position: int) -> tuple[float | int, int]:
    value, position = _factor(tokens, position)
    while position < len(tokens) and tokens[position] in "*/":
        sign = tokens[position]
        factor, position = _factor(tokens, position + 1)
        value = value * factor if sign == "*" else value / factor
    return value, position


def _factor(tokens: list[str], position: int) -> tuple[float | int, int]:
    token = tokens[position]
    if token in "+-":
        value, position = _factor(tokens, position + 1)
        return (-value if token == "-" else value), position
    if token == "(":
        value, position = _sum(tokens, position + 1)
        if tokens[position] != ")":
            raise ValueError(token)
        return value, position + 1
    if token == "pi":
        return math.pi, position + 1
    return (int(token) if token.isdigit() else float(token)), position + 1
