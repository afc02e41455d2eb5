"""Small worlds with several learners whose ends are known, and what the tests of the parallel environment share."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.specs.library import scenario_names

# Scenarios in which several robots can learn together.
TEAMS = [name for name in scenario_names() if len(load_scenario(name).robots) > 1]

BLANK = {
    "name": "blank",
    "observations": [{"name": "goal"}, {"name": "velocity"}],
    "rewards": [{"name": "progress"}, {"name": "arrival"}, {"name": "collision"}],
    "endings": [{"name": "arrived"}, {"name": "collided"}],
}


def robot(start: list[float], goal: list[float], drive: str = "diff", **more: Any) -> dict[str, Any]:
    """A robot of radius 0.2 m that drives at 1 m/s at most and arrives 0.1 m from its goal."""
    return {
        "kinematics": {"name": drive},
        "shape": {"name": "circle", "radius": 0.2},
        "vel_min": [-1.0] * (3 if drive == "omni_angular" else 2),
        "vel_max": [1.0] * (3 if drive == "omni_angular" else 2),
        "state": start,
        "goal": goal,
        "goal_threshold": 0.1,
        **more,
    }


def world(robots: list[dict[str, Any]], obstacles: list[dict[str, Any]], **task: Any) -> dict[str, Any]:
    """A world of 10 m with steps of 0.1 s."""
    size = {"width": 10, "height": 10, "step_time": 0.1}
    return {"world": size, "robot": robots, "obstacle": obstacles, "task": {**BLANK, **task}}


def four_ends() -> dict[str, Any]:
    """Robots that drive ahead end so, with a limit of 9 steps of 0.1 m.

    ``robot_0`` has 0.45 m to go and arrives within 0.1 m after 4 steps. ``robot_1`` has a gap of 0.55 m to a disc and
    touches it after 6. ``robot_2`` is on its way to a far goal when the time is up. ``robot_3`` has 0.95 m to go and
    arrives in the 9th step, which is the last.
    """
    robots = [
        robot([1, 1, 0], [1.45, 1, 0]),
        robot([1, 3, 0], [8, 3, 0]),
        robot([1, 5, 0], [8, 5, 0]),
        robot([1, 7, 0], [1.95, 7, 0]),
    ]
    disc = {"shape": {"name": "circle", "radius": 0.2}, "state": [1.95, 3, 0]}
    return world(robots, [disc], max_steps=9)


def mixed(**task: Any) -> dict[str, Any]:
    """Four robots with four drives, far from each other."""
    robots = [
        robot([1, 1, 0], [8, 1, 0], "diff"),
        robot([1, 3, 0], [8, 3, 0], "omni"),
        robot([1, 5, 0], [8, 5, 0], "omni_angular"),
        robot(
            [1, 7, 0], [8, 7, 0], "acker", shape={"name": "rectangle", "length": 0.5, "width": 0.3, "wheelbase": 0.3}
        ),
    ]
    return world(robots, [], max_steps=20, **task)


def crossing(n: int = 4, **task: Any) -> dict[str, Any]:
    """Robots at random places with random goals and a few discs: they arrive, collide and run out of time."""
    robots = {
        "number": n,
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.2},
        "vel_min": [-1.0, -2.0],
        "vel_max": [1.5, 2.0],
        "goal_threshold": 0.7,
        "distribution": {"name": "random", "clearance": 0.1, "min_goal_distance": 1.0},
        "sensors": [{"name": "lidar2d", "number": 16, "range_max": 4}],
    }
    discs = {"number": 3, "shape": {"name": "circle", "radius": 0.4}, "distribution": {"name": "random"}}
    made = world([robots], [discs], max_steps=25, **{"name": "navigation", **task})
    made["world"] |= {"width": 6, "height": 6}
    for key in ("observations", "rewards", "endings"):
        if key not in task:
            del made["task"][key]
    return made


def ahead(env: Any) -> dict[str, np.ndarray]:
    """Each live agent drives ahead at full speed."""
    actions = {name: np.zeros(env.action_space(name).shape, np.float32) for name in env.agents}
    for action in actions.values():
        action[0] = 1.0
    return actions


def towards(env: Any, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Random actions that lead the first agents to their goals, and the others anywhere."""
    state, bodies = env.worlds.simulation.state, env.worlds.simulation.agents
    actions = {name: rng.uniform(-1.0, 1.0, env.action_space(name).shape).astype(np.float32) for name in env.agents}
    for name, action in actions.items():
        a = env.possible_agents.index(name)
        x, y, heading = state.pose[0, bodies[a]]
        bearing = np.arctan2(state.goal[0, bodies[a], 1] - y, state.goal[0, bodies[a], 0] - x) - heading
        action[0] = abs(action[0])
        if a < 2:
            action[1] = np.sin(bearing)
    return actions
