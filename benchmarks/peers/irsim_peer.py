"""ir-sim: the same YAML, stepped through its public interface; the gym wrapper around it is ours."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from worker import Peer, Play, Work, random_actions, serve

OURS_ALONE = ("clearance", "min_goal_distance", "reachable")
"""Options of a distribution that ir-sim does not have."""


STAY = 2
"""Steps at each place of a map."""


def make(given: Mapping[str, Any]) -> Any:
    """Return an environment of ir-sim for the scenario, without a window."""
    import irsim
    import yaml

    scenario = {key: value for key, value in given["scenario"].items() if key != "task"}
    robots = []
    for entry in scenario["robot"]:
        place = {key: value for key, value in entry.get("distribution", {}).items() if key not in OURS_ALONE}
        robots.append({**entry, "distribution": place} if place else entry)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scenario.yaml"
        file.write_text(yaml.safe_dump({**scenario, "robot": robots}), encoding="utf-8")
        return irsim.make(str(file), headless=True, display=False, log_level="CRITICAL")


class Wrapper:
    """One robot as Gymnasium's users would wrap it: observation, reward, ends, and a new start after each.

    Args:
        given: What the work is.
        stay: Steps after which the robot is put at the next start without looking around there; 0 for never.
    """

    def __init__(self, given: Mapping[str, Any], stay: int = 0) -> None:
        import numpy as np

        self.np, self.stay = np, stay
        self.env = make(given)
        self.robot = self.env.robot
        world, sensor = given["scenario"]["world"], given["scenario"]["robot"][0]["sensors"][0]
        self.far, self.diagonal = sensor["range_max"], math.hypot(world["width"], world["height"])
        self.max_steps = given["scenario"]["task"]["max_steps"]
        self.places = given["starts"]
        self.rewind()

    def rewind(self) -> None:
        """Begin with the first start again, and with the same actions."""
        self.count, self.starts = 0, itertools.cycle(self.places)
        self.actions = itertools.cycle(self.np.array(random_actions(64, 2)))
        self.reset()

    def reset(self) -> Any:
        """Put the robot at the next start and look around."""
        self.put()
        self.env.refresh()
        return self.observe(self.np.zeros(2))

    def put(self) -> None:
        """Put the robot at the next start."""
        x, y, heading, goal_x, goal_y = next(self.starts)
        self.robot.reset()
        self.robot.set_state([x, y, heading])
        self.robot.set_goal([goal_x, goal_y, 0.0])
        self.steps, self.way = 0, math.hypot(goal_x - x, goal_y - y)

    def observe(self, velocity: Any) -> Any:
        """Return every beam, the goal and the velocity as float32."""
        np = self.np
        x, y, heading = (float(v) for v in self.robot.state[:3, 0])
        dx, dy = float(self.robot.goal[0, 0]) - x, float(self.robot.goal[1, 0]) - y
        way = math.hypot(dx, dy)
        bearing = math.atan2(dy, dx) - heading
        observation = np.empty(186, np.float32)
        observation[:180] = 1.0 - np.maximum(self.robot.get_lidar_scan()["ranges"] - 0.2, 0.0) / self.far
        observation[180:184] = way / self.diagonal, math.cos(bearing), math.sin(bearing), math.exp(-way)
        observation[184:] = velocity
        return observation

    def step(self) -> Any:
        """Play one step of random driving."""
        np = self.np
        action = next(self.actions)
        command = np.array([[0.5 * (1.0 + action[0])], [1.5 * action[1]]])
        self.env.step(command)
        self.steps += 1
        x, y = float(self.robot.state[0, 0]), float(self.robot.state[1, 0])
        way = math.hypot(float(self.robot.goal[0, 0]) - x, float(self.robot.goal[1, 0]) - y)
        hit, arrived = bool(self.robot.collision), bool(self.robot.arrive)
        reward = 4.0 * (self.way - way) / self.diagonal - 2.0 / self.max_steps + 5.0 * arrived - 4.0 * hit
        self.way = way
        observation = self.observe(command[:, 0] / (1.0, 1.5))
        if hit or arrived or self.steps >= self.max_steps:
            observation = self.reset()
        self.count += 1
        if self.stay and self.count % self.stay == 0:
            self.put()
        return observation, reward, hit or arrived, self.steps >= self.max_steps, {}


def wrapped(given: Mapping[str, Any]) -> Play:
    """Return one robot in a gym wrapper."""
    return Play(Wrapper(given).step, 1)


def wrapped_in_map(given: Mapping[str, Any]) -> Play:
    """Return the same, at each start of the list for a few steps: what they cost differs much from place to place."""
    wrapper = Wrapper(given, STAY)
    return Play(wrapper.step, 1, wrapper.rewind, STAY * len(given["starts"]))


def crowd(given: Mapping[str, Any]) -> Play:
    """Return robots that decide for themselves, from the start in each round."""
    env = make(given)

    def places() -> list[list[float]]:
        return [[float(v) for v in robot.state[:2, 0]] for robot in env.robot_list]

    return Play(env.step, len(env.robot_list), env.reset, given["n_steps"], places)


def team(given: Mapping[str, Any]) -> Play:
    """Return robots with random commands, and every scan read as float32; for some steps from each of our levels."""
    import numpy as np

    env = make(given)
    robots, bodies = env.robot_list, [*env.robot_list, *env.obstacle_list]
    numbers = np.array(random_actions(64, 2 * len(robots))).reshape(64, len(robots), 2, 1)
    numbers[:, :, 0] = 0.5 + 0.5 * numbers[:, :, 0]
    numbers[:, :, 1] *= 1.5
    commands, n_steps = [list(row) for row in numbers], given["n_steps"]
    counts = itertools.count()

    def rewind() -> None:
        nonlocal counts
        counts = itertools.count()

    def step() -> Any:
        count = next(counts)
        if count % n_steps == 0:
            for body, place in zip(bodies, given["levels"][count // n_steps % len(given["levels"])], strict=True):
                body.reset()
                body.set_state(place)
        env.step(commands[count % len(commands)])
        return [np.asarray(robot.get_lidar_scan()["ranges"], np.float32) for robot in robots]

    return Play(step, len(robots), rewind, n_steps * len(given["levels"]))


ONE_WORLD = "one world at a time, so the step is that of a single environment"
POLYGONS = "circles are polygons of 64 corners"
SCAN_ALONE = (POLYGONS, ONE_WORLD, "no reward; only the scan is observed", "the first levels only")
WRAPPED = Work(wrapped, (POLYGONS, "starts come from a list instead of being drawn"))

IN_MAP = Work(
    wrapped_in_map,
    (
        ONE_WORLD,
        f"put at each of a list of starts for {STAY} steps, without looking around there first, to see all of the map",
    ),
)

PEER = Peer(
    "irsim",
    "ir-sim",
    {
        "s1_single": WRAPPED,
        "s1_batch": Work(wrapped, (*WRAPPED.differs, ONE_WORLD)),
        "s2_rvo": Work(crowd, (ONE_WORLD,)),
        "s2_orca": Work(crowd, (ONE_WORLD, "planning in float32, in a C++ library")),
        "s3_cave": IN_MAP,
        "s3_floor_plan": IN_MAP,
        "s4": Work(team, SCAN_ALONE),
        "s5": Work(team, SCAN_ALONE),
    },
)

if __name__ == "__main__":
    serve(PEER)
