"""Checks terms of plugins in their first calls: what they return, and what they write.

While a term is watched, steps are not recorded. Afterwards, the checks are removed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.base.contract import is_foreign, refuse
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.tasks.terms import EpisodeState, Model, Outcome, Shard, Simulation, State
from irsim_gym.tasks.terms.term import IsImage, Term

CALLS, CLOSELY = 300, 3
"""Number of calls of a term that are watched, and of the first ones, in which all arrays are compared."""
MARK, BYTE = 2.0**100, 171
"""Markers of numbers (exact in float32) and of bytes and flags that a term must write."""
SLACK = 1e-6
"""Tolerance of bounds for rounding to float32."""
COLUMNS = "episode.observation[shard.worlds, :, term.column + k], each k from 0 to the width of bounds()"
OUTPUTS: dict[str, tuple[str, str, str]] = {
    "action": ("act", "action", "episode.action[shard.worlds]"),
    "observation": ("write", "observation", COLUMNS),
    "picture": ("write", "image", "term.image[shard.worlds]"),
    "reward": ("pay", "reward_term", "episode.reward_term[shard.worlds, :, term.column]"),
    "ending": ("ends", "ending", "episode.ending[shard.worlds, :, term.column]"),
}
"""Method of a kind, the array that it writes, and this as code for messages."""


class TermWatch:
    """Watches the terms of a task that come from plugins.

    Args:
        terms: The terms by family, see ``Episodes.terms``.
        simulation: The simulation.
        recorded: Functions that must not be recorded while terms are watched.

    Attributes:
        is_on: Whether any term is watched.
    """

    def __init__(self, terms: Mapping[str, Sequence[Term]], simulation: Simulation, recorded: Sequence[Fused]) -> None:
        self._checks: list[tuple[Term, CallCheck]] = []
        for key, those in terms.items():
            family = key.removesuffix("s")
            for term in (one for one in those if is_foreign(type(one.options))):
                term.watched = check = CallCheck(family, term, simulation)
                self._checks.append((term, check))
        self.is_on = bool(self._checks)
        self._recorded = [function for function in recorded if function.is_fusable and self.is_on]
        for function in self._recorded:
            function.is_fusable = False

    def end_if_seen(self) -> None:
        """Stop watching if all terms have been watched for long enough; to be called between steps."""
        if all(check.calls >= CALLS for _, check in self._checks):
            for term, _ in self._checks:
                term.watched = None
            for function in self._recorded:
                function.is_fusable = True
            self._checks, self.is_on = [], False


class CallCheck:
    """Calls a term in place of its method, and checks what the method does.

    Attributes:
        calls: Number of calls so far.
    """

    def __init__(self, family: str, term: Term, simulation: Simulation) -> None:
        self.calls = 0
        self._family = family
        self._output = "picture" if family == "observation" and isinstance(term.options, IsImage) else family
        ones = np.ones(term.action_size if family == "action" else 0)
        self._bounds = (-ones, ones) if family == "action" else term.bounds
        first = term.column if self._output in ("observation", "reward", "ending") else 0
        width = term.image[0, 0].size if self._output == "picture" else max(1, len(self._bounds[0]))
        self._own = slice(first, first + width)
        self._names = [simulation.parts.names[int(b)] for b in term.agents]
        self._is_alone = simulation.shards.n_slots == 1
        self._fresh: Flags = np.full(simulation.n_worlds, family != "action")  # the latest action may be read
        self._paid = np.zeros((simulation.n_worlds, len(term.agents), 1))
        self._latest: tuple[NDArray[Any], NDArray[Any]] | None = None
        self._answers = False

    def __call__(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the term, and check what it did.

        Raises:
            KindError: If it did something that its family does not allow.
        """
        # The first call is made in two parts, which reveals a term that writes into all worlds.
        split = 1 if self.calls == 0 and self._is_alone else 0
        for worlds in filter(len, (shard.worlds[:split], shard.worlds[split:])):
            self._check_worlds(term, model, state, episode, Shard(worlds, shard.slot))
        self.calls += 1

    def _check_worlds(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        worlds, (method, array, _) = shard.worlds, OUTPUTS[self._output]
        holder: Any = term if array == "image" else episode
        rows: NDArray[Any] = getattr(holder, array).reshape(*getattr(holder, array).shape[:2], -1)
        rows = rows.view(np.uint8) if rows.dtype == np.bool_ else rows
        fresh = worlds[self._fresh[worlds]]
        self._fresh[worlds] = False
        rows[fresh, :, self._own] = BYTE if rows.dtype == np.uint8 else MARK
        free = {"random", array, "previous_action" if array == "action" else ""}
        before = {"": (rows, rows.copy()), **(_arrays(state, episode, free) if self.calls < CLOSELY else {})}
        returned = getattr(term.options, method)(term, model, state, episode, shard)
        problem = next(self._problems(term, episode, before, worlds, fresh, returned), None)
        if problem is not None:
            refuse(self._family, term.name, type(term.options), [f"{method}() {problem}"], method)

    def _problems(
        self,
        term: Term,
        episode: EpisodeState,
        arrays: dict[str, tuple[NDArray[Any], NDArray[Any]]],
        worlds: Ints,
        fresh: Ints,
        returned: object,
    ) -> Iterator[str]:
        """Yield problems with the output, causes before consequences."""
        own, place, (rows, before) = self._own, OUTPUTS[self._output][2], arrays.pop("")
        answer = type(returned).__name__ + (f" of shape {returned.shape}" if isinstance(returned, np.ndarray) else "")
        if _is_marked(rows[fresh, :, own]):
            if returned is not None:
                yield f"returns {answer} and writes nothing: it must write into {place}"
            yield f"leaves {place} as it was, at least for some agents: it must be written in each call"
        changed = _differ(rows, before)
        others = changed[worlds]
        others[..., own] = False
        if others.any():
            span = f"column: {own.start}" if own.stop - own.start == 1 else f"columns: {own.start} to {own.stop - 1}"
            column = np.argwhere(others)[0, 2]
            yield f"writes column {column}, which is another term's; its own {span}, from term.column on"
        changed[worlds] = False
        if self._is_alone and changed.any():
            yield f"writes into worlds that are not in shard.worlds ({worlds[:5].tolist()}): index by shard.worlds"
        values = rows[worlds][..., own]
        for wrong, rule in self._rules(term, episode, values, worlds):
            if wrong.any():
                w, a, k = np.argwhere(wrong)[0].tolist()
                element = f" into element {k}" if own.stop - own.start > 1 else ""
                rule = rule.format(*(bound[k] for bound in self._bounds if bound.size))
                yield f"writes {values[w, a, k]:g}{element} for {self._names[a]} in world {worlds[w]}: {rule}"
        if self._family == "action":
            if _differ(episode.previous_action[worlds], before[worlds]).any():
                yield "does not keep the action before: first write episode.previous_action[...] = episode.action[...]"
            yield from self._ignored_input(episode)
        if returned is not None:
            yield f"returns {answer}, which is not used: it must write into {place}"
        for name, (now, earlier) in arrays.items():
            if _differ(now[worlds], earlier[worlds]).any():
                yield f"changes {name}, which it may only read"

    def _rules(
        self, term: Term, episode: EpisodeState, values: NDArray[Any], worlds: Ints
    ) -> Iterator[tuple[Flags, str]]:
        """Yield which of the numbers ``(n, n_agents, width)`` break a rule, and the rule."""
        if self._bounds[0].size:
            low, high = self._bounds
            says = "an action lies" if self._family == "action" else "bounds() says that it is finite and"
            yield ~((values >= low - SLACK) & (values <= high + SLACK)), says + " in [{0:g}, {1:g}]"
        if self._family != "reward":
            return
        role, weight = term.options.role, term.options.weight
        amounts = np.where(episode.over[worlds][..., None], 0.0, values)
        yield ~np.isfinite(amounts), "a reward must be a finite number"
        # What an agent was paid so far in this episode; the first step begins anew.
        sums = self._paid[worlds] * (episode.steps[worlds] > 1)[..., None] + amounts
        self._paid[worlds] = sums
        slack = SLACK * max(1.0, weight)
        if role in ("running", "penalty"):
            yield amounts > slack, f"a {role} term is never positive: write -amount"
        if role == "running":
            yield (
                sums < -weight - slack,
                f"a running term costs at most its weight, {weight:g}, in an episode, and has cost more by "
                "now: spread it, weight / term.max_steps in a step",
            )
        if role == "bonus":
            outcome = Outcome(term.options.outcome)
            yield amounts < -slack, "a bonus is never negative; its counterpart is role = 'penalty'"
            yield sums > weight + slack, f"a bonus pays its weight, {weight:g}, once in an episode; it has paid more"
            yield (
                (amounts > slack) & (episode.outcome[worlds] != outcome)[..., None],
                f"a bonus is paid where episode.outcome is Outcome.{outcome.name}",
            )

    def _ignored_input(self, episode: EpisodeState) -> Iterator[str]:
        """Yield a problem if the learners' actions have no effect."""
        given = np.concatenate([episode.given.ravel(), episode.choice.ravel()])
        if self._is_alone and self._latest is not None and not np.array_equal(given, self._latest[0]):
            self._answers |= not np.array_equal(episode.action, self._latest[1])
            if not self._answers and self.calls > CLOSELY:
                yield "writes the same action whatever is given: episode.given, or episode.choice with n_choices > 0"
        self._latest = given, episode.action.copy()


def _arrays(state: State, episode: EpisodeState, free: set[str]) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Return the arrays that a term must not write, with copies, by how code names them."""
    holders: tuple[tuple[str, Any], ...] = ("state", state), ("episode", episode)
    found = {
        f"{name}.{one.name}": getattr(holder, one.name)
        for name, holder in holders
        for one in fields(holder)
        if one.name not in free
    }
    arrays = {name: one for name, one in found.items() if isinstance(one, np.ndarray) and one.dtype.names is None}
    return {name: (array, array.copy()) for name, array in arrays.items()}


def _is_marked(written: NDArray[Any]) -> bool:
    """Return whether the marker is left, or numbers result from adding to it; a byte may equal it by chance."""
    if written.dtype == np.uint8:
        return bool((written == BYTE).all(axis=2).any())
    return bool(((np.abs(written) > MARK / 1024) & np.isfinite(written)).any())


def _differ(now: NDArray[Any], before: NDArray[Any]) -> Flags:
    """Return where numbers differ; NaN equals NaN."""
    differ: Flags = (now != before) & ((now == now) | (before == before))
    return differ
