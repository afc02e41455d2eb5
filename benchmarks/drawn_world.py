"""A world with 20 bodies and 100 beams in which everything is drawn that can be, as data that IR-SIM reads too."""

from __future__ import annotations

import math
from typing import Any

SIDE = 12.0
STEPS_BEFORE, STEPS_DRAWN = 60, 60
"""Steps before the first frame, so that there are paths and outlines behind the bodies, and frames of a run."""

SHOWN = {
    "show_goal": True,
    "show_text": True,
    "show_goal_text": True,
    "show_arrow": True,
    "show_trajectory": True,
    "keep_traj_length": 100,
    "show_trail": True,
    "trail_freq": 5,
    "keep_trail_length": 6,
    "show_sensor": True,
    "show_fov": True,
}


def drawn_world() -> dict[str, Any]:
    """Return 10 robots with 10 beams each, 5 obstacles that move and 5 that stand."""
    world = {"width": SIDE, "height": SIDE, "step_time": 0.1, "collision_mode": "unobstructed"}
    return {"world": world, "robot": [robot(k) for k in range(10)], "obstacle": [*map(mover, range(5)), *standing()]}


def robot(k: int) -> dict[str, Any]:
    """Return a robot that drives to the other side, every second one in each direction."""
    y, left = 1.5 + k, k % 2 == 0
    start, goal = (1.3, 10.7) if left else (10.7, 1.3)
    shapes = ({"name": "circle", "radius": 0.25}, {"name": "rectangle", "length": 0.6, "width": 0.4})
    return {
        "kinematics": {"name": "diff"},
        "shape": shapes[k % 4 // 2],
        "state": [start, y, 0.0 if left else math.pi],
        "goal": [goal, y, 0.0],
        "vel_min": [-0.6, -1.5],
        "vel_max": [0.6, 1.5],
        "behavior": {"name": "dash"},
        "fov": 1.57,
        "fov_radius": 1.2,
        "sensors": [{"name": "lidar2d", "number": 10, "angle_range": 2.0 * math.pi, "range_max": 2.0}],
        "plot": SHOWN,
    }


def mover(k: int) -> dict[str, Any]:
    """Return a disc that crosses the robots' ways."""
    x, y, up = 2.4 + 1.9 * k, 1.0 + 0.4 * k, k % 2 == 0
    return {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [x, y if up else SIDE - y, 0.0],
        "goal": [x, SIDE - y if up else y, 0.0],
        "vel_min": [-0.5, -0.5],
        "vel_max": [0.5, 0.5],
        "behavior": {"name": "dash"},
        "color": "#64748B",
        "plot": {key: value for key, value in SHOWN.items() if key not in ("show_sensor", "show_fov")},
    }


def standing() -> list[dict[str, Any]]:
    """Return obstacles of every shape that never move."""
    shapes: list[tuple[dict[str, Any], list[float]]] = [
        ({"name": "circle", "radius": 0.35}, [0.7, 6.0, 0.0]),
        ({"name": "rectangle", "length": 0.8, "width": 0.3}, [6.0, 6.0, 0.4]),
        ({"name": "polygon", "vertices": [[-0.4, -0.4], [0.4, -0.3], [0.0, 0.5]]}, [11.4, 3.0, 0.0]),
        ({"name": "linestring", "vertices": [[0.0, 0.0], [1.0, 0.3], [2.0, 0.0]]}, [4.0, 0.5, 0.0]),
        ({"name": "rectangle", "length": 0.4, "width": 0.4}, [3.3, 11.4, 0.8]),
    ]
    return [{"shape": shape, "state": state, "plot": {"show_text": True}} for shape, state in shapes]
