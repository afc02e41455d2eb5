"""What to use in place of IR-SIM's names that bodies and sensors do not have."""

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from irsim_gym.base.errors import suggestion
from irsim_gym.base.outside_files import word_tables

DRAWN = "render() draws bodies as their section `plot` says; world.draw draws over them"
FILE = Path(__file__).with_suffix(".json")
"""What to use, with the names that it replaces, for each owner of names."""


@cache
def advice(*owners: str) -> Mapping[str, str]:
    """Return what to use in place of each name, by the name.

    Args:
        owners: Parts of the file, such as ``body``; later ones go before earlier ones.
    """
    tables = word_tables(FILE)
    return {name: text for owner in owners for name, text in tables[owner].items()}


def missing(what: str, name: str, elsewhere: Mapping[str, str], names: Iterable[str]) -> str:
    """Return the message for a missing name, with what to use instead.

    Args:
        what: Owner of the name, such as ``a body``.
        name: The name.
        elsewhere: What to use for names of IR-SIM.
        names: The existing names.
    """
    if name.startswith("plot_"):
        return f"{what} has no '{name}': {DRAWN}"
    if name in elsewhere:
        return f"{what} has no '{name}': {elsewhere[name]}"
    return f"{what} has no '{name}'{suggestion(name, [other for other in names if not other.startswith('_')])}"
