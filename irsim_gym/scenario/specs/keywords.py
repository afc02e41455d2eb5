"""Hints about keywords that an environment does not take."""

from collections.abc import Iterable
from pathlib import Path

from irsim_gym.base.errors import nearest
from irsim_gym.base.outside_files import word_tables

EVERYWHERE = ("task", "max_steps", "render_mode", "strict")
"""Keywords of all functions that make an environment."""

FILE = Path(__file__).with_suffix(".json")
"""Advice for keywords of other libraries and of other functions, and the functions that take a keyword."""

RETIRED = {"render_backend": "raster"}
"""Removed keywords, with the values that are still accepted because they match the present behaviour."""


def meant(name: str, declared: Iterable[str]) -> str:
    """Return a hint in parentheses about an unknown keyword; empty if there is none.

    Args:
        declared: Parameters of the scenario.
    """
    elsewhere, taken_by = word_tables(FILE)["elsewhere"], word_tables(FILE)["taken_by"]
    hints = [f"an argument of {taken_by[name]}"] if name in taken_by else []
    near = nearest(name, [*declared, *EVERYWHERE, *taken_by])
    if name in elsewhere:
        hints.append(elsewhere[name])
    elif near is not None and not hints:
        owner = f", an argument of {taken_by[near]}" if near in taken_by else ""
        hints.append(f"did you mean '{near}'{owner}?")
    return f" ({'; '.join(hints)})" if hints else ""
