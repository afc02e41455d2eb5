"""A team whose ends are known whatever its agents do, and what plays it without any library."""

from __future__ import annotations

from typing import Any

import numpy as np

import irsim_gym

LIMIT = 9
ENDS = {"robot_0": 4, "robot_1": 6, "robot_2": LIMIT}
"""The steps in which the robots arrive, collide and run out of time."""
TASK = {
    "name": "blank",
    "observations": [{"name": "goal"}, {"name": "velocity"}],
    "rewards": [{"name": "progress"}, {"name": "arrival"}, {"name": "collision"}],
    "endings": [{"name": "arrived"}, {"name": "collided"}],
    "max_steps": LIMIT,
}


FORMS: dict[str, dict[str, Any]] = {
    "choices": {"action": {"name": "discrete"}},
    "dicts": {"observation_form": "dict"},
    "pictures": {"observations": [{"name": "goal"}, {"name": "occupancy_image", "pixels": 16, "metres": 4}]},
}
"""Other actions and observations than vectors."""


def team(**task: Any) -> dict[str, Any]:
    """Three robots that cannot but drive ahead, 0.095 to 0.1 m in each step.

    ``robot_0`` has 0.45 m to go and arrives within 0.1 m after 4 steps. ``robot_1`` touches a disc that is 0.55 m away
    after 6. ``robot_2`` is on its way to a far goal when the time is up.
    """
    robots = [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "vel_min": [0.95, -0.01],
            "vel_max": [1.0, 0.01],
            "state": [1, y, 0],
            "goal": [x, y, 0],
            "goal_threshold": 0.1,
        }
        for y, x in ((1, 1.45), (3, 8), (5, 8))
    ]
    disc = {"shape": {"name": "circle", "radius": 0.2}, "state": [1.95, 3, 0]}
    size = {"width": 10, "height": 10, "step_time": 0.1}
    return {"world": size, "robot": robots, "obstacle": [disc], "task": {**TASK, **task}}


def paid_alone() -> dict[str, float]:
    """Return what each agent is paid in an episode of zeros as actions, played without any library."""
    env = irsim_gym.parallel_env(team())
    env.reset(seed=0)
    paid = dict.fromkeys(env.possible_agents, 0.0)
    while env.agents:
        for name, reward in env.step({name: np.zeros(2) for name in env.agents})[1].items():
            paid[name] += reward
    return paid
