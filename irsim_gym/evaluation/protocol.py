"""The evaluation: a policy drives every level of a split once, many levels at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.metrics import HITS, EpisodeRow
from irsim_gym.evaluation.optimum import Optima
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.world.model import ROBOT

Actions = NDArray[Any]


@runtime_checkable
class Policy(Protocol):
    """What drives the agents of many worlds."""

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Take note that levels begin in worlds, arrays ``(n,)``."""

    def act(self, episodes: Episodes, worlds: Ints) -> Actions:
        """Return the actions of worlds: ``(n, action_dim)`` in [-1, 1], or ``(n,)`` integers."""


class ObservationPolicy:
    """A policy that sees the observation alone.

    Args:
        function: Turns flat observations, float32 ``(n, n_features)``, into actions ``(n, action_dim)`` or ``(n,)``.
    """

    def __init__(self, function: Callable[[NDArray[np.float32]], Actions]) -> None:
        self.function = function

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Do nothing: the policy has no memory."""

    def act(self, episodes: Episodes, worlds: Ints) -> Actions:
        """Return the actions of worlds."""
        return self.function(episodes.view.observation[worlds, 0])


def evaluate(
    policy: Policy | Callable[[NDArray[np.float32]], Actions],
    episodes: Episodes,
    levels: int | Sequence[int],
    split: str = "test",
    *,
    optima: Optima | None = None,
    on_episodes: Callable[[int], None] | None = None,
) -> list[EpisodeRow]:
    """Drive levels of a split once each and return a row per episode, in the order of the levels.

    A world whose episode ends goes on with the next level at once. A level's result depends neither on the
    number of worlds nor on the other levels.

    Args:
        policy: A policy, or a function of the observation alone.
        episodes: Worlds with one agent each, see ``irsim_gym.tasks.Episodes``.
        levels: Their number (levels 0, 1, ...) or their indices.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        optima: Geodesic optima that earlier evaluations of the same split found; filled further.
        on_episodes: Called with the number of episodes that have just ended.

    Raises:
        IrsimGymError: The task has several agents.
    """
    if episodes.n_agents != 1:
        raise IrsimGymError(f"evaluation drives one agent per world, the task has {episodes.n_agents}")
    chosen = np.arange(levels, dtype=np.int64) if isinstance(levels, int) else np.asarray(levels, dtype=np.int64)
    driver = policy if isinstance(policy, Policy) else ObservationPolicy(policy)
    found = Optima(split) if optima is None else optima
    if found.split != split:
        raise ValueError(f"these optima are of '{found.split}', the levels of '{split}'")
    rows: list[EpisodeRow | None] = [None] * chosen.size
    for indices, worlds in _run(driver, episodes, chosen, split):
        for index, world in zip(indices, worlds, strict=True):
            rows[index] = _row(episodes, found, int(world), int(chosen[index]))
        if on_episodes is not None:
            on_episodes(len(worlds))
    return [row for row in rows if row is not None]


def _run(policy: Policy, episodes: Episodes, levels: Ints, split: str) -> Iterator[tuple[Ints, Ints]]:
    """Yield which episodes (indices into levels) have just ended, and in which worlds."""
    running = np.arange(min(episodes.n_worlds, levels.size), dtype=np.int64)
    episode = np.full(episodes.n_worlds, -1, dtype=np.int64)
    following = 0
    idle = running
    actions: Actions | None = None
    while running.size:
        begun = idle[: levels.size - following]
        if begun.size:
            episode[begun] = np.arange(following, following + begun.size)
            following += begun.size
            episodes.begin(begun, levels[episode[begun]], split)
            policy.begin(episodes, begun, levels[episode[begun]])
        running = running[~np.isin(running, idle[begun.size :])]
        if not running.size:
            return
        chosen = np.asarray(policy.act(episodes, running))
        if actions is None:
            actions = np.zeros((episodes.n_worlds, 1, *chosen.shape[1:]), chosen.dtype)
        actions[running, 0] = chosen
        episodes.step(actions, running)
        idle = running[episodes.view.infos["outcome"][running, 0] != Outcome.RUNNING]
        if idle.size:
            yield episode[idle], idle


def _row(episodes: Episodes, optima: Optima, world: int, level: int) -> EpisodeRow:
    infos = {name: values[world, 0] for name, values in episodes.view.infos.items()}
    steps = int(infos["steps"])
    outcome = Outcome(int(infos["outcome"]))
    return EpisodeRow(
        level=level,
        outcome=outcome.name.lower(),
        hit=hit_kind(episodes, int(infos["hit"])) if outcome is Outcome.COLLISION else "",
        steps=steps,
        time=steps * float(episodes.simulation.model.step_time[0]),
        path_length=float(infos["path_length"]),
        optimum=optima.of(episodes, world, level),
        min_clearance=float(infos["min_clearance"]),
    )


def hit_kind(episodes: Episodes, body: int) -> str:
    """Return what a body is to the robot that touched it, one of ``HITS``."""
    model = episodes.simulation.model
    if model.role[body] == ROBOT:
        return HITS[2]
    return HITS[0] if model.stands[body] else HITS[1]
