"""Observations in goal form: the achieved and the desired goal are separate from the rest.

Hindsight experience replay (HER) recomputes the reward of a stored step for another goal. For this, no other part of
the observation depends on the goal, and the reward follows from the two positions and the step's info.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from irsim_gym.errors import Problem
from irsim_gym.families import REWARDS
from irsim_gym.scenario.level_checks import n_goals_drawn
from irsim_gym.scenario.spec import Scenario
from irsim_gym.tasks.audit import Terms
from irsim_gym.tasks.layers import Merged
from irsim_gym.tasks.observations.goal_position import GoalPosition
from irsim_gym.tasks.observations.heading import Heading
from irsim_gym.tasks.observations.position import Position
from irsim_gym.tasks.rewards.arrival import Arrival
from irsim_gym.tasks.term import IsImage

ACHIEVED, DESIRED, REST = "achieved_goal", "desired_goal", "observation"
PARTS = {"position": ACHIEVED, "goal_position": DESIRED}
"""Observations with their own part; all others together form ``observation``."""


def goal_terms(scenario: Scenario, agents: Sequence[int], terms: Terms, merged: Merged) -> list[tuple[Any, Any]]:
    """Return the observations of the goal form, and report what does not fit it.

    Observations that depend on the goal are removed. ``heading``, ``position`` and ``goal_position`` are added if they
    are missing: both positions are in the world frame, so an agent needs its heading to use them.
    """
    report = merged.report
    if len(agents) > 1:
        report.add(("observation_form",), f"'goal' is for one learner, and there are {len(agents)}")
    if terms["critic_observations"]:
        report.add(("critic_observations",), "observation_form 'goal' has no observations of the critic alone")
    for b in agents:
        body = scenario.bodies[b]
        if body.arrive_mode == "state":
            message = (
                "arrives by place and heading (arrive_mode: state); observation_form 'goal' supports positions only"
            )
            merged.outside.append((scenario.source.title, Problem(body.line, body.name, message)))
        if max(len(body.goal), n_goals_drawn(scenario.placements[body.entry])) > 1 or body.wanders:
            message = "has several goals; observation_form 'goal' supports one"
            merged.outside.append((scenario.source.title, Problem(body.line, body.name, message)))
    for place, reward in terms["rewards"]:
        if reward.needs_goal and not isinstance(reward, Arrival):
            name = REWARDS.name_of(type(reward))
            message = f"'{name}' cannot be computed for another goal, as observation_form 'goal' requires"
            report.add(place, f"{message}; leave it out ({{name: {name}, use: false}}), use 'arrival' instead")
    seen = terms["observations"]
    kept = [(place, item) for place, item in seen if isinstance(item, GoalPosition) or not item.needs_goal]
    for place, item in kept:
        if isinstance(item, IsImage):
            report.add(place, "observation_form 'goal' does not support pictures")
    given = {type(item) for _, item in kept}
    return [*kept, *((("observations",), kind()) for kind in (Heading, Position, GoalPosition) if kind not in given)]
