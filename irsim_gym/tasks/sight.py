"""Whether learners perceive anything of what they may run into."""

from __future__ import annotations

from irsim_gym.families import OBSERVATIONS
from irsim_gym.scenario.spec import Scenario
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.task import Task

OF_ITSELF = frozenset({"goal", "goal_heading", "velocity", "last_action", "drive", "goal_record", "trail"})
"""Observations that tell an agent of itself and its goal alone."""
OF_ROBOTS = frozenset({"neighbors"})
"""Observations that tell of robots alone."""


def unseen(scenario: Scenario, task: Task) -> str:
    """Return what the learners may run into although no observation shows it, in words; "" where there is nothing.

    A map counts as an obstacle; an observation that is not of this package is taken to show everything.
    """
    if not any(ending.outcome == Outcome.COLLISION for ending in task.endings):
        return ""
    shown = {OBSERVATIONS.name_of(type(item)) for item in task.observations} - OF_ITSELF
    if shown - OF_ROBOTS:
        return ""
    robots = set(scenario.robots)
    others = [b for b, body in enumerate(scenario.bodies) if b not in task.agents and not body.unobstructed]
    obstacles = [b for b in others if b not in robots]
    parts = []
    if not shown and len(task.agents) > 1:
        parts.append("each other")
    if not shown and any(b in robots for b in others):
        parts.append("other robots")
    if obstacles:
        parts.append("the obstacles")
    return " and ".join(parts)
