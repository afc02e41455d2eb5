"""A world in which bodies push each other, with all that levels draw (maps, outlines, places), fog and noise."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

ANYWHERE: dict[str, Any] = {"name": "random", "range_low": [1, 1, -3.1], "range_high": [9, 7, 3.1], "min_distance": 0}
YARD: dict[str, Any] = {
    "world": {
        "name": "yard", "width": 10, "height": 8, "step_time": 0.1, "collision_mode": "contact", "restitution": 0.3,
        "fog_map": True, "obstacle_map": {"name": "cells", "fill": [0.01, 0.04]},
    },
    "robot": {
        "kinematics": {"name": "diff", "noise": True}, "shape": {"name": "circle", "radius": 0.2},
        "vel_min": [-1, -1], "vel_max": [1, 1], "mass": 2, "distribution": {**ANYWHERE, "min_goal_distance": 2},
        "sensors": [{"name": "lidar2d", "number": 24, "noise": True}, {"name": "contact2d"}],
    },
    "obstacle": [
        {"number": 3, "shape": {"name": "rectangle", "random_shape": True}, "mass": [0.5, 1.0, 8.0],
         "distribution": {**ANYWHERE, "min_goal_distance": 1}},
        {"number": 3, "shape": {"name": "polygon", "random_shape": True, "is_convex": True}, "mass": 0.4,
         "friction": 0.01, "velocity": [0.8, -0.5, 1.0], "distribution": ANYWHERE},
        {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.3}, "distribution": ANYWHERE,
         "behavior": {"name": "dash", "wander": True, "range_low": [0, 0, -3], "range_high": [10, 8, 3]}},
    ],
    "task": {
        "name": "pushing", "max_steps": 40,
        "observations": [{"name": "scan", "sectors": 12}, {"name": "goal"}, {"name": "movable_bodies", "count": 2},
                         {"name": "contact"}, {"name": "velocity"}],
    },
}  # fmt: skip


def team_yard() -> dict[str, Any]:
    """Return the world with two learners."""
    scene = deepcopy(YARD)
    scene["robot"]["number"], scene["task"]["max_steps"] = 2, 25
    return scene
