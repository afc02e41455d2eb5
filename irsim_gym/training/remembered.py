"""What runs were trained with, for commands that are given their policies: parameters, and the scenario itself."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.reference_policies import is_named_policy
from irsim_gym.scenario.load import load_scenario
from irsim_gym.scenario.messages import with_parameters
from irsim_gym.training.cards import CardScenario
from irsim_gym.training.run import lasting, run_of, scenario_name
from irsim_gym.training.shelf import card_of
from irsim_gym.training.snapshot import differences, listed, take_snapshot


def remembered_parameters(
    scenario: str, sources: Sequence[str | Path], given: Mapping[str, object] | None = None, *, strict: bool = True
) -> dict[str, Any]:
    """Return the values for a scenario's parameters: those given, and beside them what all runs were trained with.

    Where every policy is a run's in this scenario and they agree on a value, it takes the default's place, and a line
    on standard error says so; another line lists the values on which they differ. Reference policies have no say.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        given: Values that the user set; they are kept.
        strict: False ignores unused keys.
    """
    asked = dict(given or {})
    runs = [_trained_with(scenario, source) for source in sources if not is_named_policy(source)]
    if not any(runs):
        return asked
    defaults = load_scenario(scenario_name(scenario), asked, strict=strict, warn=False).parameters
    open_ones = {name: value for name, value in defaults.items() if name not in asked}
    values = {name: [run.get(name, default) for run in runs] for name, default in open_ones.items()}
    agreed = {name: found[0] for name, found in values.items() if all(value == found[0] for value in found)}
    used = {name: value for name, value in agreed.items() if value != defaults[name]}
    if used:
        _say(f"{with_parameters(scenario, used)}, as in training; use --set NAME=VALUE to change them")
    differing = {name: default for name, default in open_ones.items() if name not in agreed}
    if differing:
        _say(f"{with_parameters(scenario, differing)}, the defaults, because the policies were trained with others")
    return {**asked, **used}


def changes_since(
    scenario: str | Path, source: str | Path, task: str | Path | None = None, *, strict: bool = True
) -> list[str]:
    """Return what has changed in a scenario and its task since a run was trained in it.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        source: A run's folder, a policy in it, or a policy on the shelf. Nothing is known of other policies, nor of
            another scenario's.
        task: Shipped name or path of a task; that of the run is compared where it is the same one.
        strict: False ignores unused keys.
    """
    if is_named_policy(source):
        return []
    card = card_of(source)
    if card is not None:
        return _changes_since_card(scenario, card.scenario, task, strict=strict)
    run = run_of(source)
    before = run.snapshot()
    if before is None:
        return []
    settings = run.settings()
    named = lasting(scenario_name(str(scenario)))
    if settings.scenario != named or settings.task != (None if task is None else lasting(str(task))):
        return []
    try:
        now = take_snapshot(named, settings.task, settings.parameters, strict=strict)
    except IrsimGymError as error:
        return [f"it cannot be read with the run's parameters: {str(error).splitlines()[0]}"]
    return differences(before, now)


def _changes_since_card(
    scenario: str | Path, card: CardScenario, task: str | Path | None, *, strict: bool
) -> list[str]:
    """Return that a scenario or its task is not what the card of a policy says; nothing of another scenario's."""
    named = lasting(scenario_name(str(scenario)))
    if card.name != Path(named).name or card.task != (None if task is None else Path(task).name):
        return []
    try:
        now = take_snapshot(named, None if task is None else lasting(str(task)), card.parameters, strict=strict)
    except IrsimGymError as error:
        return [f"it cannot be read with the card's parameters: {str(error).splitlines()[0]}"]
    return [] if now.digest == card.sha256 else ["its hash is not that on the card"]


def tell_changes(scenario: str, sources: Sequence[str | Path], task: str | None = None, *, strict: bool = True) -> None:
    """Say on standard error where a scenario is not what it was when the policies were trained, a line for each run."""
    for source in sources:
        found = changes_since(scenario, source, task, strict=strict)
        if found:
            _say(change_told(scenario, source, found))


def change_told(scenario: str | Path, source: str | Path, found: list[str]) -> str:
    """Return what is said of a scenario that has changed."""
    run = run_of(source)
    copied = run.snapshot()
    where = "" if copied is None else f". As it was: {run.copy / copied.file}"
    return f"{scenario} has changed since {source} was trained: {listed(found)}{where}"


def _trained_with(scenario: str, source: str | Path) -> dict[str, Any]:
    """Return the parameters that a policy was trained with; none where that is unknown or another scenario's."""
    card = card_of(source)
    if card is not None:
        same = card.scenario.name == Path(scenario_name(scenario)).name
        return dict(card.scenario.parameters) if same else {}
    run = run_of(source)
    try:
        settings = json.loads(run.config.read_text(encoding="utf-8"))["settings"]
        parts = settings.get("mixture") or [settings]
        alike = [one for one in parts if one["scenario"] == lasting(scenario_name(scenario))]
        return dict(alike[0].get("parameters", {})) if len(alike) == 1 else {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _say(line: str) -> None:
    print(line, file=sys.stderr)
