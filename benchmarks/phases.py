"""What each phase of a step takes on the plain path, beside the whole step as one fused call.

The phases are wrapped from outside, the package knows nothing of it. A wrapper takes time itself; it is measured on a
function that does nothing and taken off for each call. A fused step has no phases that Python could see.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import players
from effort import Effort, Figures, repeat
from standard_worlds import s1, s2, s3, s4
from timing import seconds, summed_up

from irsim_gym.envs import Worlds
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.step import arrival, command_limits, outlines, step
from irsim_gym.tasks.actions import commands
from irsim_gym.tasks.episodes import account


class Stopwatch:
    """Sums up wall seconds and calls by phase."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.calls: Counter[str] = Counter()
        self._inside = False

    def around(self, phase: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function with a watch on it; one phase that calls another counts as a whole."""

        def watched(*arguments: Any, **options: Any) -> Any:
            if self._inside:
                return function(*arguments, **options)
            self._inside = True
            begin = time.perf_counter()
            try:
                return function(*arguments, **options)
            finally:
                self.seconds[phase] += time.perf_counter() - begin
                self.calls[phase] += 1
                self._inside = False

        return watched

    def forget(self) -> None:
        """Begin anew."""
        self.seconds.clear()
        self.calls.clear()


def wrapper_cost(count: int = 20_000) -> float:
    """Return the seconds that a watch adds to a call."""
    watch = Stopwatch()
    nothing: Callable[[], None] = lambda: None  # noqa: E731
    watched = watch.around("nothing", nothing)
    best = []
    for _ in range(5):
        begin = time.perf_counter()
        repeat(watched, count)
        middle = time.perf_counter()
        repeat(nothing, count)
        best.append((middle - begin) - (time.perf_counter() - middle))
    return max(0.0, min(best) / count)


def places(worlds: Worlds) -> list[tuple[str, Any, str]]:
    """Return what is wrapped: phase, owner and name of the function."""
    parts, found = worlds.simulation.parts, worlds.episodes
    wrapped: list[tuple[str, Any, str]] = [
        ("begin anew", found, "begin_next"),
        ("act", commands, "take"),
        ("act", found, "_act"),
        ("arrival", arrival, "renew_goals"),
        ("limits", command_limits, "limit_velocity"),
        ("place", outlines, "place"),
        ("buckets", body_buckets, "refresh"),
        ("contact", contact, "find"),
        ("arrival", arrival, "check_arrival"),
        ("sense", step, "sense"),
        ("tick", step, "tick"),
        ("clearance", worlds.simulation, "clearance"),
        ("count", found, "_record_step"),
        ("count", account, "limit_clearance"),
        ("count", account, "decide_outcomes"),
        ("pay", account, "sum_rewards"),
        ("observe", found, "_observe"),
    ]
    deciders = {group.kind for group in [*parts.behaviors, *parts.group_behaviors]}
    wrapped += [("decide", kind, "decide") for kind in deciders]
    wrapped += [("move", kind, "move") for kind in {group.kind for group in parts.kinematics}]
    wrapped += [("pay", kind, "pay") for kind in {type(term) for term in found.task.rewards}]
    wrapped += [("end", kind, "ends") for kind in {type(term) for term in found.task.endings}]
    return wrapped


@contextmanager
def watching(worlds: Worlds, watch: Stopwatch) -> Iterator[None]:
    """Wrap the phases, and take the wrappers off again."""
    kept: list[tuple[Any, str, Any, bool]] = []
    try:
        for phase, owner, name in places(worlds):
            own = name in vars(owner)
            before = vars(owner).get(name)
            watched = watch.around(phase, getattr(owner, name))
            setattr(owner, name, staticmethod(watched) if isinstance(owner, type) else watched)
            kept.append((owner, name, before, own))
        yield
    finally:
        for owner, name, before, own in reversed(kept):
            if own:
                setattr(owner, name, before)
            else:
                delattr(owner, name)


def phases(build: Callable[[], dict[str, Any]], team: bool, effort: Effort) -> Figures:
    """Measure the phases of S1's step and the like, alone and in a large batch, per agent and step."""
    figures: Figures = {}
    added = wrapper_cost()
    for n_worlds in effort.sizes((1, 1024)):
        for phase, values in _measured(build(), n_worlds, team, effort, added).items():
            figures[f"{n_worlds}_worlds_{phase.replace(' ', '_')}_us"] = summed_up(values)
    return figures


def _measured(scenario: dict[str, Any], n_worlds: int, team: bool, effort: Effort, added: float) -> dict[str, Any]:
    """Return microseconds of each phase and of whole steps, ``whole`` and ``fused``, in each round."""
    player, fused = (players.core(scenario, n_worlds, team=team) for _ in range(2))
    use_plain_path(player.worlds)
    count, fused_count, watch = effort.steps(player.step), effort.steps(fused.step), Stopwatch()
    scale = 1e6 / player.n_agents
    found: dict[str, list[float]] = {}
    for _ in range(effort.rounds):
        watch.forget()
        with watching(player.worlds, watch):
            whole = seconds(lambda: repeat(player.step, count), time.perf_counter) - added * watch.calls.total()
        net = {name: max(0.0, taken - added * watch.calls[name]) for name, taken in watch.seconds.items()}
        net |= {"whole": whole, "between phases": max(0.0, whole - sum(net.values()))}
        for name, taken in net.items():
            found.setdefault(name, []).append(scale * taken / count)
        taken = seconds(lambda: repeat(fused.step, fused_count), time.perf_counter)
        found.setdefault("fused", []).append(scale * taken / fused_count)
    return found


def use_plain_path(worlds: Worlds) -> None:
    """Let steps and beginnings of some worlds call phase after phase from Python."""
    for owner in (worlds.episodes, worlds.simulation):
        for fused in vars(owner).values():
            if isinstance(fused, Fused):
                fused.is_fusable = False
                fused.forget()


def s2_task(behavior: str) -> dict[str, Any]:
    """Return S2 with a task, so that it has all phases: nobody learns but the first, whom its behaviour would drive."""
    return {**s2(behavior), "task": {"name": "blank", "max_steps": 80, "observations": ["goal"]}}


PHASES = {
    "phases/s1": partial(phases, s1, False),
    "phases/s2_rvo": partial(phases, partial(s2_task, "rvo"), False),
    "phases/s2_orca": partial(phases, partial(s2_task, "orca"), False),
    "phases/s3_cave": partial(phases, partial(s3, "cave"), False),
    "phases/s4": partial(phases, s4, True),
}
