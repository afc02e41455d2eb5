"""Checks whether learners perceive what they may collide with."""

from __future__ import annotations

from irsim_gym.families import OBSERVATIONS
from irsim_gym.scenario.spec import Scenario
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.task import Task

OF_ITSELF = frozenset(
    {"goal", "goal_heading", "velocity", "last_action", "drive", "own_body", "goal_record", "has_arrived", "trail"}
)
"""Observations that contain only the agent itself and its goal."""
OF_ROBOTS = frozenset({"neighbors"})
"""Observations that contain only robots."""


def unseen(scenario: Scenario, task: Task) -> str:
    """Return what the learners may collide with although no observation shows it, as text; empty for nothing.

    A map counts as an obstacle. Observations of plugins are assumed to show everything.
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
