"""The policies of an arena."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy
from irsim_gym.training.policies import Source, load_policies, policy_digest, policy_names
from irsim_gym.training.policy_places import cure_of


@dataclass(frozen=True)
class Entrant:
    """One policy of an arena.

    Attributes:
        name: Its name in the results.
        policy: The policy.
        source: The name, file or folder that it was loaded from; None for functions, models and other objects.
        sha256: Hash of its file; None without a file.
    """

    name: str
    policy: Policy
    source: str | None
    sha256: str | None

    def told(self, worlds: Perceived) -> dict[str, Any]:
        """Return its entry in the results, as plain data."""
        told = {"name": self.name, "source": self.source, "sha256": self.sha256}
        observes = worlds.observed_by(self.policy)
        return told if observes is None else {**told, "observes": observes}


def load_entrants(policies: Sequence[Source] | Mapping[str, Source]) -> list[Entrant]:
    """Load policies.

    Args:
        policies: The policies, as ``load_policy`` takes them, perhaps by their names; else names follow from them.

    Raises:
        IrsimGymError: If there are no policies, some do not exist, or one is given twice.
    """
    sources = list(policies.values() if isinstance(policies, Mapping) else policies)
    check_entrants(sources)
    names = list(policies) if isinstance(policies, Mapping) else policy_names(sources)
    places = map(place_of, sources)
    return [
        Entrant(name, policy, place, None if place is None else policy_digest(place))
        for name, policy, place in zip(names, load_policies(sources), places, strict=True)
    ]


def check_entrants(sources: Sequence[Source]) -> None:
    """Check that there are policies, each of them once.

    Raises:
        IrsimGymError: If there is none, or one is given twice.
    """
    if not sources:
        raise IrsimGymError(f"an arena needs policies\n{cure_of()}")
    texts = [text for text in map(place_of, sources) if text is not None]
    twice = sorted({text for text in texts if texts.count(text) > 1})
    if twice:
        raise IrsimGymError(f"an arena plays each policy once, but {', '.join(twice)} is given more than once")


def place_of(source: object) -> str | None:
    """Return the name or path that something was loaded from; None for plain data and objects."""
    return str(source) if isinstance(source, str | Path) else None
