"""Checks terms of plugins in their first steps.

A watched term is called by way of a ``Watched``, which looks at what it has written. While there is one, steps are not
recorded. Afterwards the checks are removed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from irsim_gym.contract import is_foreign
from irsim_gym.engine import Simulation
from irsim_gym.engine.fused import Fused
from irsim_gym.tasks.term import Term
from irsim_gym.tasks.watched import (
    Bounds,
    Watched,
    WatchedAction,
    WatchedEnding,
    WatchedObservation,
    WatchedReward,
    calls_of,
    options_of,
)

CALLS = 300
"""How many calls of a term are watched."""

MAKERS: dict[str, type[Watched]] = {
    "action": WatchedAction,
    "observations": WatchedObservation,
    "critic_observations": WatchedObservation,
    "rewards": WatchedReward,
    "endings": WatchedEnding,
}


class TermWatch:
    """Watches the terms of a task that are not the package's own.

    Args:
        terms: The terms by family, see ``Episodes.terms``.
        simulation: What they are played in.
        bounds: Least and greatest values of each observation, by family and name.
        recorded: What must not be recorded meanwhile.

    Attributes:
        is_on: Somebody is watched.
    """

    def __init__(
        self,
        terms: Mapping[str, Sequence[Term]],
        simulation: Simulation,
        bounds: Mapping[tuple[str, str], Bounds],
        recorded: Sequence[Fused],
    ) -> None:
        self._watched: list[tuple[Term, Watched]] = []
        for family, members in terms.items():
            for term in members:
                if is_foreign(type(term.options)):
                    watched = MAKERS[family](term, simulation, bounds.get((family, term.name)))
                    term.options = watched
                    self._watched.append((term, watched))
        self.is_on = bool(self._watched)
        self._recorded = [(function, function.is_fusable) for function in recorded] if self.is_on else []
        for function, _ in self._recorded:
            function.is_fusable = False

    def end_if_seen(self) -> None:
        """Let go of all terms if each has been watched for long enough; between two steps."""
        if any(calls_of(watched) < CALLS for _, watched in self._watched):
            return
        for term, watched in self._watched:
            term.options = options_of(watched)
        for function, is_fusable in self._recorded:
            function.is_fusable = is_fusable
        self._watched, self._recorded, self.is_on = [], [], False


def kind_of(term: Term) -> type[Any]:
    """Return the kind of a term, also while it is watched."""
    return type(options_of(term.options) if isinstance(term.options, Watched) else term.options)
