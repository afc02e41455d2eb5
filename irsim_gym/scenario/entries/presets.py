"""Shipped robots that entries name: ``preset: turtlebot4``."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from irsim_gym.scenario.specs.library import names
from irsim_gym.scenario.text.source import ROLES, WRAPPER, Source, read_file

FOLDER, KEY = "robots", "preset"


def with_presets(source: Source) -> Source:
    """Return plain data in which entries that name a shipped robot have its keys; their own keys take precedence.

    A name that is not shipped stays, and is reported by the reader of the entry.
    """
    return replace(source, data=_filled(source.data))


def _filled(sections: Any) -> Any:
    if not isinstance(sections, Mapping):
        return sections
    entries = {role: _entries(sections[role]) for role in ROLES if role in sections}
    inner = {WRAPPER: _filled(sections[WRAPPER])} if WRAPPER in sections else {}
    return {**sections, **entries, **inner}


def _entries(section: Any) -> Any:
    if isinstance(section, list):
        return [_entries(entry) for entry in section]
    name = section.get(KEY) if isinstance(section, Mapping) else None
    if not isinstance(name, str) or name not in names(FOLDER):
        return section
    return {**_preset(name), **{key: value for key, value in section.items() if key != KEY}}


@cache
def _preset(name: str) -> Mapping[str, Any]:
    entry: Mapping[str, Any] = read_file(names(FOLDER)[name]).data["robot"][0]
    return entry
