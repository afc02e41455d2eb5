"""The evaluation protocol: a policy drives each level of a split once, many levels in parallel."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.measures.metrics import HIT_OF_KIND, EpisodeRow
from irsim_gym.evaluation.measures.motion import MotionLog
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.measures.pushes import delivered
from irsim_gym.evaluation.measures.watcher import Watcher
from irsim_gym.evaluation.policies.policy import Actions, ObservationPolicy, Policy, by_agent
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.world.model import KEEP_GOAL
from irsim_gym.tasks import Episodes, Outcome

Driver = Policy | Callable[[Any], Actions]


def evaluate(
    policy: Driver,
    episodes: Episodes,
    levels: int | Sequence[int],
    split: str = "test",
    *,
    optima: Optima | None = None,
    on_episodes: Callable[[int], None] | None = None,
    watcher: Watcher | None = None,
) -> list[EpisodeRow]:
    """Drive each level of a split once, and return one row per episode, in the order of the levels.

    A world whose episode ends starts the next level at once. A level's result depends neither on the number of worlds
    nor on other levels.

    Args:
        policy: A policy, or a function of the observation alone.
        episodes: Worlds with one agent each, see ``irsim_gym.tasks.Episodes``.
        levels: Their number (levels 0, 1, ...) or their indices.
        optima: Geodesic optima of earlier evaluations of the same split; new ones are added.
        on_episodes: Called with the number of episodes that have just ended.
        watcher: Observes each step.

    Raises:
        IrsimGymError: If the task has several agents, see ``evaluate_team``.
    """
    if episodes.n_agents != 1:
        raise IrsimGymError(
            f"this evaluation is for one agent per world, but the task has {episodes.n_agents}: evaluate it as a team"
        )
    found, motion = optima_of(split, optima), MotionLog(episodes)
    rows: dict[int, EpisodeRow] = {}
    for indices, worlds, played in drive(policy, episodes, levels, split, found, motion, watcher):
        for index, world, level in zip(indices, worlds, played, strict=True):
            rows[index] = episode_row(episodes, found, motion, world, level)
        if on_episodes is not None:
            on_episodes(len(worlds))
    return [rows[index] for index in sorted(rows)]


def optima_of(split: str, optima: Optima | None) -> Optima:
    """Return the given optima, or new ones.

    Raises:
        ValueError: If ``optima`` are those of another split.
    """
    if optima is not None and optima.split != split:
        raise ValueError(f"these optima are for split '{optima.split}', but the levels are of '{split}'")
    return Optima(split) if optima is None else optima


def check_levels(scenario: Scenario, split: str, count: int) -> None:
    """Check that a file has at least ``count`` levels, since further ones would repeat them.

    Raises:
        UnknownNameError: If the levels come from a file without this split.
        IrsimGymError: If they come from a file with fewer levels.
    """
    levels = scenario.levels
    if levels is None:
        return
    _, indices = levels.rows(split)
    if count > indices:
        raise IrsimGymError(f"{levels.file} has {indices:,} {split} levels, but {count:,} are asked for: ask for fewer")


def drive(
    policy: Driver, episodes: Episodes, levels: int | Sequence[int], split: str, *watchers: Watcher | None
) -> Iterator[tuple[list[int], list[int], list[int]]]:
    """Drive each level once, and yield worlds as soon as the episodes of all their agents have ended.

    Args:
        policy: A policy, or a function of the observation alone.
        levels: Their number (levels 0, 1, ...) or their indices.
        *watchers: They observe each step, in this order; None is ignored.

    Yields:
        Positions of the ended levels in ``levels``, the worlds that played them, and the levels.
    """
    chosen = np.arange(levels, dtype=np.int64) if isinstance(levels, int) else np.asarray(levels, dtype=np.int64)
    check_levels(episodes.simulation.scenario, split, int(chosen.max(initial=-1)) + 1)
    driver = policy if isinstance(policy, Policy) else ObservationPolicy(policy)
    told = [watcher for watcher in watchers if watcher is not None]
    for indices, worlds in _run(driver, episodes, chosen, split, told):
        yield indices.tolist(), worlds.tolist(), chosen[indices].tolist()


def _run(
    policy: Policy, episodes: Episodes, levels: Ints, split: str, watchers: Sequence[Watcher]
) -> Iterator[tuple[Ints, Ints]]:
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
            for watcher in watchers:
                watcher.began(episodes, begun, episode[begun])
        running = running[~np.isin(running, idle[begun.size :])]
        if not running.size:
            return
        chosen = by_agent(policy.act(episodes, running), episodes, running)
        if actions is None:
            actions = np.zeros((episodes.n_worlds, *chosen.shape[1:]), chosen.dtype)
        actions[running] = chosen
        episodes.step(actions, running)
        for watcher in watchers:
            watcher.stepped(episodes, running)
        idle = running[(episodes.view.infos["outcome"][running] != Outcome.RUNNING).all(axis=1)]
        if idle.size:
            yield episode[idle], idle


def episode_row(
    episodes: Episodes,
    optima: Optima,
    motion: MotionLog,
    world: int,
    level: int,
    agent: int = 0,
    hits: Sequence[str] = HIT_OF_KIND,
) -> EpisodeRow:
    """Return the row of an agent whose episode has ended; ``hits`` are the names of the ``HitKind`` values."""
    infos = {name: values[world, agent] for name, values in episodes.view.infos.items()}
    steps = int(episodes.steps_to_arrival(world)[agent])
    outcome = Outcome(int(infos["outcome"]))
    return EpisodeRow(
        level=level,
        outcome=outcome.name.lower(),
        hit=hits[int(infos["hit_kind"])] if outcome is Outcome.COLLISION else "",
        steps=steps,
        time=steps * float(episodes.simulation.model.step_time[0]),
        path_length=float(infos["path_length"]),
        optimum=optima.of(episodes, world, level, agent),
        min_clearance=float(infos["min_clearance"]),
        least_time=optima.least_time(level, agent),
        acceleration=motion.acceleration(world, agent),
        jerk=motion.jerk(world, agent),
        intrusion_025=motion.people.intrusion(world, agent, 0),
        intrusion_045=motion.people.intrusion(world, agent, 1),
        time_to_collision=motion.people.time_to_collision(world, agent),
        goals_reached=_goals_reached(episodes, world, agent),
        goals_per_minute=_goals_per_minute(episodes, world, agent),
        goal_distance=float(infos["goal_distance"]),
        shield=float(infos["shield"]) / max(int(infos["steps"]), 1) if "shield" in infos else math.nan,
        delivered=delivered(episodes, world),
        effort=motion.pushes.effort(world, agent),
    )


def _goals_reached(episodes: Episodes, world: int, agent: int) -> float:
    """Return the number of goals that an agent has reached; NaN if it has only one, or an endless sequence."""
    model, state = episodes.simulation.model, episodes.simulation.state
    body = int(episodes.simulation.agents[agent])
    if model.waypoint_count[world, body] < 2 or model.goal_renewal[body] != KEEP_GOAL:
        return math.nan
    has_finished = Outcome(int(episodes.view.infos["outcome"][world, agent])) is Outcome.SUCCESS
    return float(min(state.waypoint[world, body] + has_finished, model.waypoint_count[world, body]))


def _goals_per_minute(episodes: Episodes, world: int, agent: int) -> float:
    """Return the number of goals that an agent has reached per minute; NaN as for ``_goals_reached``.

    The time of an agent that has not reached all of its goals is the time limit, even after a collision.
    """
    reached = _goals_reached(episodes, world, agent)
    if math.isnan(reached):
        return math.nan
    steps = int(episodes.steps_to_arrival(world)[agent])
    has_finished = Outcome(int(episodes.view.infos["outcome"][world, agent])) is Outcome.SUCCESS
    counted = steps if has_finished else episodes.task.max_steps
    return 60.0 * reached / (counted * float(episodes.simulation.model.step_time[0]))
