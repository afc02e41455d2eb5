"""The scenarios of this folder, by name."""

from __future__ import annotations

import copy
from functools import cache
from pathlib import Path
from typing import Any

import yaml

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

FOLDER = Path(__file__).parent / "scenarios"


@cache
def all_cases() -> dict[str, dict[str, Any]]:
    """Return the scenarios of all files: ``file/name`` to a mapping with sections and how to compare (``parity``)."""
    found = {}
    for file in sorted(FOLDER.glob("*.yaml")):
        for name, case in yaml.safe_load(file.read_text()).items():
            found[f"{file.stem}/{name}"] = case
    return found


def case_of(name: str) -> dict[str, Any]:
    """Return a copy of a scenario."""
    return copy.deepcopy(all_cases()[name])


def plan_of(case: dict[str, Any]) -> dict[str, Any]:
    """Return how a scenario is compared."""
    plan: dict[str, Any] = case.get("parity") or {}
    return plan


def refused(name: str) -> bool:
    """Return whether a scenario of this folder uses a kind that is not supported yet."""
    return refused_scenario({key: value for key, value in case_of(name).items() if key != "parity"})


def refused_scenario(scenario: dict[str, Any]) -> bool:
    """Return whether a scenario uses a kind that is not supported yet."""
    try:
        ig.load_scenario(scenario)
    except ScenarioError as error:
        return "not supported yet" in str(error)
    return False
