"""The same scene for our ORCA and for pyrvo, van den Berg's own library."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyrvo
import shapely

import irsim_gym as ig

RADIUS, SAFE = 0.2, 0.1
Corners = list[tuple[float, float]]


@dataclass
class Scene:
    """Discs with velocities and goals, and walls: convex polygons (counter-clockwise) or lines."""

    position: np.ndarray
    velocity: np.ndarray
    goal: np.ndarray
    polygons: list[Corners] = field(default_factory=list)
    lines: list[Corners] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)
    speed: float = 1.0
    step_time: float = 0.1


def draw_scene(rng: np.random.Generator, count: int, spacing: float, **given: Any) -> Scene:
    """Draw discs, so far apart and clear of the walls."""
    scene = Scene(np.zeros((count, 2)), rng.uniform(-0.7, 0.7, (count, 2)), rng.uniform(0, 10, (count, 2)), **given)
    walls = shapely.union_all([*map(shapely.Polygon, scene.polygons), *map(shapely.LineString, scene.lines)])
    placed: list[np.ndarray] = []
    while len(placed) < count:
        here = rng.uniform(0, 10, 2)
        free = all(np.hypot(*(here - other)) > spacing for other in placed)
        if free and (walls.is_empty or walls.distance(shapely.Point(here)) > RADIUS):
            placed.append(here)
    scene.position[:] = placed
    return scene


def peer_velocities(scene: Scene) -> np.ndarray:
    """Return what pyrvo chooses."""
    given = {"neighborDist": 15.0, "maxNeighbors": 10, "timeHorizon": 20.0, "timeHorizonObst": 10.0, **scene.options}
    peer = pyrvo.RVOSimulator()
    peer.set_time_step(scene.step_time)
    for i, (here, velocity, goal) in enumerate(zip(scene.position, scene.velocity, scene.goal, strict=True)):
        peer.add_agent(here.tolist(), *given.values(), RADIUS + SAFE, scene.speed)
        peer.set_agent_velocity(i, velocity.tolist())
        peer.set_agent_pref_velocity(i, (scene.speed * (goal - here) / np.hypot(*(goal - here))).tolist())
    for corners in scene.polygons:
        peer.add_obstacle(corners)
    for points in scene.lines:
        peer.add_obstacle(points + points[-2:0:-1])
    peer.process_obstacles()
    peer.do_step()
    return np.array([peer.get_agent_velocity(i).to_tuple() for i in range(len(scene.position))])


def our_velocities(scene: Scene) -> np.ndarray:
    """Return what our group chooses."""
    count = len(scene.position)
    robots = {
        "number": count,
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": RADIUS},
        "state": [[*here, 0.0] for here in scene.position.tolist()],
        "goal": [[*goal, 0.0] for goal in scene.goal.tolist()],
        "vel_max": [scene.speed, 1.0],
        "group_behavior": {"name": "orca", "safe_radius": SAFE, **scene.options},
    }
    walls = [("polygon", corners) for corners in scene.polygons] + [("linestring", points) for points in scene.lines]
    obstacles = [
        {"shape": {"name": name, "vertices": [list(point) for point in points]}, "state": [0, 0, 0]}
        for name, points in walls
    ]
    data = {"world": {"step_time": scene.step_time}, "robot": robots, "obstacle": obstacles}
    sim = ig.compile(ig.load_scenario(data, warn=False))
    sim.reset()
    sim.state.plan[0, :count] = scene.velocity
    (group,) = sim.parts.group_behaviors
    group.kind.decide(group, sim.model, sim.state, sim.shards.all[0])
    return sim.state.plan[0, :count]
