"""Checks whether learners perceive what they may collide with, and whether anybody drives the other robots."""

from collections.abc import Sequence

from irsim_gym.base.families import OBSERVATIONS
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.tasks.definition.task import Task
from irsim_gym.tasks.terms.outcome import Outcome

OF_ITSELF = frozenset({"goal", "goal_heading", "goal_record", "has_arrived", "velocity", "own_body", "trail"})
OF_ITSELF |= {"last_action", "pending", "drive"}
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


def idle_robots(scenario: Scenario, task: Task) -> str:
    """Return which robots could move but neither learn nor have a behaviour, as text.

    It is empty for none, and if the task names its agents.
    """
    robots = [b for b in scenario.robots if b not in task.agents]
    bodies = [scenario.bodies[b] for b in robots]
    idle = [
        body.name
        for body in bodies
        if body.kinematics is not None and not body.static and body.behavior is None and body.group_behavior is None
    ]
    if task.names_agents or not idle:
        return ""
    n_learners, n_robots = len(task.agents), len(scenario.robots)
    learn = f"{n_learners} of {n_robots} robots learn{'s' if n_learners == 1 else ''}"
    who, stand = (
        (idle[0], "has no behavior and stands") if len(idle) == 1 else (_listed(idle), "have no behavior and stand")
    )
    return f"{learn}; {who} {stand} still"


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:3])} and {len(names) - 3} others" if len(names) > 4 else ", ".join(names)


def all_of(scenario: Scenario) -> str:
    """Return what to call all robots of a team."""
    return "both" if len(scenario.robots) == 2 else f"all {len(scenario.robots)}"
