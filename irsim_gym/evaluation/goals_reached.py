"""Counts the goals that an agent with several successive goals has reached."""

from __future__ import annotations

import math

from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.world.model import KEEP_GOAL


def goals_reached(episodes: Episodes, world: int, agent: int) -> float:
    """Return the number of goals that an agent has reached; NaN if it has only one, or an endless sequence."""
    model, state = episodes.simulation.model, episodes.simulation.state
    body = int(episodes.simulation.agents[agent])
    if model.waypoint_count[world, body] < 2 or model.goal_renewal[body] != KEEP_GOAL:
        return math.nan
    has_finished = Outcome(int(episodes.view.infos["outcome"][world, agent])) is Outcome.SUCCESS
    return float(min(state.waypoint[world, body] + has_finished, model.waypoint_count[world, body]))


def goals_per_minute(episodes: Episodes, world: int, agent: int) -> float:
    """Return the number of goals that an agent has reached per minute; NaN as for ``goals_reached``.

    The time of an agent that has not reached all of its goals is the time limit, even after a collision.
    """
    reached = goals_reached(episodes, world, agent)
    if math.isnan(reached):
        return math.nan
    steps = int(episodes.view.infos["steps"][world, agent])
    has_finished = Outcome(int(episodes.view.infos["outcome"][world, agent])) is Outcome.SUCCESS
    counted = steps if has_finished else episodes.task.max_steps
    return 60.0 * reached / (counted * float(episodes.simulation.model.step_time[0]))
