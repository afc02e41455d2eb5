"""Pages of the reference: every public name of the package, from its docstrings."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from builder import stand_ins
from irsim_gym.simulator.world.arrays import Arrays


@dataclass(frozen=True)
class Section:
    """A page of the reference.

    Attributes:
        title: Its title.
        intro: What it holds.
        module: Every public name of this module is on the page; None where ``names`` are all.
        names: Further names, with their modules: classes that public functions return.
    """

    title: str
    intro: str
    module: str | None = None
    names: tuple[str, ...] = ()


SECTIONS = {
    "irsim_gym": Section("irsim_gym", "What ``import irsim_gym`` offers.", "irsim_gym"),
    "environments": Section(
        "irsim_gym.envs",
        "What environments return when they are asked. ``describe()`` of any of them tells what each number means.",
        names=tuple(
            f"irsim_gym.envs.{name}"
            for name in (
                *("Mirror", "Description", "Block", "Part", "Action", "Component", "Reward", "Ending", "Info"),
                *("WorldMoment", "Bodies", "BodyMoment", "BodyReadings"),
            )
        ),
    ),
    "worlds": Section("irsim_gym.live", "What the worlds of ``load`` and their bodies return.", "irsim_gym.live"),
    "scenario": Section(
        "irsim_gym.scenario",
        "Scenarios as data, and where the shipped ones are.",
        names=tuple(f"irsim_gym.scenario.{name}" for name in ("Scenario", "BodySpec", "find", "configs_folder")),
    ),
    "tasks": Section(
        "irsim_gym.tasks",
        "Tasks, and the codes in infos.",
        names=tuple(f"irsim_gym.tasks.{name}" for name in ("load_task", "Task", "Outcome", "HitKind")),
    ),
    "sb3": Section("irsim_gym.sb3", "For Stable-Baselines3.", "irsim_gym.sb3"),
    "rllib": Section("irsim_gym.rllib", "For Ray RLlib.", "irsim_gym.rllib"),
    "levels": Section(
        "irsim_gym.levels",
        "What is known of levels.",
        names=("irsim_gym.levels.read_certificate", "irsim_gym.levels.Certificate"),
    ),
    "evaluation": Section(
        "irsim_gym.evaluation",
        "``robustness``, and what ``evaluate``, ``arena``, ``load_policy`` and ``load_demonstrations`` return.",
        names=tuple(
            f"irsim_gym.evaluation.{name}"
            for name in (
                *("robustness", "Robustness", "StrengthRow"),
                *(
                    "Evaluation",
                    "TeamEvaluation",
                    "Summary",
                    "EpisodeRow",
                    "Rate",
                    "TeamSummary",
                    "TeamRow",
                    "AgentRow",
                ),
                *("Arena", "Standings", "ShelfPolicy", "PolicyCard", "CardScenario", "CardTerm", "CardAction"),
                *("CardNetwork", "CardTraining", "CardPart", "CardResult", "CardShare", "Demonstrations"),
            )
        ),
    ),
    "plugins": Section("irsim_gym.plugins", "Kinds of your own.", "irsim_gym.plugins"),
    "irsim": Section(
        "irsim_gym.irsim",
        "What scripts import from IR-SIM, under its names.",
        "irsim_gym.irsim",
        names=("irsim_gym.irsim.factory.ShapeOutline",),
    ),
    "errors": Section("irsim_gym.errors", "Errors and warnings.", "irsim_gym.errors"),
}


def pages() -> dict[str, str]:
    """Return the pages as reStructuredText, by their places."""
    shown: set[int] = set()
    return {f"reference/{key}.rst": _page(section, shown) for key, section in SECTIONS.items()}


def names(section: Section) -> Iterator[tuple[str, Any]]:
    """Yield the dotted names of a page, with what they name."""
    if section.module is not None:
        module = stand_ins.module(section.module)
        for name in public(module):
            yield f"{section.module}.{name}", getattr(module, name)
    for dotted in section.names:
        module_name, _, name = dotted.rpartition(".")
        yield dotted, getattr(stand_ins.module(module_name), name)


def public(module: ModuleType) -> list[str]:
    """Return the public names of a module: those in ``__all__``, else its own classes and functions."""
    listed = getattr(module, "__all__", None)
    if listed is not None:
        return sorted((name for name in listed if not name.startswith("_")), key=str.lower)
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_") and getattr(value, "__module__", None) == module.__name__
    ]


def _page(section: Section, shown: set[int]) -> str:
    """Return a page; classes that another page shows too are indexed once."""
    lines = [section.title, "=" * len(section.title), "", section.intro, ""]
    for dotted, value in names(section):
        entry = _entry(dotted, value)
        if id(value) in shown:
            entry.insert(1, "   :no-index:")
        shown.add(id(value))
        lines += entry
    return "\n".join(lines)


def _entry(dotted: str, value: Any) -> list[str]:
    """Return the directive of a name."""
    if isinstance(value, ModuleType):
        page = next((key for key, section in SECTIONS.items() if section.module == value.__name__), None)
        assert page is not None, f"{dotted} has no page: add it to SECTIONS"
        return [f".. py:module:: {value.__name__}", "   :no-index:", "", f"``{dotted}``: see :doc:`{page}`.", ""]
    if inspect.isclass(value):
        return [f".. autoclass:: {dotted}", "   :members:", "   :show-inheritance:", "", *_columns(value)]
    if callable(value) and not _is_instance(value):
        return [f".. autofunction:: {dotted}", ""]
    return [f".. autodata:: {dotted}", "   :no-value:", ""]


def _columns(value: type) -> list[str]:
    """Return the table of the arrays that a class declares by shape, unit and meaning; nothing for other classes."""
    if not issubclass(value, Arrays):
        return []
    rows = [("array", "shape", "type", "unit", "meaning")]
    for name, column in value.columns().items():
        shape, kind = f"({', '.join(column.axes)})", np.dtype(column.dtype)
        rows.append((name, shape, "record" if kind.names else kind.name, column.unit, column.meaning))
    lines = [f"   {'* -' if first else '  -'} {cell}".rstrip() for row in rows for first, cell in _firsts(row)]
    return ["   .. list-table::", "      :header-rows: 1", "", *(f"   {line}" for line in lines), ""]


def _firsts(row: Sequence[str]) -> Iterator[tuple[bool, str]]:
    """Yield cells, with whether each is the first one, as reStructuredText that shows them as they are."""
    yield from ((place == 0, re.sub(r"([*_`|\\])", r"\\\1", cell)) for place, cell in enumerate(row))


def _is_instance(value: object) -> bool:
    return not (inspect.isroutine(value) or hasattr(value, "__wrapped__"))
