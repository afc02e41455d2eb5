"""Distributions with several goals for each body, which are to be reached one after another."""

from typing import Any

from irsim_gym.simulator.world.model import WANDER
from irsim_gym.simulator.world.names import Group, Model, option

MOST_GOALS = 1000
"""Maximum number of goals of a body."""


def goals_option() -> Any:
    """Declare the option ``goals``."""
    return option(
        1,
        ge=1,
        le=MOST_GOALS,
        meaning="Number of goals, reached one after another. What is asked of the way to the goal holds for the way "
        "from each goal to the next; goals of different bodies keep apart.",
        consequence="More than there is room for: an error that names the body.",
    )


def misfit_of_goals(group: Group, model: Model) -> str | None:
    """Return why members cannot have several goals; None if they can, or if they have only one."""
    goals = group.options[0].goals
    if goals == 1:
        return None
    if not model.has_goal[group.members].all():
        return f"goals: {goals} needs bodies that move: these stand still and have no goals"
    if (model.goal_renewal[group.members] == WANDER).any():
        return f"goals: {goals} needs bodies that keep their goals, but the behavior of these has wander: true"
    return None
