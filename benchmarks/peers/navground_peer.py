"""navground: crowds under its ORCA, and a robot with its lidar, in its own C++ core."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from worker import Peer, Play, Work, serve


def crowd(given: Mapping[str, Any]) -> Play:
    """Return discs that avoid each other, each with a goal of its own, from the start in each round."""
    robots = given["scenario"]["robot"][0]
    options, step_time = robots["group_behavior"], 0.1
    holder: list[Any] = []

    def begin() -> None:
        from navground import core, sim

        world = sim.World()
        for start, goal in zip(robots["state"], robots["goal"], strict=True):
            kinematics = core.kinematics.OmnidirectionalKinematics(robots["vel_max"][0], 10.0)
            behavior = core.behaviors.ORCABehavior(kinematics, robots["shape"]["radius"])
            behavior.max_number_of_neighbors = options["maxNeighbors"]
            behavior.time_horizon = options["timeHorizon"]
            behavior.optimal_speed = robots["vel_max"][0]
            behavior.horizon = options["neighborDist"]
            behavior.safety_margin = options["safe_radius"]
            estimation = sim.state_estimations.BoundedStateEstimation(options["neighborDist"])
            task = sim.tasks.WaypointsTask([goal[:2]], loop=False, tolerance=0.1)
            agent = sim.Agent(
                radius=robots["shape"]["radius"],
                behavior=behavior,
                kinematics=kinematics,
                task=task,
                state_estimations=[estimation],
            )
            agent.position = start[:2]
            world.add_agent(agent)
        holder[:] = [world]

    begin()
    return Play(lambda: holder[0].update(step_time), len(robots["state"]), begin, given["n_steps"])


def scanner(given: Mapping[str, Any]) -> Play:
    """Return a robot that drives to and fro among the obstacles of S1, scanning."""
    from navground import core, sim

    scenario = given["scenario"]
    sensor = scenario["robot"][0]["sensors"][0]
    world = sim.World()
    for entry in scenario["obstacle"]:
        _add(world, entry)
    kinematics = core.kinematics.TwoWheelsDifferentialDriveKinematics(1.0, 0.3)
    behavior = core.behaviors.DummyBehavior(kinematics, 0.2)
    behavior.optimal_speed = 1.0
    lidar = sim.state_estimations.LidarStateEstimation(
        sensor["range_max"], -math.pi, 2.0 * math.pi, sensor["number"], (0.0, 0.0)
    )
    points = given["starts"]
    task = sim.tasks.WaypointsTask([(p[3], p[4]) for p in points], loop=True, tolerance=0.3)
    agent = sim.Agent(radius=0.2, behavior=behavior, kinematics=kinematics, task=task)
    agent.position = points[0][:2]
    world.add_agent(agent)
    # A behaviour that looks at nothing has nowhere to put a scan: it is taken beside it.
    scan = core.SensingState()
    lidar.prepare_state(scan)

    def step() -> Any:
        world.update(0.1)
        lidar.update(agent, world, scan)
        return lidar.read_ranges(scan)

    return Play(step, 1)


def _add(world: Any, entry: Mapping[str, Any]) -> None:
    """Add an obstacle: a circle as a disc, everything else as walls."""
    from navground import core, sim

    shape = entry["shape"]
    if shape["name"] == "circle":
        world.add_obstacle(sim.Obstacle(entry["state"][:2], shape["radius"]))
        return
    if shape["name"] == "linestring":
        corners = shape["vertices"]
    else:
        x, y, turn = entry["state"]
        half = [(s * shape["length"] / 2.0, t * shape["width"] / 2.0) for s, t in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        c, s = math.cos(turn), math.sin(turn)
        corners = [(x + c * p - s * q, y + s * p + c * q) for p, q in half]
        corners.append(corners[0])
    for a, b in itertools.pairwise(corners):
        world.add_wall(core.LineSegment(a, b))


SCAN_ONLY = (
    "no reward, only ranges are observed, no terminations, no restarts",
    "the robot drives straight to its goals, through obstacles",
    "rectangles are four walls",
)
CROWD = ("float32", "colliding agents are pushed apart and counted")

PEER = Peer(
    "navground",
    "navground",
    {"s1_single": Work(scanner, SCAN_ONLY), **{f"orca_{n}": Work(crowd, CROWD) for n in (10, 100, 1000)}},
)

if __name__ == "__main__":
    serve(PEER)
