"""The row of ``dwa`` on BARN-2D, from a user's own copy of the worlds: ``python agents/barn_row.py barn_worlds.npz``.

The file holds ``cylinder_xy`` (n, 2) [m], ``world_start`` and ``path_length``. Worlds 0, 6, ..., 294; nothing is random
here, so that each is driven once. The score of a run is success * OT / clip(AT, 2 OT, 8 OT).
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np

import irsim_gym

SETTINGS: dict[str, Any] = {
    "name": "dwa", "path": "seen", "samples": [6, 20], "sim_time": 2.0, "sim_granularity": 0.02, "free_time": 2.0,
    "min_speed": 0.1, "min_turn_rate": 0.314, "obstacle_weight": 0.1, "path_weight": 0.75, "goal_weight": 1.0,
    "forward_point": 0.325, "footprint_padding": 0.1, "obstacle_range": 2.5, "inflation_radius": 0.3,
    "cost_scaling": 10.0, "spacing": 0.05, "path_clearance": 0.1,
}  # fmt: skip
STEP, LIMIT, RADIUS = 0.05, 100.0, 0.075


def scenario(posts: np.ndarray) -> dict[str, Any]:
    """Return the Jackal before a field of posts, shape ``(n, 2)``."""
    robot = {
        "kinematics": {"name": "diff"}, "shape": {"name": "rectangle", "length": 0.42, "width": 0.33},
        "state": [-2.25, 3.0, float(np.pi / 2)], "goal": [-2.25, 13.0, 0], "goal_threshold": 1.0,
        "vel_max": [0.5, 1.57], "vel_min": [-0.5, -1.57], "acce": [10.0, 20.0], "behavior": SETTINGS,
        "sensors": [{"name": "lidar2d", "number": 720, "angle_range": float(1.5 * np.pi), "offset": [-0.065, 0, 0]}],
    }  # fmt: skip
    disc = {"name": "circle", "radius": RADIUS}
    posts_of_all = {"shape": disc, "number": len(posts), "state": [[float(x), float(y), 0.0] for x, y in posts]}
    world = {"name": "barn", "width": 11, "height": 15, "offset": [-7.5, 0], "step_time": STEP}
    return {"world": world, "robot": robot, "obstacle": [{**posts_of_all, "distribution": {"name": "manual"}}]}


def run(posts: np.ndarray, path_length: float) -> dict[str, Any]:
    """Return how a run ends, its time [s] and its score."""
    simulation = irsim_gym.compile(irsim_gym.load_scenario(scenario(posts)))
    simulation.reset(seed=0, split="test")
    outcome, time = "timeout", LIMIT
    for step in range(round(LIMIT / STEP)):
        simulation.step()
        if simulation.state.arrived[0, 0] or simulation.state.collided[0, 0]:
            outcome, time = "arrival" if simulation.state.arrived[0, 0] else "collision", (step + 1) * STEP
            break
    optimum = path_length / 2.0
    score = optimum / np.clip(time, 2.0 * optimum, 8.0 * optimum) if outcome == "arrival" else 0.0
    return {"outcome": outcome, "time": round(time, 2), "score": round(float(score), 4)}


if __name__ == "__main__":
    data = np.load(sys.argv[1])
    starts = data["world_start"]
    rows = {
        i: run(data["cylinder_xy"][starts[i] : starts[i + 1]], float(data["path_length"][i])) for i in range(0, 300, 6)
    }
    print(json.dumps({"settings": SETTINGS, "rows": rows, "score": np.mean([row["score"] for row in rows.values()])}))
