"""The parameters and the scenario that policies were trained with, for commands that use these policies."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.reference_policies import is_named_policy
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.cards import CardScenario
from irsim_gym.evaluation.saved_policies.run_folder import RunFolder, folder_of, lasting
from irsim_gym.evaluation.saved_policies.shelf import card_of
from irsim_gym.evaluation.saved_policies.snapshot import differences, listed, take_snapshot
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.ids import scenario_name
from irsim_gym.scenario.text.messages import with_parameters

Parameters = Mapping[str, object]


def remembered_parameters(
    scenario: str, sources: Sequence[str | Path], parameters: Mapping[str, object] | None = None, *, strict: bool = True
) -> dict[str, Any]:
    """Return values for a scenario's parameters: those that the user sets, and those of the policies' trainings.

    If all policies were trained in this scenario with the same value, this value replaces the default, and a line on
    standard error reports it. Another line lists parameters whose values differ. Reference policies are ignored, and so
    is a mixture that lists the scenario with different parameters.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies, as ``load_policy`` takes them.
        parameters: Values that the user sets, which take precedence.
    """
    chosen = dict(parameters or {})
    runs = [_trained_with(scenario, source) for source in sources if not is_named_policy(source)]
    if not any(runs):
        return chosen
    defaults = load_scenario(scenario_name(scenario), chosen, strict=strict, warn=False).parameters
    unset = {name: value for name, value in defaults.items() if name not in chosen}
    values = {name: [run.get(name, default) for run in runs] for name, default in unset.items()}
    agreed = {name: choices[0] for name, choices in values.items() if all(value == choices[0] for value in choices)}
    used = {name: value for name, value in agreed.items() if value != defaults[name]}
    if used:
        _say(f"{with_parameters(scenario, used)}, as in training; use --set NAME=VALUE to change them")
    differing = {name: default for name, default in unset.items() if name not in agreed}
    if differing:
        _say(f"{with_parameters(scenario, differing)}, the defaults, because the policies were trained with others")
    return {**chosen, **used}


def changes_since(
    scenario: str | Path, source: str | Path, task: str | Path | None = None, *, strict: bool = True
) -> list[str]:
    """Return the changes of a scenario and its task since a policy was trained in it.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        source: A run's folder, a policy in it, or a shipped policy. The result is empty for other policies, and for
            those trained in another scenario.
        task: Shipped name or path of a task. The result is empty if the policy was trained with another one.
    """
    if is_named_policy(source):
        return []
    card = card_of(source)
    if card is not None:
        return _changes_since_card(scenario, card.scenario, task, strict=strict)
    run = RunFolder(folder_of(source))
    before = run.snapshot()
    if before is None:
        return []
    trained = run.trained()
    named = lasting(scenario_name(str(scenario)))
    if trained.scenario != named or trained.task != (None if task is None else lasting(str(task))):
        return []
    try:
        now = take_snapshot(named, trained.task, trained.parameters, strict=strict)
    except IrsimGymError as error:
        return [f"it cannot be read with the run's parameters: {str(error).splitlines()[0]}"]
    return differences(before, now)


def _changes_since_card(
    scenario: str | Path, card: CardScenario, task: str | Path | None, *, strict: bool
) -> list[str]:
    """Return a line if the hash of a scenario and its task differs from that on a policy's card."""
    named = lasting(scenario_name(str(scenario)))
    if card.name != Path(named).name or card.task != (None if task is None else Path(task).name):
        return []
    try:
        now = take_snapshot(named, None if task is None else lasting(str(task)), card.parameters, strict=strict)
    except IrsimGymError as error:
        return [f"it cannot be read with the card's parameters: {str(error).splitlines()[0]}"]
    return [] if now.digest == card.sha256 else ["its hash is not that on the card"]


def report_changes(request: ScenarioRequest, sources: Sequence[str | Path]) -> None:
    """Print to standard error how a scenario has changed since policies were trained in it, a line for each policy."""
    scenario, task = str(request.scenario), None if request.task is None else str(request.task)
    for source in sources:
        changes = changes_since(scenario, source, task, strict=request.strict)
        if changes:
            _say(change_message(scenario, source, changes))


def as_trained(request: ScenarioRequest, sources: Sequence[str | Path]) -> ScenarioRequest:
    """Return a scenario with the parameters of the policies' trainings, and report how it has changed since then."""
    used = remembered_parameters(str(request.scenario), sources, request.parameters, strict=request.strict)
    report_changes(request, sources)
    return replace(request, parameters=used)


def change_message(scenario: str | Path, source: str | Path, changes: list[str]) -> str:
    """Return the message about a scenario that has changed since a policy was trained in it."""
    run = RunFolder(folder_of(source))
    copied = run.snapshot()
    where = "" if copied is None else f". As it was: {run.copy / copied.file}"
    return f"{scenario} has changed since {source} was trained: {listed(changes)}{where}"


def _trained_with(scenario: str, source: str | Path) -> dict[str, Any]:
    """Return the parameters of a policy's training in a scenario; an empty dict if they are unknown."""
    named, card = lasting(scenario_name(scenario)), card_of(source)
    if card is None:
        return _only_parameters(named, _parts_of(RunFolder(folder_of(source))))
    parts = card.training.mixture or (card.scenario,)
    return _only_parameters(Path(named).name, [(part.name, part.parameters) for part in parts])


def _parts_of(run: RunFolder) -> list[tuple[str, Parameters]]:
    """Return the scenarios of a run with their parameters; an empty list if its settings cannot be read."""
    try:
        return list(run.trained().parts)
    except IrsimGymError:
        return []


def _only_parameters(scenario: str, parts: Sequence[tuple[str, Parameters]]) -> dict[str, Any]:
    """Return the parameters of a scenario among the scenarios of a training.

    The result is empty if the scenario is missing, or if a mixture lists it with different parameters.
    """
    matches = [parameters for name, parameters in parts if name == scenario]
    return dict(matches[0]) if matches and all(match == matches[0] for match in matches) else {}


def _say(line: str) -> None:
    print(line, file=sys.stderr)
