"""The policies of an arena."""

from __future__ import annotations

from collections.abc import Sequence
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


def load_entrants(sources: Sequence[Source], names: Sequence[str] | None = None) -> list[Entrant]:
    """Load policies.

    Args:
        sources: The policies, as ``load_policy`` takes them.
        names: Their names; None to derive them from the sources.

    Raises:
        IrsimGymError: If there are no policies, some do not exist, or one is given twice.
    """
    check_entrants(sources)
    called = policy_names(sources) if names is None else list(names)
    texts = _texts(sources)
    loaded = load_policies(sources)
    return [
        Entrant(*parts, None if parts[2] is None else policy_digest(parts[2]))
        for parts in zip(called, loaded, texts, strict=True)
    ]


def check_entrants(sources: Sequence[Source]) -> None:
    """Check that there are policies, each of them once.

    Raises:
        IrsimGymError: If there is none, or one is given twice.
    """
    if not sources:
        raise IrsimGymError(f"an arena needs policies\n{cure_of()}")
    texts = [text for text in _texts(sources) if text is not None]
    twice = sorted({text for text in texts if texts.count(text) > 1})
    if twice:
        raise IrsimGymError(f"an arena plays each policy once, but {', '.join(twice)} is given more than once")


def _texts(sources: Sequence[Source]) -> list[str | None]:
    """Return the name or path of each policy; None for objects."""
    return [str(source) if isinstance(source, str | Path) else None for source in sources]
