"""Bags of robots in the simulator that are late, slow, noisy and lose beams, by amounts that are known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import messages
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer

from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile

STEP, COMMAND, DURATION, STANDS = 0.02, 0.1, 30.0, 2.0
N_BEAMS, FAR = 90, 6.0
N_PARTS = 4
"""Of a step: times of robots are multiples of 5 ms."""


@dataclass(frozen=True)
class Robot:
    """What a robot does to its commands and its scans: times [s], noise [m], share of lost beams."""

    wait: float
    delay: float
    tau: float
    noise: float
    lost: float
    reads: float = np.inf


def rooms(n_worlds: int) -> Any:
    """Return worlds of a room with four pillars, and a robot in its middle."""
    wall = {"shape": {"name": "linestring", "vertices": [[0, 0], [8, 0], [8, 8], [0, 8], [0, 0]]}}
    discs = {"number": 4, "shape": {"name": "circle", "radius": 0.4}}
    discs["state"] = [[2, 1.5, 0], [6, 2, 0], [6.5, 6, 0], [1.5, 6.5, 0]]
    scanner = {"name": "lidar2d", "number": N_BEAMS, "angle_range": 2 * np.pi, "range_max": FAR}
    robot = {"kinematics": {"name": "diff"}, "state": [4, 4, 0.3], "goal": [7, 7], "sensors": [scanner]}
    limits = {"vel_min": [-1, -2], "vel_max": [1, 2], "shape": {"name": "circle", "radius": 0.2}}
    world = {"width": 8, "height": 8, "step_time": STEP, "collision_mode": "unobstructed"}
    scenario = load_scenario({"world": world, "robot": {**robot, **limits}, "obstacle": [discs, wall]})
    return compile(scenario, n_worlds)


def write_bags(robots: list[Robot], folder: Path) -> list[Path]:
    """Drive robots by commands that change at random after standing still, and write a bag of each."""
    worlds, rng, n = rooms(len(robots)), np.random.default_rng(5), len(robots)
    worlds.reset(seed=0)
    group, member = worlds.scan(0)
    ranges, bodies = group.arrays["ranges"], np.zeros(1, np.int64)
    n_commands = round(DURATION / COMMAND)
    held = rng.uniform([-0.4, -1.2], [0.4, 1.2], (n, n_commands, 2))
    held[rng.random((n, n_commands)) < 0.7] = np.nan  # most commands repeat the one before
    held[:, : round(STANDS / COMMAND)] = 0.0
    for k in range(1, n_commands):
        held[:, k] = np.where(np.isnan(held[:, k]), held[:, k - 1], held[:, k])
    rows: list[list[tuple[float, str, Any]]] = [[] for _ in robots]
    velocity, late = np.zeros((n, 2)), np.array([robot.wait + robot.delay for robot in robots])
    fading = np.exp(-STEP / N_PARTS / np.array([[robot.tau] for robot in robots]))
    for k in range(round(DURATION / STEP)):
        time = k * STEP
        for w, robot in enumerate(robots):
            odometry = velocity[w] + rng.normal(0.0, (0.01, 0.02))
            rows[w].append((time, "/odom", messages.odometry(time, worlds.state.pose[w, 0], *odometry)))
            if k % round(COMMAND / STEP) == 0:
                rows[w].append((time, "/scan", scan(robot, time, ranges[w, member], rng)))
                rows[w].append((time + robot.wait, "/cmd_vel", command(*held[w, k // round(COMMAND / STEP)])))
        for part in range(N_PARTS):
            newest = np.floor((time + part * STEP / N_PARTS - late) / COMMAND + 1e-9).astype(int)
            wanted = held[range(n), np.maximum(newest, 0)]  # the first commands are zeros
            velocity = wanted + (velocity - wanted) * fading
        worlds.step(velocity[:, None], bodies)
    return [write(folder / f"bag_{w}", sorted(found, key=lambda row: row[0])) for w, found in enumerate(rows)]


def scan(robot: Robot, time: float, ranges: Any, rng: np.random.Generator) -> Any:
    found = np.where(ranges < FAR, ranges + rng.normal(0.0, robot.noise, N_BEAMS), FAR)
    message = messages.scan(time, found, range_max=FAR)
    message.range_min = 0.05
    message.ranges[rng.random(N_BEAMS) < robot.lost] = robot.reads
    return message


def command(v: float, w: float) -> Any:
    linear, angular = (
        messages.made("geometry_msgs/msg/Vector3", x=float(x), y=0.0, z=float(z)) for x, z in ((v, 0.0), (0.0, w))
    )
    return messages.made("geometry_msgs/msg/Twist", linear=linear, angular=angular)


def write(folder: Path, rows: list[tuple[float, str, Any]]) -> Path:
    """Write messages with their times [s] and topics as a bag."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {topic: message.__msgtype__ for _, topic, message in rows}
        places = {topic: writer.add_connection(topic, kind, typestore=messages.STORE) for topic, kind in topics.items()}
        for time, topic, message in rows:
            content = messages.STORE.serialize_cdr(message, message.__msgtype__)
            writer.write(places[topic], round(1e9 * time), content)
    return folder
