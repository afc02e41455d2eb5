"""Disturbances of all learners as one text, ``latency:time=[0, 0.2]; drive_lag:tau=0.1``, and their shield."""

import re
from collections.abc import Mapping
from typing import Any

from irsim_gym.base import families
from irsim_gym.scenario.checking.validation import BAD, Report, build_named
from irsim_gym.scenario.entries.entries import read_disturbances
from irsim_gym.scenario.reading.parameters import PERTURBED, SHIELDED
from irsim_gym.scenario.text.composer import Fatal, compose
from irsim_gym.scenario.text.messages import show
from irsim_gym.scenario.text.source import Source

_PAIR = re.compile(r":(?=\s*\w+\s*=)")


def read_perturbations(text: object) -> tuple[Any, ...]:
    """Return the disturbances of a text: ``NAME:key=value``, with ``;`` between two; values are YAML.

    Raises:
        ScenarioError: If one of them cannot be used; the error lists every problem.
    """
    report = _report(PERTURBED, text, "latency:time=0.2; lost_beams:chance=0.1")
    items = [_read_item(item, (PERTURBED, i), report) for i, item in enumerate(str(text).split(";")) if item.strip()]
    disturbances: Any = read_disturbances(items, (PERTURBED,), report)
    report.check()
    return () if disturbances is BAD else disturbances


def read_shield(text: object) -> Any:
    """Return the shield of a text: ``NAME:key=value``.

    Raises:
        ScenarioError: If it cannot be used; the error lists every problem.
    """
    report = _report(SHIELDED, text, "stop_in_time:margin=0.05")
    shield = build_named(families.SHIELDS, _read_item(str(text), (SHIELDED,), report), (SHIELDED,), report)
    report.check()
    return shield


def _report(key: str, value: object, example: str) -> Report:
    """Return a report on an argument, which must be text."""
    report = Report(Source(f"{key} {show(value)}", None))
    if not isinstance(value, str):
        report.add((key,), f"must be text such as '{example}', got {show(value)}")
        report.check()
    return report


def _read_item(text: str, place: tuple[str | int, ...], report: Report) -> Mapping[str, object]:
    """Return a disturbance as a file would hold it."""
    name, *pairs = _PAIR.split(text.strip())
    item: dict[str, object] = {"name": name.strip()}
    for key, value in (pair.split("=", 1) for pair in pairs):
        try:
            item[key.strip()] = compose(value.strip()).data
        except Fatal as error:
            report.add((*place, key.strip()), f"cannot be read, got {show(value)}: {error}")
    return item
