"""Numbers written as expressions: digits, pi, ``+ - * /``, brackets, ``min``, ``max``, ``floor`` and ``$name``."""

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping

LONGEST = 80
_NUMBER = r"[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+(?:[eE][+-]?[0-9]+)?"
_TOKEN = re.compile(rf"[ ]*({_NUMBER}|pi|min|max|floor|\$[A-Za-z_][A-Za-z0-9_]*|[-+*/(),])[ ]*", re.ASCII)
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_FUNCTIONS: dict[str, Callable[..., float | int]] = {"min": min, "max": max, "floor": math.floor}

Number = float | int
Values = Mapping[str, Number]


def evaluate(text: str, values: Values | None = None) -> Number | None:
    """Return the value of an expression such as ``-3*pi/4``; None if the text is not an expression.

    Only whole numbers without division, and ``floor``, give an ``int``. Non-finite values give None.

    Args:
        values: Values of ``$name``.
    """
    written = " ".join(map(_as_python, _tokens(text)))
    if ", )" in written:  # Python allows it
        return None
    names = {"pi": math.pi, **{f"_{name}": value for name, value in (values or {}).items()}}
    try:
        value = _value(ast.parse(written, mode="eval").body, names)
    except (SyntaxError, KeyError, TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return value if math.isfinite(value) else None


def names_in(text: str) -> tuple[str, ...]:
    """Return the names after ``$`` in a text of expression tokens; empty for other texts."""
    return tuple(token[1:] for token in _tokens(text) if token[0] == "$")


def _tokens(text: str) -> list[str]:
    """Return the tokens of a text; none if it holds anything else or is too long."""
    tokens = _TOKEN.findall(text) if len(text) <= LONGEST else []
    return tokens if "".join(tokens) == text.replace(" ", "") else []


def _as_python(token: str) -> str:
    """Return a token as Python reads it: whole numbers without leading zeros, and ``_name`` for ``$name``."""
    return str(int(token)) if token.isdigit() else token.replace("$", "_")


def _value(node: ast.expr, names: Values) -> Number:
    match node:
        case ast.Constant(value=int() | float() as value):
            return value
        case ast.Name():
            return names[node.id]
        case ast.UnaryOp():
            value = _value(node.operand, names)
            return -value if isinstance(node.op, ast.USub) else value
        case ast.BinOp():
            return _OPERATORS[type(node.op)](_value(node.left, names), _value(node.right, names))
        case ast.Call(func=ast.Name(id=name)):
            return _FUNCTIONS[name](*[_value(argument, names) for argument in node.args])
    raise ValueError(ast.dump(node))
