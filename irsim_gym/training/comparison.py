"""Policies of any kind on the same levels: the evaluation as one function."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from irsim_gym.envs.worlds import ScenarioSource, TaskSource
from irsim_gym.errors import ChangedScenarioWarning
from irsim_gym.training.evaluate import WORLDS, Evaluation, evaluate_policies
from irsim_gym.training.evaluate_teams import TeamEvaluation, evaluate_team_policies
from irsim_gym.training.methods import Sources, by_method
from irsim_gym.training.policies import Source
from irsim_gym.training.remembered import change_told, changes_since


def evaluate(
    scenario: ScenarioSource,
    policies: Source | Sources,
    *,
    levels: int = 1000,
    split: str = "test",
    task: TaskSource = None,
    team: bool = False,
    references: bool = True,
    n_worlds: int = WORLDS,
    folder: str | Path | None = None,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
) -> Evaluation | TeamEvaluation:
    """Let policies drive the same levels, each once, and return rates, times and path lengths; print it to read them.

    A policy is a function, a model of Stable-Baselines3, a ``policy.zip``, the folder of a run, ``"random"``, the name
    of a behaviour such as ``"dash"``, or an ``irsim_gym.evaluation.policy.Policy``, if it has a memory. A function gets
    what the environment observes, stacked for n robots (float32 ``(n, n_features)``, or a dict of such arrays), and
    returns the actions of ``env.step``, ``(n, action_dim)`` or ``(n,)``. A policy of a run or of the shelf observes and
    acts as in its training; what counts is said by ``task`` for all. A ``ChangedScenarioWarning`` reports a scenario
    that has changed since a run was trained in it.

    Args:
        scenario: Shipped name, id, path of a YAML file, plain data or a loaded scenario.
        policies: One, several, or several by the names that they get in the results; a list behind a name holds the
            seeds of one method.
        levels: How many levels of the split, from 0.
        split: ``"test"``, which no training meets, ``"dev"`` or ``"train"``.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        team: All robots are driven by the policy, each by what it observes itself.
        references: Add the reference policies.
        n_worlds: Worlds stepped together; the results do not depend on it.
        folder: Where tables, rows and pictures go; None writes none.
        parameters: Values for the scenario's parameters.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.

    Raises:
        ValueError: There is no level to drive.
        IrsimGymError: There is no such policy, or it does not fit the task.
    """
    if levels < 1:
        raise ValueError(f"levels must be >= 1, got {levels}")
    is_one = isinstance(policies, str) or not isinstance(policies, Sequence | Mapping)
    sources: Any = [policies] if is_one else policies
    _warn_of_changes(scenario, [one for several in by_method(sources).values() for one in several], task, strict)
    evaluated = evaluate_team_policies if team else evaluate_policies
    return evaluated(
        scenario,
        sources,
        levels=levels,
        split=split,
        task=task,
        n_worlds=n_worlds,
        references=references,
        folder=None if folder is None else Path(folder),
        parameters=parameters,
        strict=strict,
    )


def _warn_of_changes(scenario: ScenarioSource, sources: Sequence[Source], task: TaskSource, strict: bool) -> None:
    """Warn the caller of ``evaluate`` of a scenario that has changed since policies were trained in it."""
    if not isinstance(scenario, str | Path) or not isinstance(task, str | Path | None):
        return
    for source in sources:
        found = changes_since(scenario, source, task, strict=strict) if isinstance(source, str | Path) else []
        if found:
            warnings.warn(change_told(scenario, str(source), found), ChangedScenarioWarning, stacklevel=3)
