"""Random worlds in which bodies push each other, in a scenario language that both packages read."""

from __future__ import annotations

from typing import Any

import numpy as np

Rng = np.random.Generator
DRIVES = ("diff", "diff", "omni", "omni_angular", "acker")
SHAPES = ("circle", "circle", "rectangle", "rectangle", "polygon", "corner", "compound", "line")


def contact_world(seed: int) -> dict[str, Any]:
    """Return a world of 1 to 3 robots that drive to goals, and 1 to 7 obstacles, many of which can be pushed.

    In every tenth world there are up to 24 obstacles.
    """
    rng = np.random.default_rng(seed)
    world: dict[str, Any] = {"width": 12, "height": 8, "step_time": float(rng.choice([0.1, 0.1, 0.1, 0.05]))}
    world["collision_mode"] = "contact"
    for key, share, low, high in (
        ("restitution", 0.3, 0, 1), ("friction", 0.3, 0, 1), ("drive_tau", 0.2, 0, 0.5), ("gravity", 0.1, 1, 12)
    ):  # fmt: skip
        _maybe(rng, world, key, share, low, high)
    if rng.random() < 0.25:
        world["obstacle_map"] = {
            "name": "perlin",
            "resolution": float(rng.choice([0.5, 1.0])),
            "seed": seed,
            "fill": 0.2,
        }
    robots = [_robot(rng) for _ in range(rng.choice([1, 1, 2, 3]))]
    return {
        "world": world,
        "robot": robots,
        "obstacle": [_obstacle(rng) for _ in range(rng.integers(1, 25 if seed % 10 == 0 else 8))],
    }


def _number(rng: Rng, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), 4)


def _maybe(rng: Rng, entry: dict[str, Any], key: str, share: float, low: float, high: float) -> None:
    if rng.random() < share:
        entry[key] = _number(rng, low, high)


def _spot(rng: Rng) -> list[float]:
    return [_number(rng, 1.5, 9), _number(rng, 1.5, 6.5), _number(rng, -3, 3)]


def _robot(rng: Rng) -> dict[str, Any]:
    drive = str(rng.choice(DRIVES))
    most = [_number(rng, 0.5, 1.5), *(_number(rng, 0.3, 1.2) for _ in range(2 if drive == "omni_angular" else 1))]
    robot: dict[str, Any] = {"kinematics": {"name": drive}, "state": _spot(rng), "behavior": {"name": "dash"}}
    robot |= {"vel_max": most, "vel_min": [-one for one in most]}
    robot["goal"] = [_number(rng, 0.5, 11.5), _number(rng, 0.5, 7.5), 0]
    if drive == "omni":
        robot["kinematics"]["frame"] = "body"
    if drive == "acker":
        robot["shape"] = {"name": "rectangle", "length": 0.9, "width": 0.4, "wheelbase": 0.5}
        robot["state"].append(0)
    elif rng.random() < 0.6:
        robot["shape"] = {"name": "circle", "radius": _number(rng, 0.2, 0.4)}
    else:
        robot["shape"] = {"name": "rectangle", "length": _number(rng, 0.5, 0.9), "width": _number(rng, 0.3, 0.6)}
    _maybe(rng, robot, "mass", 0.4, 0.5, 4)
    _maybe(rng, robot, "friction", 0.2, 0.2, 1)
    _maybe(rng, robot["kinematics"], "tau", 0.2, 0, 0.4)
    return robot


def _obstacle(rng: Rng) -> dict[str, Any]:
    obstacle: dict[str, Any] = {"shape": _shape(rng), "state": _spot(rng)}
    _maybe(rng, obstacle, "mass", 0.75, 0.1, 2)
    if rng.random() < 0.1:
        obstacle["mass"] = [float("inf"), 20.0][rng.integers(2)]
    _maybe(rng, obstacle, "friction", 0.3, 0, 0.8)
    _maybe(rng, obstacle, "restitution", 0.2, 0, 1)
    if rng.random() < 0.3:
        obstacle["velocity"] = [_number(rng, -2, 2) for _ in range(3)]
    if np.isfinite(obstacle.get("mass", np.inf)):
        _maybe(rng, obstacle, "inertia", 0.1, 0.01, 0.5)
    return obstacle


def _shape(rng: Rng) -> dict[str, Any]:
    kind = str(rng.choice(SHAPES))
    if kind == "circle":
        return {"name": "circle", "radius": _number(rng, 0.15, 0.45)}
    if kind == "rectangle":
        return {"name": "rectangle", "length": _number(rng, 0.3, 1.2), "width": _number(rng, 0.3, 0.9)}
    if kind == "polygon":
        n = int(rng.integers(3, 7))
        angles, radius = 2 * np.pi * (np.arange(n) + rng.uniform(0, 0.5, n)) / n, _number(rng, 0.3, 0.6)
        return {
            "name": "polygon",
            "vertices": np.round(radius * np.array([np.cos(angles), np.sin(angles)]).T, 4).tolist(),
        }
    if kind == "corner":
        a, b, c, d = (_number(rng, *span) for span in ((0.7, 1.1), (0.7, 1.2), (0.2, 0.4), (0.2, 0.4)))
        return {"name": "polygon", "vertices": [[0, 0], [a, 0], [a, c], [d, c], [d, b], [0, b]]}
    if kind == "compound":
        disc = {"name": "circle", "radius": _number(rng, 0.15, 0.3)}
        disc["pose"] = [_number(rng, -0.4, 0.4), _number(rng, -0.3, 0.3), 0]
        bar = {"name": "rectangle", "length": _number(rng, 0.5, 0.9), "width": _number(rng, 0.2, 0.4)}
        return {"name": "compound", "parts": [bar, disc]}
    spans = ((-1.0, 0.0), (0.1, 1.0), (1.1, 2.0))
    return {"name": "linestring", "vertices": [[_number(rng, *span), _number(rng, -0.5, 0.5)] for span in spans]}
