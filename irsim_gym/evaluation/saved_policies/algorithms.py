"""The learning algorithms: which classes implement them, and which actions they support."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion
from irsim_gym.base.extras import require

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

CONTINUOUS, DISCRETE = "continuous", "discrete"
MASKED = ("ppo", "a2c", "gru_ppo")
"""Algorithms that leave out robots that wait for their world."""
SHIPPED_TASK = "discrete_navigation"
"""The shipped task with discrete actions."""


@dataclass(frozen=True)
class Algorithm:
    """A learning algorithm, usually of Stable-Baselines3 or sb3-contrib.

    Attributes:
        name: Name, as ``--algorithm`` takes it.
        module: Module of the class.
        class_name: Name of the class.
        actions: Supported kinds of actions: ``continuous``, ``discrete``.
        team_module: Module of the subclass that masks waiting robots; empty if the algorithm needs none.
        policy_suffix: Part of the policies' class names between the kind of network and ``Policy``.
    """

    name: str
    module: str
    class_name: str
    actions: frozenset[str]
    team_module: str = ""
    policy_suffix: str = ""

    def load(self, team: bool = False) -> type[BaseAlgorithm]:
        """Import and return the class.

        Args:
            team: Return the class for teams, which masks robots that wait for others.

        Raises:
            MissingExtraError: If its package is not installed.
        """
        module, name = self.module, self.class_name
        if team and self.team_module:
            module, name = self.team_module, f"Masked{name}"
        require("contrib" if self.module == "sb3_contrib" else "train", f"the algorithm {self.name}")
        cls: type[BaseAlgorithm] = getattr(importlib.import_module(module), name)
        return cls

    def check_action(self, action: Any, named: str) -> None:
        """Check that the algorithm supports a task's action.

        Raises:
            IrsimGymError: If it does not. The message names algorithms that do, and what to change in the task.
        """
        kind = DISCRETE if action.n_choices else CONTINUOUS
        if kind in self.actions:
            return
        others = ", ".join(other.name for other in ALGORITHMS.values() if kind in other.actions)
        if kind == CONTINUOUS:
            what, way = "one of several commands", f"give the task `action: discrete` (--task {SHIPPED_TASK})"
        else:
            what, way = "numbers", "give the task `action: velocity`"
        raise IrsimGymError(
            f"{self.name} learns actions that are {what}, but the task's action '{named}' is {kind}: "
            f"{way}, or take another algorithm ({others})"
        )


_BOTH = frozenset({CONTINUOUS, DISCRETE})
_ONLY_NUMBERS = frozenset({CONTINUOUS})


def _listed() -> Iterator[Algorithm]:
    masked = "irsim_gym.envs.sb3_learning.masked"
    yield Algorithm("ppo", "stable_baselines3", "PPO", _BOTH, masked)
    yield Algorithm("sac", "stable_baselines3", "SAC", _ONLY_NUMBERS)
    yield Algorithm("td3", "stable_baselines3", "TD3", _ONLY_NUMBERS)
    yield Algorithm("tqc", "sb3_contrib", "TQC", _ONLY_NUMBERS)
    yield Algorithm("dqn", "stable_baselines3", "DQN", frozenset({DISCRETE}))
    yield Algorithm("a2c", "stable_baselines3", "A2C", _BOTH, masked)
    yield Algorithm("gru_ppo", "irsim_gym.envs.sb3_learning.gru", "GruPPO", _BOTH, policy_suffix="Gru")


ALGORITHMS: Mapping[str, Algorithm] = MappingProxyType({algorithm.name: algorithm for algorithm in _listed()})


def find_algorithm(name: str) -> Algorithm:
    """Return the algorithm of a name.

    Raises:
        UnknownNameError: If no algorithm has this name. The message suggests a similar name.
    """
    if name not in ALGORITHMS:
        near = suggestion(name, ALGORITHMS)
        raise UnknownNameError(f"no algorithm named '{name}'{near}; there are {', '.join(ALGORITHMS)}")
    return ALGORITHMS[name]
