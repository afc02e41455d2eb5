"""The benchmarks of the suite, from ``configs/suite.yaml``."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.base.outside_files import json_object
from irsim_gym.evaluation.curves.factors import GRID, chosen_factors
from irsim_gym.scenario.checking.validation import Report
from irsim_gym.scenario.specs.library import every_scenario, suite_file
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Place

SECTIONS = ("benchmarks", "tiers")
KEYS: Mapping[str, tuple[str, Callable[[Any], bool]]] = MappingProxyType(
    {
        "asks": ("text", lambda value: isinstance(value, str)),
        "scenario": ("text", lambda value: isinstance(value, str)),
        "parameters": ("a mapping of values by name", lambda value: isinstance(value, Mapping)),
        "disturbed": ("a factor of `irsim-gym robustness`", lambda value: value in list(json_object(GRID))),
        "team": ("true or false", lambda value: isinstance(value, bool)),
        "levels": ("a whole number > 0", lambda value: type(value) is int and value > 0),
        "differs": ("text", lambda value: isinstance(value, str)),
    }
)
"""Keys of a benchmark: what their values must be, in words and as a test."""


@dataclass(frozen=True)
class Member:
    """A benchmark of the suite.

    Attributes:
        name: Its name in tables and folders.
        asks: What it asks of a policy.
        scenario: Name of its shipped scenario.
        parameters: Values of the scenario's parameters.
        disturbed: Factor of ``irsim_gym.evaluation.robustness`` that acts at its greatest strength; empty for none.
        team: Whether the policy drives all robots, or only one.
        levels: Number of different levels; None if it is unlimited.
        differs: Differences from the benchmark that it reproduces; empty for our own.
    """

    name: str
    asks: str
    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    disturbed: str = ""
    team: bool = False
    levels: int | None = None
    differs: str = ""

    @property
    def disturbances(self) -> tuple[str, float]:
        """Of a disturbed benchmark: disturbances as ``--perturb`` takes them, and the noise of ranges [m]."""
        factor = chosen_factors([self.disturbed])[0]
        return factor.text(factor.strengths[-1]), factor.noise * factor.strengths[-1]

    def levels_of(self, n_levels: int) -> int:
        """Return the number of levels to play if ``n_levels`` are requested: at most as many as the benchmark has."""
        return min(n_levels, self.levels or n_levels)


@dataclass(frozen=True)
class Suite:
    """The benchmark suite.

    Attributes:
        members: Benchmarks by name.
        tiers: Names of the benchmarks of each tier.
    """

    members: Mapping[str, Member]
    tiers: Mapping[str, Sequence[str]]

    def chosen(self, names: Sequence[str]) -> list[Member]:
        """Return the members with the given names and those of the given tiers, each once, in the order of the suite.

        Raises:
            UnknownNameError: If a name is neither a tier nor a member; the message names the nearest one and all tiers.
        """
        chosen_names: set[str] = set()
        for name in names:
            if name not in self.tiers and name not in self.members:
                near = suggestion(name, [*self.tiers, *self.members])
                raise UnknownNameError(
                    f"no tier or benchmark of the suite named '{name}'{near}; tiers: {', '.join(self.tiers)}; "
                    "`irsim-gym suite list` shows all benchmarks"
                )
            chosen_names.update(self.tiers.get(name, (name,)))
        return [member for name, member in self.members.items() if name in chosen_names]


@cache
def shipped_suite() -> Suite:
    """Return the suite of ``configs/suite.yaml``."""
    return read_suite(suite_file())


def read_suite(file: Path) -> Suite:
    """Read a suite.

    Raises:
        ScenarioError: If the file has mistakes; the message lists every one with its line.
    """
    report = Report.of_file(file)
    sections = {name: _mapping(report.mapping.get(name), (name,), report) for name in SECTIONS}
    report.refuse_unknown(report.mapping, SECTIONS)
    members = {name: _member(name, entry, report) for name, entry in sections[SECTIONS[0]].items()}
    for tier, names in sections[SECTIONS[1]].items():
        place = (SECTIONS[1], tier)
        if not isinstance(names, list):
            report.add(place, f"must be a list of benchmarks, got {show(names)}")
        for k, name in enumerate(names if isinstance(names, list) else ()):
            if not isinstance(name, str) or name not in members:
                report.add((*place, k), f"no benchmark {show(name)}{suggestion(str(name), members)}")
        if tier in members:
            report.add(place, "is also the name of a benchmark")
    report.check()
    return Suite(MappingProxyType(members), MappingProxyType(dict(sections[SECTIONS[1]])))


def _mapping(value: object, place: Place, report: Report) -> Mapping[str, Any]:
    """Return a mapping; an empty one after reporting another value."""
    if isinstance(value, Mapping):
        return value
    report.add(place, f"must be a mapping, got {show(value)}")
    return {}


def _member(name: str, value: object, report: Report) -> Member:
    """Return a member, and report its mistakes."""
    place = (SECTIONS[0], name)
    entry = _mapping(value, place, report)
    report.refuse_unknown(entry, list(KEYS), place)
    for key, (wish, is_right) in KEYS.items():
        if key in entry and not is_right(entry[key]):
            report.add((*place, key), f"must be {wish}, got {show(entry[key])}")
    if not entry.get("asks"):
        report.add((*place, "asks"), "is missing; say what it asks of a policy")
    scenario = entry.get("scenario", name)
    if not isinstance(scenario, str) or scenario not in every_scenario():
        near = suggestion(str(scenario), every_scenario())
        report.add((*place, "scenario"), f"no shipped scenario {show(scenario)}{near}")
    fields = {key: entry[key] for key in KEYS if key in entry}
    return Member(**{"asks": "", **fields, "name": name, "scenario": scenario})
