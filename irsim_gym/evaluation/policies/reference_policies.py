"""Reference policies: random actions, and the behaviours of the scenario language."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base import families
from irsim_gym.base.arraytypes import Floats, Ints
from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.base.families import BEHAVIORS, GROUP_BEHAVIORS
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.policies.named_policies import kind_name, read_options
from irsim_gym.evaluation.policies.policy import without_lone_axis
from irsim_gym.tasks import Episodes

DRAWS = 64
REFERENCES = ("random", "dash", "rvo", "orca")
ALWAYS_SHOWN = ("random", "dash")
"""Reference policies shown beside every evaluated policy; the others see more of the world than a learner does."""
TEAM_SHOWN = REFERENCES
"""Reference policies shown beside policies of teams, which should beat the usual alternatives to learning."""


class RandomPolicy:
    """Draws actions uniformly; a level's actions depend only on its number and the seed."""

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._generators: dict[int, np.random.Generator] = {}
        self._drawn: dict[int, Floats] = {}
        self._used: dict[int, int] = {}

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Seed a random generator for each level."""
        for world, level in zip(worlds.tolist(), levels.tolist(), strict=True):
            self._generators[world] = np.random.default_rng((self.seed, level))
            self._used[world] = DRAWS

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64] | Ints:
        """Return the actions of worlds."""
        size = 1 if episodes.action_kind == "discrete" else len(episodes.action_low)
        drawn = np.stack([self._next(world, episodes.n_agents, size) for world in worlds.tolist()])
        if episodes.action_kind == "discrete":
            return without_lone_axis((drawn[..., 0] * episodes.n_discrete).astype(np.int64))
        scaled = episodes.action_low + drawn * (episodes.action_high - episodes.action_low)
        return without_lone_axis(np.asarray(scaled, np.float64))

    def _next(self, world: int, team: int, size: int) -> Floats:
        """Return the world's next random numbers in [0, 1), ``(team, size)``; they are drawn in blocks."""
        if self._used[world] >= DRAWS:
            self._drawn[world] = self._generators[world].random((DRAWS, team, size))
            self._used[world] = 0
        rows: Floats = self._drawn[world][self._used[world]]
        self._used[world] += 1
        return rows


def policy_kinds() -> tuple[str, ...]:
    """Return the names of policies that need no file: ``random`` and all registered behaviours and group behaviours.

    Behaviours of plugins are included once their modules are imported.
    """
    families.load()
    return tuple(dict.fromkeys((*REFERENCES, *BEHAVIORS.names(), *GROUP_BEHAVIORS.names())))


def is_named_policy(source: object) -> bool:
    """Return whether a source is the name of a policy that needs no file, with or without options."""
    return isinstance(source, str | Path) and kind_name(source) in policy_kinds()


def reference_policy(name: str) -> RandomPolicy | BehaviorPolicy:
    """Make the random policy, or a policy that drives by a behaviour or group behaviour.

    Args:
        name: ``"random"``, or the name of a behaviour, optionally with options: ``"pursuit:known=seen"``.

    Raises:
        UnknownNameError: If no policy has that name.
        PolicyOptionError: If the behaviour does not have the options.
    """
    names = policy_kinds()
    if kind_name(name) not in names:
        raise UnknownNameError(f"no reference policy named '{name}'{suggestion(name, names)}")
    if kind_name(name) == "random":
        read_options(name)
        return RandomPolicy()
    return BehaviorPolicy(name)
