"""Checks that policies can drive the agents of worlds, and what they observe there."""

import sys
from collections.abc import Iterable, Mapping
from typing import TextIO

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.saved_policies.policies import UnfitPolicyError, load_policy
from irsim_gym.tasks import Episodes


def check_policies(policies: Mapping[str, Policy], worlds: Perceived) -> None:
    """Check that policies can drive the agents, each with its own observations.

    Raises:
        UnfitPolicyError: If some cannot. The message names all of these.
    """
    problems = []
    for name, policy in policies.items():
        try:
            place, check = worlds.of(policy), getattr(policy, "check", None)
            if check is not None:
                check(place)
        except IrsimGymError as error:
            problems.append(f"{name}: {error}")
    if problems:
        raise UnfitPolicyError("\n".join(problems))


def fitting_references(names: Iterable[str], episodes: Episodes, file: TextIO) -> dict[str, Policy]:
    """Return reference policies by name; a line in ``file`` names each that cannot drive all agents."""
    fitting: dict[str, Policy] = {}
    for name in names:
        policy = load_policy(name)
        try:
            if isinstance(policy, BehaviorPolicy):
                policy.check(episodes)
            fitting[name] = policy
        except UnfitBehaviorError as problem:
            print(f"without {name}: {problem}", file=file)
    return fitting


def report_perceptions(policies: Mapping[str, Policy], worlds: Perceived) -> None:
    """Print to standard error which policies do not use the task's observations, a line for equal observations."""
    policies_by: dict[str, list[str]] = {}
    for name, policy in policies.items():
        if worlds.of(policy) is not worlds.episodes:
            policies_by.setdefault(", ".join(worlds.observed_by(policy) or ()), []).append(name)
    for observed, names in policies_by.items():
        who = f"{', '.join(names)}: {observed}"
        print(f"{who}, as in training, not the observations of '{worlds.episodes.task.name}'", file=sys.stderr)


def observed_by(policies: Mapping[str, Policy], worlds: Perceived) -> dict[str, list[str]]:
    """Return the names of the observations of each policy that uses observations."""
    observed = {name: worlds.observed_by(policy) for name, policy in policies.items()}
    return {name: names for name, names in observed.items() if names is not None}
