"""The command ``irsim-gym bag write``: a bag of ROS 2 of an episode in the simulator."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.policies.policy import by_agent
from irsim_gym.evaluation.protocol.protocol import check_levels
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.remembered import as_trained
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.robot.graph_policy import commands_of
from irsim_gym.robot.inputs import Measured, measured, scanner_of
from irsim_gym.simulator.readings.messages import Header, odometry, planar_twist, scan_message
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.tasks.episodes.prediction import steers

TOPICS = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/odom": "nav_msgs/msg/Odometry",
    "/goal_pose": "geometry_msgs/msg/PoseStamped",
    "/cmd_vel": "geometry_msgs/msg/Twist",
}


def write_bag(asked: ScenarioRequest, source: str, folder: Path, level: int = 0, split: str = "test") -> dict[str, int]:
    """Write what a robot measures and is commanded in an episode, and return the number of messages of each topic.

    Args:
        asked: The scenario.
        source: The policy, as ``load_policy`` takes it.
        folder: The new bag.
        level: Number of the level.
        split: Its split.

    Raises:
        IrsimGymError: Something asked for does not exist, or the folder does.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    if folder.exists():
        raise IrsimGymError(f"{folder} exists: choose another name for the bag, or remove it")
    check_inputs(asked, policies=[source], split=split)
    policy, world, levels = load_policy(source), np.zeros(1, np.int64), np.array([level])
    played, rows = Perceived(as_trained(asked, [source]).episodes(1)).of(policy), list[tuple[Measured, Floats]]()
    check_levels(played.simulation.scenario, split, level + 1)
    played.begin(world, levels, split)
    policy.begin(played, world, levels)
    while played.view.infos["outcome"][0, 0] == Outcome.RUNNING:
        values, actions = measured(played), np.asarray(policy.act(played, world))
        rows.append((values, commands_of(played, actions, values)[0]))
        played.step(by_agent(actions, played, world))
    store, period = get_typestore(Stores.ROS2_JAZZY), float(played.simulation.model.step_time[0])
    counts, goal = dict.fromkeys(TOPICS, 0), np.zeros(0)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        places = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in TOPICS.items()}
        for k, (values, command) in enumerate(rows):
            messages = _messages(played, values, command, time := round(k * period * 1e9))
            if np.array_equal(goal, values["goal"], equal_nan=True):
                del messages["/goal_pose"]
            goal = values["goal"]
            for topic, message in messages.items():
                writer.write(places[topic], time, store.serialize_cdr(message, TOPICS[topic]))
                counts[topic] += 1
    return counts


def _messages(played: Episodes, values: Measured, command: Floats, time: int) -> dict[str, Any]:
    """Return the messages of a step by topic; times are in nanoseconds."""
    stamp = SimpleNamespace(sec=time // 10**9, nanosec=time % 10**9)
    header, scanner = Header(stamp=stamp, frame_id="odom"), scanner_of(played)
    messages = {"/odom": odometry(header, "base_link", values["pose"][0], _twist(played, values["velocity"][0]))}
    if scanner is not None:
        options, _, angles = scanner
        ranges = np.where(values["ranges"][0] >= options.range_max, np.inf, values["ranges"][0])
        messages["/scan"] = scan_message(Header(stamp=stamp, frame_id="laser"), options, angles, ranges)
    goal = odometry(header, "", np.nan_to_num(values["goal"][0]), None).pose.pose
    return {**messages, "/goal_pose": SimpleNamespace(header=header, pose=goal), "/cmd_vel": _twist(played, command)}


def _twist(played: Episodes, numbers: Floats) -> Any:
    """Return a command or a velocity of the first robot's drive as a twist in the body frame."""
    model, b = played.simulation.model, played.task.agents[0]
    first, second, *third = numbers.tolist()
    if steers(played.simulation, b):
        second = first * np.tan(second) / float(model.wheelbase[b])
    is_sideways = model.drive[b] not in (DIFFERENTIAL, ACKERMANN)
    return planar_twist(first, second, *(third or [0.0])) if is_sideways else planar_twist(first, 0.0, second)
