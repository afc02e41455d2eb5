"""The evaluation of teams: all agents of a world are driven until the last one's episode has ended."""

from collections.abc import Callable, Sequence

import numpy as np

from irsim_gym.evaluation.measures.motion import MotionLog
from irsim_gym.evaluation.measures.optimum import Optima, straight_distance
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.measures.watcher import Watcher
from irsim_gym.evaluation.protocol.protocol import Driver, drive, episode_row, optima_of
from irsim_gym.simulator.world.model import OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD
from irsim_gym.tasks import Episodes

HIT_NAMES = ("", "obstacle", "moving obstacle", "robot", "map")
"""Names of the ``HitKind`` values in rows."""
STANDSTILLS = ("timeout", "deadlock")
"""Outcomes that can result from standing still."""


def evaluate_team(
    policy: Driver,
    episodes: Episodes,
    levels: int | Sequence[int],
    split: str = "test",
    *,
    optima: Optima | None = None,
    on_episodes: Callable[[int], None] | None = None,
    watcher: Watcher | None = None,
) -> list[TeamRow]:
    """Drive all agents through each level of a split once, and return one row per level, in the order of the levels.

    Agents whose episode has ended wait for the others, see the task's option ``ended``. A level's result depends
    neither on the number of worlds nor on other levels.

    Args:
        policy: A policy, or a function that maps the agents' observations to their actions.
        episodes: Worlds with any number of agents, see ``irsim_gym.tasks.Episodes``.
        levels: Their number (levels 0, 1, ...) or their indices.
        optima: Geodesic optima of earlier evaluations of the same split; new ones are added.
        on_episodes: Called with the number of levels that have just ended.
        watcher: Observes each step.
    """
    best, motion = optima_of(split, optima), MotionLog(episodes)
    limit = episodes.task.max_steps * float(episodes.simulation.model.step_time[0])
    rows: dict[int, TeamRow] = {}
    for indices, worlds, played in drive(policy, episodes, levels, split, best, motion, watcher):
        for index, world, level in zip(indices, worlds, played, strict=True):
            agents = [_agent_row(episodes, best, motion, world, level, a) for a in range(episodes.n_agents)]
            rows[index] = TeamRow(level, limit, tuple(agents))
        if on_episodes is not None:
            on_episodes(len(worlds))
    return [rows[index] for index in sorted(rows)]


def _agent_row(episodes: Episodes, optima: Optima, motion: MotionLog, world: int, level: int, agent: int) -> AgentRow:
    row = episode_row(episodes, optima, motion, world, level, agent, HIT_NAMES)
    stood = bool(episodes.view.infos["deadlocked"][world, agent])
    name, deadlocked = episodes.agent_names[agent], stood and row.outcome in STANDSTILLS
    way, fastest = straight_distance(episodes, world, agent), top_speed(episodes, world, agent)
    return AgentRow(agent=name, episode=row, straight_distance=way, top_speed=fastest, deadlocked=deadlocked)


def top_speed(episodes: Episodes, world: int, agent: int) -> float:
    """Return an agent's maximum linear speed [m/s] in any direction.

    An omnidirectional drive has a limit for each axis and is fastest along the diagonal.
    """
    model, body = episodes.simulation.model, int(episodes.simulation.agents[agent])
    low, high = (limit[world % len(limit), body] for limit in (model.velocity_min, model.velocity_max))
    fastest = np.maximum(np.abs(low), np.abs(high))
    axes = 2 if model.drive[body] in (OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR) else 1
    return float(np.sqrt(np.sum(np.square(fastest[:axes]))))
