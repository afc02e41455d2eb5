"""The node of ROS 2 between stand-ins of rclpy and messages of rosbags: life cycle, topics, commands, log."""

from __future__ import annotations

import importlib
import json
import shutil
import signal
from pathlib import Path
from typing import Any

import messages
import numpy as np
import pytest

from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.robot.drive import Driver
from irsim_gym.robot.inputs import measured, scanner_of
from irsim_gym.tasks import Outcome

PERIOD = 0.1
FREE = np.full(180, 6.0)


class Ros:
    """A node between stand-ins."""

    def __init__(self, folder: Path, **given: Any) -> None:
        self.module: Any = importlib.import_module("cluttered_room_driver.node")
        self.node: Any = self.module.DriverNode()
        self.node.given = given
        self.folder = folder

    def activate(self) -> None:
        for trigger in (self.node.trigger_configure, self.node.trigger_activate):
            assert trigger().name == "SUCCESS", self.node.said

    def hear(self, topic: str, msg: Any) -> None:
        (subscription,) = (one for one in self.node.subscriptions if one.topic == topic)
        subscription.callback(msg)

    def feed(self, now: float, ranges: Any = FREE, place: Any = (1.0, 1.0, 0.0), **how: Any) -> None:
        """Let a scan and an odometry of now arrive."""
        self.node.now = now
        self.hear("scan", messages.scan(now, ranges, **how))
        self.hear("odom", messages.odometry(now, place))

    def fire(self, now: float) -> Any:
        """Call the timer; return the message that it publishes, None without one."""
        self.node.now = now
        (timer,), (publisher,) = self.node.timers, self.node.publishers
        before = len(publisher.sent)
        timer.callback()
        return publisher.sent[-1] if len(publisher.sent) > before else None

    @property
    def sent(self) -> list[tuple[float, float]]:
        (publisher,) = self.node.publishers
        return [(msg.linear.x, msg.angular.z) for msg in publisher.sent]


@pytest.fixture
def folder(ros2: Path, stand_ins: None, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(ros2)
    monkeypatch.setenv("SHARE_OF_cluttered_room_driver", str(ros2))
    monkeypatch.setenv("ROS_DISTRO", "jazzy")
    return ros2


@pytest.fixture
def ros(folder: Path) -> Ros:
    return Ros(folder)


def test_it_listens_once_it_is_configured(ros: Ros) -> None:
    assert ros.node.name == "cluttered_room_driver"
    assert ros.node.subscriptions == ros.node.publishers == []
    assert ros.node.trigger_configure().name == "SUCCESS"
    asked = {
        one.topic: (one.qos.depth, one.qos.reliability.name) if hasattr(one.qos, "depth") else one.qos
        for one in ros.node.subscriptions
    }
    assert asked == {"scan": (1, "BEST_EFFORT"), "odom": (1, "BEST_EFFORT"), "goal_pose": 1, "plan": 1}
    assert [(one.topic, one.qos) for one in ros.node.publishers] == [("cmd_vel", 1)]
    ros.node.timers[0].callback()
    assert ros.sent == []


def test_it_commands_what_the_driver_does(ros: Ros) -> None:
    ros.activate()
    (timer,) = ros.node.timers
    assert timer.period == PERIOD
    driver = Driver(ros.folder / "contract.json")
    for one in (driver.goal, lambda msg: ros.hear("goal_pose", msg)):
        one(messages.goal(6.0, 3.0))
    rng, expected = np.random.default_rng(0), []
    for k in range(20):
        ranges, place = rng.uniform(1.0, 8.0, 180), (1.0 + 0.05 * k, 1.0, 0.1)
        ros.feed(PERIOD * k, ranges, place)
        driver.scan(messages.scan(PERIOD * k, ranges))
        driver.odometry(messages.odometry(PERIOD * k, place))
        assert ros.fire(PERIOD * k) is not None
        expected.append(driver.tick(PERIOD * k)[:2])
    assert ros.sent == expected
    assert np.ptp(expected, axis=0)[1] > 1.0


def test_it_stops_the_robot_when_it_is_deactivated_and_is_silent_then(ros: Ros) -> None:
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    ros.feed(0.0)
    assert ros.fire(0.0).linear.x > 0.5
    assert ros.node.trigger_deactivate().name == "SUCCESS"
    assert ros.sent[-1] == (0.0, 0.0)
    ros.feed(0.1)
    assert ros.fire(0.1) is None
    assert ros.node.trigger_activate().name == "SUCCESS"
    ros.feed(50.0)
    assert ros.fire(50.0).linear.x > 0.5  # the goal is still known, and the pause is not taken for elapsed time


def test_a_shutdown_stops_the_robot_too(ros: Ros) -> None:
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    ros.feed(0.0)
    ros.fire(0.0)
    ros.node.trigger_shutdown()
    assert ros.sent[-1] == (0.0, 0.0)


def test_it_can_be_configured_anew(ros: Ros) -> None:
    ros.activate()
    ros.node.trigger_deactivate()
    ros.node.trigger_cleanup()
    assert ros.node.subscriptions == ros.node.publishers == ros.node.timers == []
    ros.activate()
    assert len(ros.node.subscriptions) == 4


@pytest.mark.parametrize(
    ("distro", "given", "is_stamped"),
    [
        ("humble", {}, False),
        ("jazzy", {}, False),
        ("kilted", {}, True),
        ("lyrical", {}, True),
        ("rolling", {}, True),
        ("jazzy", {"stamped": True}, True),
        ("kilted", {"stamped": False}, False),
    ],
)
def test_commands_are_stamped_from_kilted_on(
    folder: Path, monkeypatch: pytest.MonkeyPatch, distro: str, given: dict[str, bool], is_stamped: bool
) -> None:
    monkeypatch.setenv("ROS_DISTRO", distro)
    ros = Ros(folder, **given)
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    ros.feed(2.5)
    msg = ros.fire(2.5)
    assert hasattr(msg, "header") is is_stamped
    twist = msg.twist if is_stamped else msg
    assert twist.linear.x > 0.5
    if is_stamped:
        assert (msg.header.stamp.sec, msg.header.stamp.nanosec) == (2, 500_000_000)
        assert msg.header.frame_id == "base_link"


def test_a_reason_is_said_once(ros: Ros) -> None:
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    ros.feed(0.0)
    for k in range(10):
        ros.node.now = PERIOD * k
        ros.hear("odom", messages.odometry(PERIOD * k, (1.0, 1.0, 0.0)))
        ros.fire(PERIOD * k)
    assert ros.node.said == ["drives", "stands: the scan is 0.40 s old"]
    assert [v > 0.0 for v, _ in ros.sent] == [True] * 4 + [False] * 6
    for k in range(10, 14):
        ros.feed(PERIOD * k)
        ros.fire(PERIOD * k)
    assert ros.node.said[2:] == ["stands: waits for good scans", "drives"]


def test_a_contract_that_is_not_there_is_named(folder: Path) -> None:
    ros = Ros(folder, contract="/nowhere/contract.json")
    assert ros.node.trigger_configure().name == "FAILURE"
    assert "/nowhere/" in ros.node.said[0]
    assert ros.node.state == "unconfigured"


def test_a_goal_in_the_map_is_moved_to_the_odometry(ros: Ros) -> None:
    ros.activate()
    ros.hear("goal_pose", messages.goal(3.0, 5.0, frame="map"))
    ros.feed(0.0)
    ros.fire(0.0)
    assert ros.node.said == ["stands: the goal is in frame 'map', the odometry in 'odom'"]
    driver = ros.node.driving.driver
    for k, (x, y, turn) in enumerate([(0.0, 0.0, 0.0), (1.0, 2.0, np.pi / 2)]):
        moved = messages.made(
            "geometry_msgs/msg/Transform",
            translation=messages.made("geometry_msgs/msg/Vector3", x=x, y=y, z=0.0),
            rotation=messages.pose(0.0, 0.0, turn).orientation,
        )
        ros.node.buffer.known["odom", "map"] = messages.made(
            "geometry_msgs/msg/TransformStamped",
            header=messages.header(0.0, "odom"),
            child_frame_id="map",
            transform=moved,
        )
        ros.feed(0.1 + 0.1 * k)
        assert ros.fire(0.1 + 0.1 * k).angular.z != 0.0
        expected = [[3.0, 5.0, 0.0], [1.0 - 5.0, 2.0 + 3.0, np.pi / 2]][k]
        np.testing.assert_allclose(driver.way, [expected], atol=1e-12)
    driver.states["action"][:] = 0.25
    count = driver.states["record_nearest"].copy()
    ros.hear("goal_pose", messages.goal(3.0, 5.0, frame="map"))  # the same again: nothing is forgotten
    np.testing.assert_array_equal(driver.states["record_nearest"], count)


def test_a_path_in_the_map_is_followed(ros: Ros) -> None:
    ros.activate()
    ros.hear("plan", messages.path([(1.0, 1.0), (4.0, 1.0), (8.0, 1.0)]))
    ros.feed(0.0)
    assert ros.fire(0.0).linear.x > 0.5


def test_with_on_scan_a_scan_is_answered_at_once(folder: Path) -> None:
    ros = Ros(folder, on_scan=True)
    ros.activate()
    assert ros.node.timers[0].period == 0.5 * PERIOD
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    for k in range(3):
        ros.feed(PERIOD * k)
        assert len(ros.sent) == k + 1  # as soon as the odometry is as new as the scan
        assert ros.fire(PERIOD * k + 0.05) is None
    ros.feed(0.22)
    assert len(ros.sent) == 3  # a scanner that is too fast does not hurry the policy
    fired = {k: ros.fire(0.05 * k) for k in range(5, 12)}
    assert [k for k, msg in fired.items() if msg is not None] == [6, 9, 11]  # 0.08, 0.15 and 0.1 s later
    assert fired[9].linear.x > 0.0  # the scan is 0.23 s old
    assert (fired[11].linear.x, fired[11].angular.z) == (0.0, 0.0)
    assert ros.node.said[-1].startswith("stands: the scan is")


def test_with_on_scan_scans_are_answered_after_the_clock_has_jumped_back(folder: Path) -> None:
    ros = Ros(folder, on_scan=True)
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 1.0))
    ros.feed(50.0)
    assert ros.fire(10.0) is not None
    for k in range(5):
        ros.feed(10.1 + PERIOD * k)
        assert len(ros.sent) == 3 + k
    assert ros.node.said == ["drives", "stands: the clock jumps back", "stands: waits for good scans", "drives"]


def test_a_turned_scanner_is_turned_back(folder: Path, tmp_path: Path) -> None:
    """A wall on the left, as a scanner sees it whose beam 0 looks to the left; the contract says that it was tested."""
    shutil.copytree(folder, tmp_path / "fitted")
    file = tmp_path / "fitted" / "contract.json"
    contract = json.loads(file.read_text(encoding="utf-8"))
    contract["scan"]["mounts"][2] = [0.0, 1.6]
    file.write_text(json.dumps(contract), encoding="utf-8")
    turned, straight = Ros(folder, scanner_yaw=np.pi / 2, contract=str(file)), Ros(folder)
    angles = np.linspace(-np.pi, np.pi, 180)
    for one, looks in ((turned, angles + np.pi / 2), (straight, angles)):
        one.activate()
        one.feed(0.0, np.where(np.abs(np.remainder(looks + np.pi, 2 * np.pi) - np.pi - 1.5) < 0.3, 1.0, 6.0))
    seen = [np.flatnonzero(one.node.driving.driver.ranges[0] < 2.0) for one in (turned, straight)]
    assert len(seen[1]) > 10
    assert np.abs(seen[0].mean() - seen[1].mean()) < 1.0
    assert turned.node.driving.driver.scan_fault == ""


def test_a_mount_that_was_not_tested_is_refused(folder: Path) -> None:
    ros = Ros(folder, scanner_x=0.3)
    ros.activate()
    ros.hear("goal_pose", messages.goal(8.0, 2.0))
    ros.feed(0.0)
    ros.fire(0.0)
    assert ros.sent == [(0.0, 0.0)]
    assert ros.node.said == ["stands: scanner: x 0.3, tested from 0 to 0"]


def test_a_policy_without_a_scan_hears_none(folder: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "blind")
    file = tmp_path / "blind" / "contract.json"
    contract = json.loads(file.read_text(encoding="utf-8"))
    file.write_text(json.dumps({**contract, "scan": None}), encoding="utf-8")
    ros = Ros(folder, contract=str(file))
    ros.activate()
    assert [one.topic for one in ros.node.subscriptions] == ["odom", "goal_pose", "plan"]


def test_a_share_of_the_speed_and_zeros_for_nothing_in_range(folder: Path) -> None:
    slow, fast = Ros(folder, speed_share=0.25, no_return="zero"), Ros(folder)
    for one, zeros in ((slow, True), (fast, False)):
        one.activate()
        one.hear("goal_pose", messages.goal(8.0, 2.0))
        one.feed(0.0, zeros=zeros)
        one.fire(0.0)
    np.testing.assert_allclose(np.array(slow.sent), 0.25 * np.array(fast.sent))


def test_ctrl_c_stops_the_robot_before_ros_ends(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ros, before = Ros(folder), signal.getsignal(signal.SIGTERM)
    rclpy: Any = importlib.import_module("rclpy")
    nodes = []

    def begin(node: Any) -> None:
        nodes.append(node)
        ros.node = node
        ros.activate()
        ros.hear("goal_pose", messages.goal(8.0, 1.0))
        ros.feed(0.0)
        ros.fire(0.0)

    monkeypatch.setattr(ros.module.SingleThreadedExecutor, "turns", (begin,))
    monkeypatch.setattr(rclpy, "shutdown", lambda: rclpy.log.append(ros.sent[-1]))
    try:
        ros.module.main()
        assert signal.getsignal(signal.SIGTERM) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGTERM, before)
    assert rclpy.log == ["init NO", (0.0, 0.0)]


def test_it_drives_levels_of_the_simulator(ros: Ros) -> None:
    ros.activate()
    played, now, solved = ScenarioRequest("cluttered_room").episodes(1), 0.0, 0
    scanner = scanner_of(played)
    assert scanner is not None
    for level in range(3):
        played.begin(np.zeros(1, np.int64), np.array([level]), "test")
        ros.hear("goal_pose", messages.goal(*measured(played)["goal"][0, :2]))
        while played.view.infos["outcome"][0, 0] == Outcome.RUNNING:
            values, now = measured(played), now + PERIOD
            ros.node.now = now
            ros.hear("scan", messages.scan(now, values["ranges"][0]))
            ros.hear("odom", messages.odometry(now, values["pose"][0], *values["velocity"][0]))
            msg = ros.fire(now)
            played.step(np.array([[[2.0 * msg.linear.x - 1.0, msg.angular.z / 1.5]]]))
        solved += played.view.infos["outcome"][0, 0] == Outcome.SUCCESS
    assert solved == 3
