"""The benchmarks of the suite, from ``configs/suite.yaml``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from irsim_gym.errors import IrsimGymError, UnknownNameError, suggestion
from irsim_gym.scenario.library import every_scenario, suite_file
from irsim_gym.scenario.source import read_file

KEYS = ("asks", "scenario", "parameters", "team", "levels", "differs")


@dataclass(frozen=True)
class Member:
    """A benchmark of the suite.

    Attributes:
        name: Its name in tables and folders.
        asks: What it asks of a policy.
        scenario: Name of its shipped scenario.
        parameters: Values of the scenario's parameters.
        team: Whether the policy drives all robots, or only one.
        levels: Number of different levels; None if it is unlimited.
        differs: Differences from the benchmark that it reproduces; empty for our own.
    """

    name: str
    asks: str
    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    team: bool = False
    levels: int | None = None
    differs: str = ""

    def levels_of(self, asked: int) -> int:
        """Return the number of levels to play if ``asked`` are requested: at most as many as the benchmark has."""
        return min(asked, self.levels or asked)


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
        wanted: set[str] = set()
        for name in names:
            if name not in self.tiers and name not in self.members:
                near = suggestion(name, [*self.tiers, *self.members])
                raise UnknownNameError(
                    f"no tier or benchmark of the suite named '{name}'{near}; tiers: {', '.join(self.tiers)}; "
                    "`irsim-gym suite list` shows all benchmarks"
                )
            wanted.update(self.tiers.get(name, (name,)))
        return [member for name, member in self.members.items() if name in wanted]

    def tiers_of(self, name: str) -> list[str]:
        """Return the tiers that hold a member."""
        return [tier for tier, names in self.tiers.items() if name in names]


@cache
def shipped_suite() -> Suite:
    """Return the suite of ``configs/suite.yaml``."""
    return read_suite(suite_file())


def read_suite(file: Path) -> Suite:
    """Read a suite.

    Raises:
        ScenarioError: If the file is not valid YAML.
        IrsimGymError: If the file has mistakes; the message lists all of them.
    """
    data = read_file(file).data
    problems = [] if set(data) == {"benchmarks", "tiers"} else ["must have the sections benchmarks and tiers"]
    entries, tiers = data.get("benchmarks") or {}, data.get("tiers") or {}
    members = {name: _member(name, entry or {}, problems) for name, entry in entries.items()}
    for tier, names in tiers.items():
        problems += [
            f"tiers.{tier}: no benchmark '{name}'{suggestion(name, members)}"
            for name in names or ()
            if name not in members
        ]
        if tier in members:
            problems.append(f"tiers.{tier}: is also the name of a benchmark")
    if problems:
        raise IrsimGymError("\n".join(f"{file}: {problem}" for problem in problems))
    return Suite(MappingProxyType(members), MappingProxyType(dict(tiers)))


def _member(name: str, entry: Mapping[str, Any], problems: list[str]) -> Member:
    """Return a member, and append its mistakes to ``problems``."""
    scenario = entry.get("scenario", name)
    for key in entry:
        if key not in KEYS:
            problems.append(f"benchmarks.{name}.{key}: unknown key{suggestion(key, KEYS)}; keys: {', '.join(KEYS)}")
    if not entry.get("asks"):
        problems.append(f"benchmarks.{name}.asks: is missing; say what it asks of a policy")
    if scenario not in every_scenario():
        near = suggestion(str(scenario), every_scenario())
        problems.append(f"benchmarks.{name}.scenario: no shipped scenario '{scenario}'{near}")
    known = {key: value for key, value in entry.items() if key in KEYS}
    return Member(**{"asks": "", **known, "name": name, "scenario": scenario})
