"""A small world that the tests of `live` share."""

from __future__ import annotations

from typing import Any

import irsim_gym

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
WALL: dict[str, Any] = {"shape": {"name": "rectangle", "length": 1, "width": 0.5}, "state": [5, 5, 0]}
SCENARIO: dict[str, Any] = {
    "world": {"height": 10, "width": 10, "step_time": 0.1},
    "robot": [
        {
            **DIFF,
            "state": [1, 1, 0],
            "goal": [9, 9, 0],
            "behavior": {"name": "dash"},
            "sensors": [{"name": "lidar2d", "number": 5, "range_max": 6, "offset": [0.1, 0, 0]}],
        },
        {**DIFF, "state": [1, 5, 0], "goal": [9, 5, 0]},
    ],
    "obstacle": [WALL, {**DIFF, "state": [2, 8, 0]}],
}


def world(*, seed: int = 0, record: bool = False, **sections: Any) -> irsim_gym.live.World:
    """Return the world with some sections replaced; keys of ``world`` are merged."""
    merged = {**SCENARIO, **sections, "world": {**SCENARIO["world"], **sections.get("world", {})}}
    return irsim_gym.load(merged, seed=seed, record=record)
