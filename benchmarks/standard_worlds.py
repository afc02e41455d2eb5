"""The standard worlds S1 to S5 as plain data that IR-SIM reads too; the standard library is enough to load this file.

S1: one robot, 10 circles and rectangles that never move, 180 beams. S2: 10 robots that change sides. S3: one robot in a
map of IR-SIM's. S4: 10 robots with 100 beams each and 10 bodies that wander. S5: one robot that pushes 10 bodies.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

Data = dict[str, Any]
Pair = tuple[float, float]

SQUARE = 2.5
"""Side of the square that an obstacle of S1 has for itself, where there is one [m]."""

HEAP_SQUARE = 1.2
"""Side of the square that a body of S5 has for itself [m]."""

SPACING = 3.0
"""Side of the square that an agent of a crowd has for itself [m]."""

RUN_STEPS = 60
"""Steps of a crowd from its start: until then hardly anybody has arrived, and nobody has nothing to do."""

TEAM_STEPS = 16
"""Steps of a team from its start."""

PUSH_STEPS = 60
"""Steps from the start of a world whose bodies are pushed: some are at the walls by then."""

DIFF: Data = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.2},
    "vel_min": [0.0, -1.5],
    "vel_max": [1.0, 1.5],
    "goal_threshold": 0.3,
}
"""The robot of all worlds: it drives forward only."""

TASK: Data = {
    "name": "blank",
    "max_steps": 200,
    "observations": [{"name": "scan", "sectors": 1080, "code": "linear"}, "goal", "velocity"],
    "rewards": [
        {"name": "progress", "weight": 4.0},
        {"name": "arrival", "weight": 5.0},
        {"name": "collision", "weight": 4.0},
        {"name": "time", "weight": 2.0},
    ],
    "endings": ["arrived", "collided"],
}
"""Every beam, goal and velocity; the reward of the peers' wrappers and of the C twin."""

TEAM_TASK: Data = {**TASK, "max_steps": 100, "endings": ["arrived"], "rewards": TASK["rewards"][:2]}
"""For robots that go on wherever they bump into something, but not for ever: no walls hold them."""


def lidar(beams: int, far: float) -> list[Data]:
    """Return the sensors of a robot: one scanner of a full turn."""
    return [{"name": "lidar2d", "number": beams, "angle_range": 2.0 * math.pi, "range_max": far}]


def anywhere(clearance: float, way: float) -> Data:
    """Return a distribution with room around start and goal and a least distance between them [m]."""
    return {"name": "random", "clearance": clearance, "min_goal_distance": way}


def walls(side: float) -> Data:
    """Return the boundary of a square world."""
    corners = [[0, 0], [side, 0], [side, side], [0, side], [0, 0]]
    return {"shape": {"name": "linestring", "vertices": corners}, "state": [0.0, 0.0, 0.0]}


def scattered(
    numbers: random.Random, count: int, square: float, away: float, radii: Pair, sides: Pair
) -> Iterator[Data]:
    """Yield circles and rectangles in turns, each somewhere in a square of its own.

    Args:
        numbers: Draws places and sizes.
        count: Number of bodies.
        square: Side of a square [m].
        away: Least distance of a body's origin from the edge of its square, as a share of the side.
        radii: Bounds of the radius of a circle [m].
        sides: Bounds of the sides of a rectangle [m].
    """
    columns = columns_of(count)
    for k, place in enumerate(numbers.sample(range(columns * columns), count)):
        x = square * (place % columns + numbers.uniform(away, 1.0 - away))
        y = square * (place // columns + numbers.uniform(away, 1.0 - away))
        if k % 2 == 0:
            shape = {"name": "circle", "radius": numbers.uniform(*radii)}
        else:
            shape = {"name": "rectangle", "length": numbers.uniform(*sides), "width": numbers.uniform(*sides)}
        yield {"shape": shape, "state": [x, y, numbers.uniform(-math.pi, math.pi)]}


def columns_of(count: int) -> int:
    """Return how many squares a room is wide and high, of which some stay empty."""
    return math.ceil(math.sqrt(1.6 * count))


def s1(n_obstacles: int = 10, beams: int = 180) -> Data:
    """Return S1; more obstacles stand in a larger room, so that their density stays the same."""
    side = SQUARE * columns_of(n_obstacles)
    obstacles = scattered(random.Random(n_obstacles), n_obstacles, SQUARE, 0.35, (0.3, 0.6), (0.5, 1.1))
    return {
        "world": {"width": side, "height": side, "step_time": 0.1},
        "robot": [{**DIFF, "distribution": anywhere(0.1, 4.0), "sensors": lidar(beams, 6.0)}],
        "obstacle": [walls(side), *obstacles],
        "task": TASK,
    }


def s2(behavior: str) -> Data:
    """Return S2: 10 robots that change sides on a circle, by ``rvo`` or ``orca``."""
    starts, goals = [], []
    for k in range(10):
        angle = 2.0 * math.pi * k / 10.0
        x, y = 4.0 * math.cos(angle), 4.0 * math.sin(angle)
        starts.append([5.0 + x, 5.0 + y, angle - math.pi if angle > 0.0 else math.pi])
        goals.append([5.0 - x, 5.0 - y, 0.0])
    decides = {"behavior": {"name": "rvo"}} if behavior == "rvo" else {"group_behavior": {"name": "orca"}}
    robots = {**DIFF, "number": 10, "distribution": {"name": "manual"}, "state": starts, "goal": goals, **decides}
    world = {"width": 10.0, "height": 10.0, "step_time": 0.1, "collision_mode": "unobstructed"}
    return {"world": world, "robot": [robots]}


def s3(picture: str) -> Data:
    """Return S3 in one of IR-SIM's maps: ``cave`` (50 x 50 m) or ``floor_plan`` (80 x 80 m)."""
    name, side = {"cave": ("cave.png", 50.0), "floor_plan": ("hm3d_2.png", 80.0)}[picture]
    robot = {**DIFF, "distribution": anywhere(1.0, 4.0), "sensors": lidar(180, 10.0)}
    world = {"width": side, "height": side, "step_time": 0.1, "obstacle_map": name}
    return {"world": world, "robot": [robot], "task": TASK}


def s4(n_robots: int = 10, n_wanderers: int = 10) -> Data:
    """Return S4: robots that all learn, among discs that go from one random place to the next."""
    side = 12.0
    area = {"range_low": [0.5, 0.5, -math.pi], "range_high": [side - 0.5, side - 0.5, math.pi]}
    wanderers = {
        "number": n_wanderers,
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.3},
        "distribution": {"name": "random", **area},
        "behavior": {"name": "dash", "wander": True, **area},
        "vel_min": [-0.5, -0.5],
        "vel_max": [0.5, 0.5],
    }
    robots = {**DIFF, "number": n_robots, "distribution": {"name": "random", **area}, "sensors": lidar(100, 6.0)}
    world = {"width": side, "height": side, "step_time": 0.1, "collision_mode": "unobstructed"}
    return {"world": world, "robot": [robots], "obstacle": [wanderers], "task": TEAM_TASK}


def s5(n_bodies: int = 10) -> Data:
    """Return S5: a robot that pushes circles and rectangles of 1 to 5 kg; more of them lie in a larger room."""
    side, numbers = HEAP_SQUARE * columns_of(n_bodies), random.Random(n_bodies)
    bodies = scattered(numbers, n_bodies, HEAP_SQUARE, 0.4, (0.15, 0.3), (0.3, 0.5))
    robot = {**DIFF, "mass": 10.0, "distribution": anywhere(0.05, 2.0), "sensors": lidar(180, 6.0)}
    return {
        "world": {"width": side, "height": side, "step_time": 0.1, "collision_mode": "contact"},
        "robot": [robot],
        "obstacle": [walls(side), *({**body, "mass": numbers.uniform(1.0, 5.0)} for body in bodies)],
        "task": {**TASK, "endings": ["arrived"]},
    }


def crowd(behavior: Data, n_agents: int) -> Data:
    """Return omnidirectional discs, one in each square of a board, with goals anywhere on it."""
    numbers = random.Random(0)
    columns = math.ceil(math.sqrt(n_agents))
    side = SPACING * columns
    starts = []
    for square in numbers.sample(range(columns * columns), n_agents):
        x, y = square % columns + numbers.uniform(0.3, 0.7), square // columns + numbers.uniform(0.3, 0.7)
        starts.append([SPACING * x, SPACING * y, 0.0])
    robots = {
        "number": n_agents,
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "distribution": {"name": "manual"},
        "state": starts,
        "goal": [[numbers.uniform(0.0, side), numbers.uniform(0.0, side), 0.0] for _ in range(n_agents)],
        "vel_max": [1.0, 1.0],
        "vel_min": [-1.0, -1.0],
        **behavior,
    }
    return {"world": {"width": side, "height": side, "collision_mode": "unobstructed"}, "robot": [robots]}


ORCA: Data = {
    "group_behavior": {"name": "orca", "neighborDist": 5.0, "maxNeighbors": 10, "timeHorizon": 5.0, "safe_radius": 0.0}
}
"""What navground is asked for too: 10 neighbours within 5 m, collisions within 5 s."""
