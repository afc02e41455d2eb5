"""What the nodes of ROS 1 and ROS 2 share: topics, settings, goals of other frames, and when a command is due."""

from __future__ import annotations

import re
import runpy
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as Way
from sensor_msgs.msg import LaserScan
from tf2_ros import TransformException


class Driving:
    """The driver in a node.

    A contract that does not fit its graph is a ValueError, a missing one an OSError.

    Args:
        contract: Path of contract.json, with drive.py and the graph beside it.
        transform: Returns a geometry_msgs/TransformStamped to one frame from another.
        say: Logs a text.
        drive: Publishes a command, if one is due; called for each scan with the setting ``on_scan``.
    """

    def __init__(
        self, contract: str, transform: Callable[[str, str], Any], say: Callable[[str], Any], drive: Callable[[], None]
    ) -> None:
        script = runpy.run_path(str(Path(contract).with_name("drive.py")))
        self.driver: Any = script["Driver"](contract)
        self.heading: Callable[[Any], float] = script["SCANS"]["heading"]
        self.transform, self.say, self.drive = transform, say, drive
        scan = self.driver.contract["scan"] or {"no_return": "inf", "mount": [0.0, 0.0, 0.0]}
        x, y, yaw = map(float, scan["mount"])
        self.settings: dict[str, Any] = {
            "period": float(self.driver.contract["period"]),  # between commands [s]
            "no_return": scan["no_return"],  # "zero" where the scanner reports 0 for nothing in range
            "scanner_x": x,  # where the scanner is on the robot [m]
            "scanner_y": y,
            "scanner_yaw": yaw,  # where its beam at 0 looks [rad]
            "ahead": self.driver.ahead,  # of a path, the goal is this far on [m]
            "speed_share": 1.0,  # of every command
            "on_scan": False,  # a command for each scan at once, for scanners as fast as the policy
        }
        self.way: Any = None
        self.way_frame, self.said = "", "nothing"
        self.answered = -np.inf

    def use(self, parameter: Callable[[str, Any], Any]) -> float:
        """Take the settings from a node's ``parameter(name, default)``; return how often to ask for a command [s]."""
        settings = self.settings = {name: parameter(name, default) for name, default in self.settings.items()}
        settings["on_scan"] &= self.driver.contract["scan"] is not None
        self.driver.no_return, self.driver.ahead = settings["no_return"], settings["ahead"]
        self.driver.mount = [settings[name] for name in ("scanner_x", "scanner_y", "scanner_yaw")]
        return float(settings["period"] * (0.5 if settings["on_scan"] else 1.0))

    def topics(self) -> list[tuple[str, Any, Callable[[Any], None], bool]]:
        """Return the topics to hear: name, type, what takes a message, and whether the next message makes up for it."""
        scan = [("scan", LaserScan, self.scan, True)] if self.driver.contract["scan"] else []
        goal, path = (partial(self.place, take) for take in (self.driver.goal, self.driver.path))
        ways = [("goal_pose", PoseStamped, goal, False), ("plan", Way, path, False)]
        return [*scan, ("odom", Odometry, self.odometry, True), *ways]

    def begin(self) -> None:
        """Forget everything but the goal, as after a pause."""
        self.driver.forget()
        self.driver.now, self.said = -np.inf, "nothing"

    def scan(self, msg: Any) -> None:
        """Take a scan."""
        self.driver.scan(msg)
        self._answer()

    def odometry(self, msg: Any) -> None:
        """Take an odometry."""
        self.driver.odometry(msg)
        self._answer()

    def place(self, take: Callable[[Any], None], msg: Any) -> None:
        """Take a goal or a path in any frame, by a method of the driver."""
        self.driver.way = self.way
        take(msg)
        self.way, self.way_frame = self.driver.way, self.driver.goal_frame

    def command(self, now: float) -> tuple[float, float, float] | None:
        """Return what to drive now: ahead and to the left [m/s], and the turn rate [rad/s]; None if nothing is due."""
        driver, waited = self.driver, now - self.driver.now
        is_old = now - min(driver.scan_time, driver.pose_time) > driver.contract["stop"]["scan_age"]
        least = (0.75 if self._is_new() else 1.5) * self.settings["period"]
        if self.settings["on_scan"] and not is_old and 0.0 <= waited < least:
            return None
        self.answered = driver.scan_time
        self._place_goal()
        *velocity, reason = driver.tick(now)
        kind = re.sub(r"[\d.]+", "", reason)  # an age grows, and is said once
        if kind != self.said:
            self.say(f"stands: {reason}" if reason and not any(velocity) else reason or "drives")
        self.said = kind
        drive, share = driver.contract["robot"]["drive"], self.settings["speed_share"]
        left = velocity[1] if drive.startswith("omni") else 0.0
        return share * velocity[0], share * left, share * (0.0 if drive == "omni" else velocity[-1])

    def _is_new(self) -> bool:
        """Return whether a scan waits for a command, and the odometry is as new."""
        return bool(self.answered != self.driver.scan_time <= self.driver.pose_time)

    def _answer(self) -> None:
        if self.settings["on_scan"] and self._is_new():
            self.drive()

    def _place_goal(self) -> None:
        """Move the way to the frame of the odometry, by what is known now of how the two lie."""
        target, source = self.driver.frame, self.way_frame
        if self.way is None or not target or target == source:
            return
        try:
            shift = self.transform(target, source).transform
        except TransformException:
            return  # the driver says which frames these are
        turn, (x, y, heading) = self.heading(shift.rotation), self.way.T
        x, y = np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y
        moved = [shift.translation.x + x, shift.translation.y + y, heading + turn]
        self.driver.way, self.driver.goal_frame = np.stack(moved, axis=1), target
