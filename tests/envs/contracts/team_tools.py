"""Scenarios with teams, and a record of what Stable-Baselines3 saw."""

from __future__ import annotations

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

SENSOR = {"name": "lidar2d", "number": 12, "range_max": 3}
DISC = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
ANYWHERE = {"name": "random", "range_low": [0.5, 0.5, -3.14], "range_high": [5.5, 5.5, 3.14]}
MEET = {
    "world": {"width": 6, "height": 6, "step_time": 0.1},
    "robot": [
        {
            **DISC,
            "number": 3,
            "distribution": ANYWHERE,
            "vel_min": [0, -2],
            "vel_max": [2, 2],
            "goal_threshold": 0.4,
            "sensors": [SENSOR],
        }
    ],
    "obstacle": [{"shape": {"name": "circle", "radius": 0.4}, "distribution": {**ANYWHERE}, "number": 2}],
    "task": {"observations": [{"name": "scan", "sectors": 6}, "goal", "last_action"]},
}
"""Three robots that often arrive, collide and run out of time, at different moments."""

# Commands have no influence: everybody drives ahead at 1 m/s, 0.1 m a step.
ARRIVES, COLLIDES, LIMIT = 8, 9, 12
AHEAD = {**DISC, "vel_min": [1, 0], "vel_max": [1, 0], "goal_threshold": 0.25, "sensors": [SENSOR]}
KNOWN = {
    "world": {"width": 10, "height": 10, "step_time": 0.1, "collision_mode": "unobstructed"},
    "robot": [
        {**AHEAD, "state": [1, 2, 0], "goal": [2, 2, 0]},  # 0.2 m left after 8 steps
        {**AHEAD, "state": [1, 5, 0], "goal": [9, 5, 0]},  # its front reaches 2.1 m with the 9th step
        {**AHEAD, "state": [1, 8, 0], "goal": [9, 8, 0]},  # underway after 12 steps
    ],
    "obstacle": [{"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [2.55, 5, 0]}],
    "task": {
        "name": "blank",
        "max_steps": LIMIT,
        "observations": ["goal"],
        "rewards": [{"name": "time", "weight": float(LIMIT)}],  # -1 at each step
        "endings": ["arrived", "collided"],
        "audit": False,
    },
}
"""Robot 0 arrives after 8 steps, robot 1 collides after 9, robot 2 meets the time limit of 12; each step costs 1."""


class Recorder(BaseCallback):
    """Keeps what was seen in the latest rollout, step by step, ``(n_steps, n_slots)``."""

    def _on_rollout_start(self):
        self.rows = {name: [] for name in ("rewards", "dones", "values", "log_probs", "acted")}
        self.infos = []

    def _on_step(self):
        seen = self.locals
        for name in ("rewards", "dones"):
            self.rows[name].append(np.array(seen[name]))
        for name in ("values", "log_probs"):
            self.rows[name].append(seen[name].detach().numpy().reshape(-1).copy())
        self.rows["acted"].append(self.training_env.unwrapped.acted.copy())
        self.infos.append(seen["infos"])
        return True

    def _on_rollout_end(self):
        self.last_values = self.locals["values"].detach().numpy().reshape(-1).copy()
        buffer = self.model.rollout_buffer
        self.advantages, self.returns = buffer.advantages.copy(), buffer.returns.copy()

    def table(self, name):
        """One of the columns, ``(n_steps, n_slots)``."""
        return np.array(self.rows[name])


def episodes_of(dones, acted):
    """Yield the slot, the steps and whether it has ended of each (piece of an) episode that an agent lived."""
    for slot in range(dones.shape[1]):
        steps = []
        for step in range(dones.shape[0]):
            if not acted[step, slot]:
                continue
            steps.append(step)
            if dones[step, slot]:
                yield slot, steps, True
                steps = []
        if steps:
            yield slot, steps, False
