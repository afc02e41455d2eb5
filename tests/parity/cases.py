"""The scenarios of this folder, by name."""

from __future__ import annotations

import copy
from functools import cache
from pathlib import Path
from typing import Any

import yaml

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
