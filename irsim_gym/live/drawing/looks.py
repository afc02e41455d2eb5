"""The look of marks in the terms of matplotlib: colours, format strings such as ``"g--"``, markers."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.scenario.specs.colors import as_text, color_problem

LINES = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted"}
NO_LINE = ("", " ", "none", "None")
Color = str | Sequence[float] | Floats
"""A name or code, or red, green, blue and optionally opacity, each from 0 to 1."""
Colors = Color | Sequence[Color]

T = TypeVar("T")

STROKES = "+x|_"
"""Markers that consist of lines."""


FORMS = tuple("o.,s^v<>Ddph*|_+x")
DISCS = {"o": 1.0, ".": 0.5, ",": 0.15}
"""Markers that are discs, with their diameter relative to the size."""


@dataclass(frozen=True)
class Format:
    """What a format string says.

    Attributes:
        color: The colour; None if the string has none.
        style: Line style as in ``LineMark``; empty for no line.
        marker: Marker; empty for none.
    """

    color: str | None
    style: str
    marker: str


def color(value: Color) -> str:
    """Return a colour as text.

    Args:
        value: A name, a letter, ``C0`` to ``C9``, a grey from ``"0"`` to ``"1"``, ``#rrggbb``, or numbers from 0 to 1
            for red, green, blue and optionally opacity.

    Raises:
        ValueError: There is no such colour.
    """
    found = as_text(value.tolist() if isinstance(value, np.ndarray) else value)
    if isinstance(found, str):
        problem = color_problem(found)
        if not problem:
            return found
        raise ValueError(problem)
    raise ValueError(f"a colour is a name such as 'red', 'C0' or '#d62728', or (red, green, blue), got {value!r}")


def line_style(name: str) -> str:
    """Return the line style of a mark for a sign or name of matplotlib; empty for no line.

    Raises:
        ValueError: There is no such style.
    """
    if name in NO_LINE:
        return ""
    if name in LINES or name in LINES.values():
        return LINES.get(name, name)
    raise ValueError(f"a line style is {', '.join(map(repr, [*LINES, *LINES.values()]))} or 'none', got {name!r}")


def marker(name: str) -> str:
    """Return the marker of points, empty for none.

    Raises:
        ValueError: There is no such form.
    """
    if name in NO_LINE or name in FORMS:
        return name if name in FORMS else ""
    raise ValueError(f"the form of a point is one of {' '.join(FORMS)}, got {name!r}")


def parsed(text: str) -> Format:
    """Return what a format string of matplotlib's says: a colour, a marker and a line style in any order, or a colour.

    Raises:
        ValueError: It is none.
    """
    if text and text not in FORMS and not color_problem(text):
        return Format(text, "solid", "")
    found: dict[str, str] = {}
    rest = text
    while rest:
        size, key, value = _next_part(rest)
        if not size or key in found:
            raise ValueError(f"a format is a colour, a marker and a line style such as 'g--' or 'ro', got {text!r}")
        found[key], rest = value, rest[size:]
    marked = found.get("marker", "")
    return Format(found.get("color"), found.get("style", "" if marked else "solid"), marked)


def _next_part(rest: str) -> tuple[int, str, str]:
    """Return length, kind and value of the first part of a format string; length 0 if there is none."""
    # Two signs before one: "--" and "-." begin like "-".
    if rest[:2] in LINES:
        return 2, "style", LINES[rest[:2]]
    if rest[0] in LINES:
        return 1, "style", LINES[rest[0]]
    if rest[0] in FORMS:
        return 1, "marker", rest[0]
    if rest[0] in "bgrcmykw":
        return 1, "color", rest[0]
    return (2, "color", rest[:2]) if rest[0] == "C" and rest[1:2].isdigit() else (0, "", "")


def number(name: str, value: object, *, least: float = 0.0, most: float = math.inf) -> float:
    """Return a number in a range.

    Raises:
        ValueError: It is none.
    """
    found = float(value) if isinstance(value, int | float | np.number) and not isinstance(value, bool) else math.nan
    if math.isfinite(found) and least <= found <= most:
        return found
    bound = f"from {least:g} to {most:g}" if most < math.inf else f"of at least {least:g}"
    raise ValueError(f"{name} is a number{'' if least == -math.inf else ' ' + bound}, got {value!r}")


def known_as(caller: str, given: Mapping[str, T], names: Mapping[str, str]) -> dict[str, T]:
    """Return keyword arguments of matplotlib under our names.

    ``label`` is accepted and has no effect, as in IR-SIM.

    Args:
        caller: Function that received them.
        given: The keyword arguments; None counts as not given.
        names: Our name for each name of matplotlib.

    Raises:
        TypeError: One is not among them, or two mean the same.
    """
    found: dict[str, T] = {}
    for name, value in given.items():
        if name == "label":
            continue
        if name not in names:
            raise TypeError(f"{caller}() takes no {name}={value!r}; it takes {', '.join(names)}")
        if names[name] in found:
            raise TypeError(f"{caller}() was given '{name}' twice, under two names")
        if value is not None:
            found[names[name]] = value
    return found
