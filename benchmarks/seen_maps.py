"""What observations of the seen map add to a step: the same robots on the same ways, with and without them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from effort import Effort, Figures
from numpy.typing import NDArray
from players import Player

from irsim_gym.envs import Worlds
from irsim_gym.evaluation import BehaviorPolicy

SCENARIO, N_WORLDS, STEPS = "dense_room", 256, 100
ADDED = {"plain": (), "way_on_seen_map": ("way_on_seen_map",), "seen_map_image": ("seen_map_image",)}


def seen_maps(effort: Effort) -> Figures:
    """Measure a step of robots that `pursuit` has driven, per robot; the ratios are those of the least times."""
    n_worlds = effort.sizes((1, N_WORLDS))[-1]
    given = driven(n_worlds, STEPS if n_worlds > 1 else 2)
    timings = effort.in_turns_us({name: player(names, given) for name, names in ADDED.items()})
    figures: Figures = {f"{name}_us": timing for name, timing in timings.items()}
    plain = timings["plain"].least
    return figures | {f"{name}_over_plain": timings[name].least / plain for name in ADDED if name != "plain"}


def worlds_with(names: tuple[str, ...], n_worlds: int) -> Worlds:
    """Return worlds whose robots observe more than usual."""
    task: dict[str, Any] = {"name": "navigation", "observations": list(names)}
    return Worlds(SCENARIO, n_worlds, task=task)


def begin(worlds: Worlds) -> None:
    """Begin the same levels everywhere."""
    numbers = range(worlds.n_worlds)
    worlds.begin(numbers, numbers, [{}] * worlds.n_worlds, lambda w: w)


def begin_ended(worlds: Worlds) -> NDArray[np.int64]:
    """Begin the next levels of worlds that have ended, and return these."""
    ended = np.flatnonzero(~worlds.episodes.view.live.any(axis=1))
    if len(ended):
        worlds.begin_next(ended)
    return ended


def driven(n_worlds: int, steps: int) -> NDArray[np.float32]:
    """Return the actions of `pursuit`, which knows the whole map, shape ``(steps, n_worlds, 1, 2)``."""
    worlds, policy, everybody = worlds_with((), n_worlds), BehaviorPolicy("pursuit"), np.arange(n_worlds)
    begin(worlds)
    policy.begin(worlds.episodes, everybody, everybody)
    given = []
    for _ in range(steps):
        given.append(np.asarray(policy.act(worlds.episodes, everybody), np.float32).reshape(n_worlds, 1, 2))
        worlds.step(given[-1])
        ended = begin_ended(worlds)
        if len(ended):
            policy.begin(worlds.episodes, ended, ended)
    return np.array(given)


def player(names: tuple[str, ...], given: NDArray[np.float32]) -> Player:
    """Return worlds that repeat these actions, with some observations more."""
    n_worlds = given.shape[1]
    worlds = worlds_with(names, n_worlds)
    left: list[Iterator[NDArray[np.float32]]] = []

    def rewind() -> None:
        begin(worlds)
        left[:] = [iter(given)]

    def step() -> None:
        worlds.step(next(left[0]))
        begin_ended(worlds)

    return Player(step, n_worlds, rewind, len(given))
