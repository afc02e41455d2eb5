"""Checks terms of plugins in their first steps.

A watched term is called through a ``Watched``, which checks what it writes. While a term is watched, steps are not
recorded. Afterwards, the checks are removed.
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
"""Number of calls of a term that are watched."""

MAKERS: dict[str, type[Watched]] = {
    "action": WatchedAction,
    "observations": WatchedObservation,
    "critic_observations": WatchedObservation,
    "rewards": WatchedReward,
    "endings": WatchedEnding,
}


class TermWatch:
    """Watches the terms of a task that come from plugins.

    Args:
        terms: The terms by family, see ``Episodes.terms``.
        simulation: The simulation.
        bounds: Lower and upper bounds of each observation, by family and name.
        recorded: Functions that must not be recorded while terms are watched.

    Attributes:
        is_on: Whether any term is watched.
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
        """Stop watching if all terms have been watched for long enough; to be called between steps."""
        if any(calls_of(watched) < CALLS for _, watched in self._watched):
            return
        for term, watched in self._watched:
            term.options = options_of(watched)
        for function, is_fusable in self._recorded:
            function.is_fusable = is_fusable
        self._watched, self._recorded, self.is_on = [], [], False


def kind_of(term: Term) -> type[Any]:
    """Return the kind of a term, even while it is watched."""
    return type(options_of(term.options) if isinstance(term.options, Watched) else term.options)
