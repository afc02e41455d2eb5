"""Checks calls of terms of plugins: what they return, and what they write; for ``irsim-gym check`` and tests."""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.contract import is_foreign, refuse
from irsim_gym.simulator.world.names import Flags, Ints
from irsim_gym.tasks.terms import EpisodeState, IsImage, Model, Outcome, Shard, Simulation, State, Term

FEW = 3
"""Number of different inputs from which on an action must differ, too."""
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


def watch_terms(terms: Mapping[str, Sequence[Term]], simulation: Simulation) -> None:
    """Check each call of the terms that come from plugins, from now on.

    Args:
        terms: The terms of episodes by family, see ``Episodes.terms``.
        simulation: Their simulation, of one thread and compiled with ``fused=False``; with two worlds or more, a term
            that writes into worlds of others is found, too.
    """
    for key, those in terms.items():
        family = key.removesuffix("s")
        for term in (term for term in those if is_foreign(type(term.options))):
            check = CallCheck(family, term, simulation)
            # The copy's own attribute hides the method; the task keeps the kind as it is.
            term.options = copy(term.options)
            vars(term.options)[check.method] = check


class CallCheck:
    """Calls a term in place of its method, one world at a time, and checks what the method does.

    Attributes:
        method: Name of the method.
    """

    def __init__(self, family: str, term: Term, simulation: Simulation) -> None:
        self._family = family
        self._output = "picture" if family == "observation" and isinstance(term.options, IsImage) else family
        self.method, self._array, self._place = OUTPUTS[self._output]
        self._call = getattr(term.options, self.method)
        ones = np.ones(term.action_size if family == "action" else 0)
        self._bounds = (-ones, ones) if family == "action" else term.bounds
        first = term.column if self._output in ("observation", "reward", "ending") else 0
        width = term.image[0, 0].size if self._output == "picture" else max(1, len(self._bounds[0]))
        self._own = slice(first, first + width)
        self._names = [simulation.parts.names[int(b)] for b in term.agents]
        self._paid = np.zeros((simulation.n_worlds, len(term.agents), 1))
        self._given: set[bytes] = set()
        self._actions: set[bytes] = set()

    def __call__(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the term for each world of the shard, and check what it did.

        Raises:
            KindError: If it did something that its family does not allow.
        """
        for worlds in shard.worlds[:, None]:
            holder: Any = term if self._array == "image" else episode
            rows: NDArray[Any] = getattr(holder, self._array)
            rows = rows.reshape(*rows.shape[:2], -1)
            rows = rows.view(np.uint8) if rows.dtype == np.bool_ else rows
            if self._family != "action":  # the latest action may be read
                rows[worlds, :, self._own] = BYTE if rows.dtype == np.uint8 else MARK
            free = {"random", self._array, "previous_action" if self._family == "action" else ""}
            before = {"": (rows, rows.copy()), **_arrays(state, episode, free)}
            returned = self._call(term, model, state, episode, Shard(worlds, shard.slot))
            problem = next(self._problems(term, episode, before, worlds, returned), None)
            if problem is not None:
                refuse(self._family, term.name, type(term.options), [f"{self.method}() {problem}"], self.method)

    def _problems(
        self,
        term: Term,
        episode: EpisodeState,
        arrays: dict[str, tuple[NDArray[Any], NDArray[Any]]],
        worlds: Ints,
        returned: object,
    ) -> Iterator[str]:
        """Yield problems with the output, causes before consequences."""
        own, place, (rows, before) = self._own, self._place, arrays.pop("")
        answer = type(returned).__name__ + (f" of shape {returned.shape}" if isinstance(returned, np.ndarray) else "")
        if self._family != "action" and _is_marked(rows[worlds, :, own]):
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
        if changed.any():
            yield f"writes into worlds that are not in shard.worlds ({worlds.tolist()}): index by shard.worlds"
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
        self._given.add(episode.given.tobytes() + episode.choice.tobytes())
        self._actions.add(episode.action.tobytes())
        if len(self._given) > FEW and len(self._actions) == 1:
            yield "writes the same action whatever is given: episode.given, or episode.choice with n_choices > 0"


def _arrays(state: State, episode: EpisodeState, free: set[str]) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Return the arrays that a term must not write, with copies, by how code names them."""
    holders: tuple[tuple[str, Any], ...] = ("state", state), ("episode", episode)
    parts = ((name, holder, each.name) for name, holder in holders for each in fields(holder))
    every = {f"{name}.{key}": getattr(holder, key) for name, holder, key in parts if key not in free}
    arrays = {name: item for name, item in every.items() if isinstance(item, np.ndarray) and item.dtype.names is None}
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
