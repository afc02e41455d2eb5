"""The function ``irsim_gym.evaluate``: compare policies of any kind on the same levels."""

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from irsim_gym.base.errors import ChangedScenarioWarning
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.comparison.evaluate import WORLDS, Evaluation, evaluate_policies
from irsim_gym.evaluation.requests.methods import Sources, by_method
from irsim_gym.evaluation.requests.remembered import change_message, changes_since
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import Source


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
) -> Evaluation:
    """Play the same levels with each policy, and return success rates, times and path lengths; print it for tables.

    A policy is a function, a model of Stable-Baselines3, a ``policy.zip``, the folder of a run, ``"random"``, the name
    of a shipped policy or of a behaviour such as ``"dash"``, or an ``irsim_gym.evaluation.Policy``, which may
    have a memory. A function gets the observations of the environment, stacked for n robots (float32
    ``(n, n_features)``, or a dict of such arrays), and returns actions as ``env.step`` takes them, ``(n, action_dim)``
    or ``(n,)``. A policy of a run and a shipped policy observe and act as in their training. Rewards and the ends of
    episodes follow from ``task`` for all policies. A ``ChangedScenarioWarning`` reports a scenario that has changed
    since a run was trained in it.

    Args:
        scenario: Shipped name, id, path of a YAML file, plain data or a loaded scenario.
        policies: A policy, a sequence of policies, or a mapping from the names in the results to policies. In a
            mapping, a list holds the seeds of one method.
        levels: Number of levels of the split, from 0.
        split: ``"test"``, which is never used for training, ``"dev"`` or ``"train"``.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        team: Whether each policy drives all robots, each by its own observation.
        references: Whether to add the reference policies.
        n_worlds: Number of worlds stepped together; the results do not depend on it.
        folder: Folder for tables, rows and pictures; None to write no files.
        parameters: Values for the scenario's parameters.
        strict: Whether unused keys are an error; False ignores them with an ``IgnoredKeyWarning``.

    Raises:
        ValueError: If ``levels`` is less than 1.
        IrsimGymError: If a policy does not exist, or does not fit the task.
    """
    sources = sources_of(policies, levels)
    _warn_of_changes(scenario, [source for several in by_method(sources).values() for source in several], task, strict)
    request = ScenarioRequest(scenario, task, team, parameters, strict)
    return evaluate_policies(
        request,
        sources,
        levels=levels,
        split=split,
        n_worlds=n_worlds,
        references=references,
        folder=None if folder is None else Path(folder),
    )


def sources_of(policies: Source | Sources, levels: int) -> Sources:
    """Return one policy as a sequence, and several as they are.

    Raises:
        ValueError: If there is no level to play.
    """
    if levels < 1:
        raise ValueError(f"levels must be >= 1, got {levels}")
    is_one = isinstance(policies, str) or not isinstance(policies, Sequence | Mapping)
    return cast("Sources", [policies] if is_one else policies)


def _warn_of_changes(scenario: ScenarioSource, sources: Sequence[Source], task: TaskSource, strict: bool) -> None:
    """Warn the caller of ``evaluate`` if the scenario has changed since policies were trained in it."""
    if not isinstance(scenario, str | Path) or not isinstance(task, str | Path | None):
        return
    for source in sources:
        changes = changes_since(scenario, source, task, strict=strict) if isinstance(source, str | Path) else []
        if changes:
            warnings.warn(change_message(scenario, str(source), changes), ChangedScenarioWarning, stacklevel=3)
