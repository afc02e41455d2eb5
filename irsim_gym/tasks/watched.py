"""Checks of a call of a plugin's term: what it returns, and what it writes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.contract import refuse
from irsim_gym.engine import Shard, Simulation
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import Term
from irsim_gym.world.model import Model
from irsim_gym.world.state import State

Numbers = NDArray[Any]
"""An array of floats, bytes or flags, by family."""
Bounds = tuple[NDArray[np.floating], NDArray[np.floating]]
"""Lower and upper bound of each column."""
CLOSELY = 3
"""Number of first calls in which all arrays that a term could change are checked."""
MARK = 2.0**100
"""Marker for elements that a term must write; exact in float32."""
UNSURE = 2.0**90
"""Larger numbers result from adding to the marker."""
BYTE = 171
"""Marker for bytes, a value that may occur in single bytes."""
SLACK = 1e-6
"""Tolerance of bounds for rounding to float32."""
FREE = {"random"}
"""Arrays that any term may write: the worlds' random streams."""
TARGETS = {
    "action": {"action", "previous_action"},
    "observation": {"observation"},
    "reward": {"reward_term"},
    "ending": {"ending"},
}
"""Arrays of the ``EpisodeState`` that the terms of a family may write."""


class Watched(ABC):
    """Replaces the options of a term, and checks what the term writes.

    Apart from the term's method, it has no public names, so that it forwards all other names to the options.
    """

    _family = ""
    _method = ""

    def __init__(self, term: Term, simulation: Simulation, bounds: Bounds | None) -> None:
        self._options = term.options
        self._calls = 0
        self._bounds = bounds
        self._agents = [simulation.parts.names[int(b)] for b in term.agents]
        self._is_alone = simulation.shards.n_slots == 1
        self._fresh: Flags = np.ones(simulation.n_worlds, np.bool_)

    def __getattr__(self, name: str) -> Any:
        if name == "_options" or name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._options, name)

    def _check_call(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the term, and check what it did.

        Raises:
            KindError: If it did something that its family does not allow.
        """
        parts = [shard.worlds]
        if self._calls == 0 and self._is_alone and len(shard.worlds) > 1:
            parts = [shard.worlds[:1], shard.worlds[1:]]  # reveals a term that writes into all worlds
        for worlds in parts:
            self._check_worlds(term, (model, state, episode), Shard(worlds, shard.slot))
        self._calls += 1

    def _check_worlds(self, term: Term, moment: tuple[Model, State, EpisodeState], shard: Shard) -> None:
        model, state, episode = moment
        worlds = shard.worlds
        target = self._target(term, episode)
        marked = worlds[self._fresh[worlds]]
        self._fresh[worlds] = False
        self._mark(term, target, marked)
        before, closely = target.copy(), self._others(state, episode) if self._calls < CLOSELY else {}
        returned = getattr(self._options, self._method)(
            replace(term, options=self._options), model, state, episode, shard
        )
        problems = self._problems(term, episode, target, before, worlds, marked, returned)
        self._raise_problem(term, next(problems, None) or next(self._changes(closely, worlds), None))

    def _problems(
        self,
        term: Term,
        episode: EpisodeState,
        target: Numbers,
        before: Numbers,
        worlds: Ints,
        marked: Ints,
        returned: object,
    ) -> Iterator[str]:
        """Yield problems with the output, causes before consequences."""
        where = self._where(term)
        if self._is_untouched(term, target, marked):
            if returned is not None:
                yield f"returns {_short(returned)} and writes nothing: it must write into {where}"
            yield f"leaves {where} as it was, at least for some agents: it must be written in each call"
        yield from self._overwritten(term, target, before, worlds)
        yield from self._values(term, episode, worlds, before)
        if returned is not None:
            yield f"returns {_short(returned)}, which is not used: it must write into {where}"

    def _raise_problem(self, term: Term, problem: str | None) -> None:
        if problem is not None:
            refuse(self._family, term.name, type(self._options), [f"{self._method}() {problem}"], self._method)

    @abstractmethod
    def _target(self, term: Term, episode: EpisodeState) -> Numbers:
        """Return the output array of all terms of the family, ``(n_worlds, n_agents, n_columns)``."""

    @abstractmethod
    def _where(self, term: Term) -> str:
        """Return the output of the term, as code for messages."""

    @abstractmethod
    def _own(self, term: Term) -> slice:
        """Return the columns of the term."""

    @abstractmethod
    def _mark(self, term: Term, target: Numbers, worlds: Ints) -> None:
        """Fill the term's output in some worlds with the marker."""

    @abstractmethod
    def _is_untouched(self, term: Term, target: Numbers, worlds: Ints) -> bool:
        """Return whether some of the marker is left."""

    @abstractmethod
    def _values(self, term: Term, episode: EpisodeState, worlds: Ints, before: Numbers) -> Iterator[str]:
        """Yield problems with the numbers that the term wrote."""

    def _overwritten(self, term: Term, target: Numbers, before: Numbers, worlds: Ints) -> Iterator[str]:
        """Yield changes of other terms' columns, and of worlds that the term must not treat."""
        own = self._own(term)
        others = np.ones(target.shape[2], np.bool_)
        others[own] = False
        changed = ~_same(target[worlds][..., others], before[worlds][..., others])
        if changed.any():
            column = int(np.flatnonzero(others)[np.argwhere(changed)[0, 2]])
            theirs = "columns" if own.stop - own.start > 1 else "column"
            span = f"{own.start} to {own.stop - 1}" if own.stop - own.start > 1 else f"{own.start}"
            yield f"writes column {column}, which is another term's; its own {theirs}: {span}, from term.column on"
        elsewhere = np.ones(len(target), np.bool_)
        elsewhere[worlds] = False
        if self._is_alone and not _same(target[elsewhere], before[elsewhere]).all():
            yield f"writes into worlds that are not in shard.worlds ({worlds[:5].tolist()}): index by shard.worlds"

    def _others(self, state: State, episode: EpisodeState) -> dict[str, tuple[Numbers, Numbers]]:
        """Return the arrays that the term must not write, with copies of them."""
        target = TARGETS[self._family]
        found = {f"state.{one.name}": getattr(state, one.name) for one in fields(state) if one.name not in FREE}
        found |= {
            f"episode.{one.name}": getattr(episode, one.name) for one in fields(episode) if one.name not in target
        }
        return {name: (array, array.copy()) for name, array in found.items() if isinstance(array, np.ndarray)}

    def _changes(self, closely: Mapping[str, tuple[Numbers, Numbers]], worlds: Ints) -> Iterator[str]:
        for name, (now, before) in closely.items():
            if now.dtype.names is None and not _same(now[worlds], before[worlds]).all():
                yield f"changes {name}, which it may only read"

    def _name(self, place: Ints, worlds: Ints) -> str:
        """Return agent and world of a place ``(world, agent, ...)`` of rows, as text."""
        return f"for {self._agents[int(place[1])]} in world {int(worlds[int(place[0])])}"


class WatchedReward(Watched):
    """Watches a reward, whose role determines its sign."""

    _family, _method = "reward", "pay"

    def __init__(self, term: Term, simulation: Simulation, bounds: Bounds | None) -> None:
        super().__init__(term, simulation, bounds)
        self._paid = np.zeros((simulation.n_worlds, len(term.agents)))

    def pay(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the reward, and check it."""
        self._check_call(term, model, state, episode, shard)

    def _target(self, term: Term, episode: EpisodeState) -> Numbers:
        return episode.reward_term

    def _where(self, term: Term) -> str:
        return "episode.reward_term[shard.worlds, :, term.column]"

    def _own(self, term: Term) -> slice:
        return slice(term.column, term.column + 1)

    def _mark(self, term: Term, target: Numbers, worlds: Ints) -> None:
        target[worlds, :, self._own(term)] = MARK

    def _is_untouched(self, term: Term, target: Numbers, worlds: Ints) -> bool:
        return _is_marked(target[worlds, :, self._own(term)])

    def _values(self, term: Term, episode: EpisodeState, worlds: Ints, before: Numbers) -> Iterator[str]:
        amounts = np.where(episode.over[worlds], 0.0, episode.reward_term[worlds, :, term.column])
        if not np.isfinite(amounts).all():
            place = np.argwhere(~np.isfinite(amounts))[0]
            yield f"writes {amounts[tuple(place)]} {self._name(place, worlds)}: a reward must be a finite number"
            return
        role, weight = self._options.role, self._options.weight
        # What an agent was paid so far in this episode; the first step begins anew.
        sums = self._paid[worlds] * (episode.steps[worlds] > 1) + amounts
        self._paid[worlds] = sums
        slack = SLACK * max(1.0, weight)
        for wrong, rule in (
            ((amounts > slack) & (role in ("running", "penalty")), f"a {role} term is never positive: write -amount"),
            ((amounts < -slack) & (role == "bonus"), "a bonus is never negative; its counterpart is role = 'penalty'"),
            (
                (sums < -weight - slack) & (role == "running"),
                f"a running term costs at most its weight, {weight:g}, in an episode, and has cost more by now: "
                "spread it, weight / term.max_steps in a step",
            ),
            (
                (sums > weight + slack) & (role == "bonus"),
                f"a bonus is paid once in an episode, its weight, {weight:g}; it has paid more by now",
            ),
            (
                (amounts > slack) & (role == "bonus") & (episode.outcome[worlds] != self._options.outcome),
                f"a bonus is paid where episode.outcome is {_outcome(self._options.outcome)}",
            ),
        ):
            if wrong.any():
                place = np.argwhere(wrong)[0]
                yield f"writes {amounts[tuple(place)]:+.4g} {self._name(place, worlds)}, role '{role}': {rule}"


class WatchedObservation(Watched):
    """Watches an observation, which must be within its bounds."""

    _family, _method = "observation", "write"

    def write(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the observation, and check it."""
        self._check_call(term, model, state, episode, shard)

    def _target(self, term: Term, episode: EpisodeState) -> Numbers:
        return term.image.reshape(*term.image.shape[:2], -1) if self._bounds is None else episode.observation

    def _where(self, term: Term) -> str:
        if self._bounds is None:
            return "term.image[shard.worlds]"
        return "episode.observation[shard.worlds, :, term.column + k], each k from 0 to the width of bounds()"

    def _own(self, term: Term) -> slice:
        if self._bounds is None:
            return slice(0, int(np.prod(term.image.shape[2:])))
        return slice(term.column, term.column + self._bounds[0].size)

    def _mark(self, term: Term, target: Numbers, worlds: Ints) -> None:
        target[worlds, :, self._own(term)] = MARK if self._bounds is not None else BYTE

    def _is_untouched(self, term: Term, target: Numbers, worlds: Ints) -> bool:
        if self._bounds is not None:
            return _is_marked(target[worlds, :, self._own(term)])
        return bool(len(worlds)) and bool((target[worlds] == BYTE).all(axis=2).any())

    def _values(self, term: Term, episode: EpisodeState, worlds: Ints, before: Numbers) -> Iterator[str]:
        if self._bounds is None:
            return
        seen, (low, high) = episode.observation[worlds][..., self._own(term)], self._bounds
        for wrong, rule in (
            (~np.isfinite(seen), "it must be finite"),
            (seen < low - SLACK, "bounds() says at least {low:g}"),
            (seen > high + SLACK, "bounds() says at most {high:g}"),
        ):
            if wrong.any():
                place = np.argwhere(wrong)[0]
                k = int(place[2])
                wanted = rule.format(low=float(low[k]), high=float(high[k]))
                yield f"writes {seen[tuple(place)]:g} into element {k} {self._name(place, worlds)}: {wanted}"


class WatchedEnding(Watched):
    """Watches an ending."""

    _family, _method = "ending", "ends"

    def ends(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the ending, and check it."""
        self._check_call(term, model, state, episode, shard)

    def _target(self, term: Term, episode: EpisodeState) -> Numbers:
        return episode.ending.view(np.uint8)

    def _where(self, term: Term) -> str:
        return "episode.ending[shard.worlds, :, term.column]"

    def _own(self, term: Term) -> slice:
        return slice(term.column, term.column + 1)

    def _mark(self, term: Term, target: Numbers, worlds: Ints) -> None:
        target[worlds, :, self._own(term)] = BYTE

    def _is_untouched(self, term: Term, target: Numbers, worlds: Ints) -> bool:
        return bool((target[worlds, :, self._own(term)] == BYTE).any())

    def _values(self, term: Term, episode: EpisodeState, worlds: Ints, before: Numbers) -> Iterator[str]:
        yield from ()


class WatchedAction(Watched):
    """Watches an action, which must be in [-1, 1] and keep the previous one."""

    _family, _method = "action", "act"

    def __init__(self, term: Term, simulation: Simulation, bounds: Bounds | None) -> None:
        super().__init__(term, simulation, bounds)
        self._latest: tuple[Floats, Floats] | None = None
        self._answers = False

    def act(self, term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Call the action, and check it."""
        self._check_call(term, model, state, episode, shard)

    def _target(self, term: Term, episode: EpisodeState) -> Numbers:
        return episode.action

    def _where(self, term: Term) -> str:
        return "episode.action[shard.worlds]"

    def _own(self, term: Term) -> slice:
        return slice(0, term.action_size)

    def _mark(self, term: Term, target: Numbers, worlds: Ints) -> None:
        """Keep the latest action, which the term may read."""

    def _is_untouched(self, term: Term, target: Numbers, worlds: Ints) -> bool:
        return False  # nothing is marked; ``_ignored_input`` finds actions without effect

    def _values(self, term: Term, episode: EpisodeState, worlds: Ints, before: Numbers) -> Iterator[str]:
        acted = episode.action[worlds]
        wrong = ~(np.abs(acted) <= 1.0 + SLACK)
        if wrong.any():
            place = np.argwhere(wrong)[0]
            yield f"writes {acted[tuple(place)]:g} {self._name(place, worlds)}: an action lies in [-1, 1]"
        if not _same(episode.previous_action[worlds], before[worlds]).all():
            yield "does not keep the action before: first write episode.previous_action[...] = episode.action[...]"
        if self._is_alone:
            yield from self._ignored_input(episode)

    def _ignored_input(self, episode: EpisodeState) -> Iterator[str]:
        """Yield a problem if the learners' actions have no effect."""
        given = np.concatenate([episode.given.ravel(), episode.choice.ravel()])
        if self._latest is not None and not np.array_equal(given, self._latest[0]):
            self._answers |= not np.array_equal(episode.action, self._latest[1])
            if not self._answers and self._calls > CLOSELY:
                yield "writes the same action whatever is given: episode.given, or episode.choice with n_choices > 0"
        self._latest = given, episode.action.copy()


def _is_marked(written: Numbers) -> bool:
    """Return whether some numbers are still the marker, or result from adding to it."""
    return bool(((np.abs(written) > UNSURE) & np.isfinite(written)).any())


def _same(now: Numbers, before: Numbers) -> Flags:
    """Return where numbers are equal; NaN equals NaN."""
    found: Flags = (now == before) | ((now != now) & (before != before))
    return found


def _short(value: object) -> str:
    shape = f" of shape {value.shape}" if isinstance(value, np.ndarray) else ""
    return f"{type(value).__name__}{shape}"


def _outcome(value: Outcome) -> str:
    return f"Outcome.{Outcome(value).name}"


def calls_of(watched: Watched) -> int:
    """Return the number of calls of a watched term."""
    return watched._calls


def options_of(watched: Watched) -> Any:
    """Return the options that a ``Watched`` replaces."""
    return watched._options
