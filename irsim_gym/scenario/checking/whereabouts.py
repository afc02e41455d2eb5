"""Messages about unknown keys: the nearest name, other places where the key is valid, or the known keys."""

from collections.abc import Iterable, Iterator
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.errors import nearest
from irsim_gym.base.options import option_fields
from irsim_gym.scenario.specs.gui_spec import KeyboardSpec, MouseSpec
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, SavedFigure, WorldPlot
from irsim_gym.scenario.specs.spec import BodyOptions
from irsim_gym.scenario.specs.wander_goals import WanderGoals
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.source import SECTIONS

MOST_NAMES, MOST_PLACES = 24, 3
SURE = 0.85
"""Similarity of a key to a known one above which it counts as a misspelling."""

SPECS: dict[str, type[Any]] = {
    "world": WorldSpec,
    "world.plot": WorldPlot,
    "world.plot.saved_figure": SavedFigure,
    "robot, obstacle": BodyOptions,
    "plot": ObjectPlot,
    "wander_goals": WanderGoals,
    "gui.keyboard": KeyboardSpec,
    "gui.mouse": MouseSpec,
}
"""What declares the keys of each mapping of a file, apart from those with a name."""


def unknown_key(key: str, keys: Iterable[str]) -> str:
    """Return the message about an unknown key."""
    keys = list(keys)
    near, others = nearest(key, keys), elsewhere(key, keys)
    hints = [f"did you mean '{near}'?"] if near is not None else []
    hints += [f"'{key}' is a key of {others}"] if others else []
    if ":" in key:
        hints = ["a ':' needs a space after it"]
    if hints:
        return f"unknown key ({' '.join(hints)})"
    if len(keys) > MOST_NAMES:
        return "unknown key; `irsim-gym options` lists the keys of all sections"
    return f"unknown key; known: {', '.join(sorted(keys))}" if keys else "unknown key; no keys are allowed here"


def elsewhere(key: str, keys: Iterable[str]) -> str:
    """Return the places in a file where a key is valid, as text; empty if it is a likely misspelling of a known key."""
    if nearest(key, keys, SURE) is not None:
        return ""
    places = list(dict.fromkeys(_owners(key)))
    return ", ".join([*places[:MOST_PLACES], "..."] if len(places) > MOST_PLACES else places)


def _owners(key: str) -> Iterator[str]:
    if key in SECTIONS and key != "plot":
        yield "the file itself"
        return
    for name, spec in SPECS.items():
        if key in option_fields(spec):
            yield name.replace(", ", " and ")
    for entry in families.SECTIONS:
        if key in option_fields(entry.kind):
            yield entry.name
    for family, registry in families.BY_KEY.items():
        kinds = [entry.name for entry in registry if key in option_fields(entry.kind)]
        if kinds:
            yield f"{family} {kinds[0]}" if len(kinds) == 1 < len(registry.names()) else family
