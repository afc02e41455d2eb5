"""Prints the content of the suite."""

from collections.abc import Mapping, Sequence
from functools import cache
from textwrap import wrap
from typing import Any

from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.suite.members import Member, shipped_suite
from irsim_gym.scenario.reference.summary import summarize_file
from irsim_gym.scenario.specs.library import every_scenario, references_file

LINE = 100


def print_suite(names: Sequence[str]) -> None:
    """Print tiers, and for each benchmark what it tests, its id and parameters, and its reference figures.

    Args:
        names: Tiers or benchmarks; empty for all.
    """
    from irsim_gym.envs.gymnasium.registration import env_id

    suite = shipped_suite()
    members = suite.chosen(names) if names else list(suite.members.values())
    for tier, those in suite.tiers.items():
        print(f"{tier}: {len(those)} benchmarks")
    for member in members:
        tiers = ", ".join(tier for tier, those in suite.tiers.items() if member.name in those) or "no tier"
        robots = f", {_robots(member)} robots" if member.team else ""
        print(f"\n{member.name} ({tiers}{robots})")
        for line in _lines(member, env_id(member.scenario)):
            print(f"  {line}")


@cache
def reference_figures() -> Mapping[str, Any]:
    """Return the shipped figures of reference policies by benchmark and policy; empty if the file does not exist."""
    file = references_file()
    with reading(file, "file of reference figures"):
        return json_object(file)["figures"] if file.is_file() else {}


def _lines(member: Member, title: str) -> list[str]:
    parameters = "".join(f", {name}={value}" for name, value in member.parameters.items())
    parameters += f", disturbed by the factor {member.disturbed} of robustness" if member.disturbed else ""
    rows = reference_figures().get(member.name, {})
    figures = ", ".join(f"{name} {100.0 * row['success']['value']:.1f} %" for name, row in rows.items())
    texts = [member.asks, f"{title}{parameters}", *([f"success: {figures}"] if figures else [])]
    texts += [f"differs from the original: {member.differs}"] if member.differs else []
    return [line for text in texts for line in wrap(text, LINE - 2)]


def _robots(member: Member) -> int:
    return summarize_file(every_scenario()[member.scenario], member.parameters).robots
