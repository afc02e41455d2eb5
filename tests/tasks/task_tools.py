"""Small scenarios, and the episodes played in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, load_task

ROBOT: dict[str, Any] = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.2},
    "vel_min": [0, -1.5],
    "vel_max": [1, 1.5],
    "goal_threshold": 0.3,
    "state": [2, 5, 0],
    "goal": [8, 5, 0],
    "sensors": [{"name": "lidar2d", "number": 180, "angle_range": 2 * np.pi, "range_max": 6}],
}
BALL: dict[str, Any] = {"shape": {"name": "circle", "radius": 0.5}, "state": [5, 5, 0]}


def scenario(robot: Any = None, obstacle: Any = None, task: Any = None, **world: Any) -> Any:
    """Return a scenario of 10 x 10 m with steps of 0.1 s; the robot is ROBOT with other keys, or a list."""
    robots = robot if isinstance(robot, list) else {**ROBOT, **(robot or {})}
    data: dict[str, Any] = {"world": {"name": "yard", **world}, "robot": robots}
    if obstacle is not None:
        data["obstacle"] = obstacle
    if task is not None:
        data["task"] = task
    return load_scenario(data)


def play(
    robot: Any = None,
    obstacle: Any = None,
    task: Mapping[str, Any] | None = None,
    n_worlds: int = 1,
    num_threads: int = 1,
    team: bool = False,
    **world: Any,
) -> Episodes:
    """Return episodes whose worlds have begun levels 0, 1, ..."""
    spec = scenario(robot, obstacle, **world)
    loaded = load_task(spec, task, team=team)
    episodes = Episodes(compile(spec, n_worlds, agents=loaded.agents, num_threads=num_threads), loaded)
    episodes.begin(np.arange(n_worlds), np.arange(n_worlds))
    return episodes


def drive(episodes: Episodes, *action: float) -> None:
    """Take a step with the same action everywhere."""
    episodes.step(np.broadcast_to(np.array(action), (episodes.n_worlds, episodes.n_agents, len(action))))
