"""Drives a robot by an exported policy: messages in, velocities out. It needs NumPy and onnxruntime alone.

Any object with the fields of the ROS messages will do. ``tick`` says why it stands still: its reason is empty while the
policy drives.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime

GOOD_SCANS = 3
FAULTS = "waits for good scans"


class Driver:
    """One robot. ``contract`` is the path of contract.json, or of its folder.

    ``no_return="zero"`` is for scanners that report 0 where nothing is in range, ``ahead`` the distance of the point
    of a path that is followed [m].
    """

    def __init__(self, contract: str | Path, no_return: str = "", ahead: float = 2.0) -> None:
        file = Path(contract) / "contract.json" if Path(contract).is_dir() else Path(contract)
        self.contract = json.loads(file.read_text(encoding="utf-8"))
        model = file.with_name("policy.onnx").read_bytes()
        if hashlib.sha256(model).hexdigest() != self.contract["hashes"]["onnx"]:
            raise ValueError(f"{file} belongs to another policy.onnx: its hash of it is a different one")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
        self.outputs = [one.name for one in self.session.get_outputs()]
        self.no_return, self.ahead = no_return or self.contract["scan"]["no_return"], ahead
        self.now, self.good_scans, self.is_stopped, self.lost = -np.inf, 0, False, 0.0
        self.scan_time, self.pose_time, self.frame, self.goal_frame = -np.inf, -np.inf, "", ""
        self.ranges: Any = None
        self.pose: Any = None
        self.velocity: Any = None
        self.goal_pose: Any = None
        self.way: Any = None
        self.scanner: tuple[int, float, float, float] = (0, 0.0, 0.0, 0.0)
        self.states: dict[str, Any] = {}
        self.forget()

    def forget(self, *kept: str) -> None:
        """Begin anew, as for a new goal."""
        for name, state in self.contract["states"].items():
            if name not in kept:
                start = np.broadcast_to(np.array(state["start"], state["dtype"]), state["shape"])
                self.states[name] = start[None].copy()

    def scan(self, msg: Any) -> None:
        """Take a sensor_msgs/LaserScan; its beams are found by their angles."""
        ranges, own = np.array(msg.ranges, np.float64), self.contract["scan"]
        step, size = float(msg.angle_increment), len(ranges)
        if self.no_return == "zero":
            ranges[ranges == 0.0] = np.inf
        lost = np.isnan(ranges) | (ranges < msg.range_min) & np.isfinite(ranges)
        self.lost = float(lost.mean()) if size else 1.0
        ranges[lost | (ranges > msg.range_max)] = np.inf
        ranges[ranges == -np.inf] = 0.0
        # Places of its beams, counted in beams of the contract.
        span, n_beams = own["step"] or 2.0 * np.pi, own["beams"]
        place = _from_edge(float(msg.angle_min) + step * np.arange(size) - own["first"], 0.5 * span, n_beams) / span
        beam = np.rint(place).astype(int)
        mapped, inside = np.full(n_beams, np.inf), (beam >= 0) & (beam < n_beams)
        np.minimum.at(mapped, beam[inside], ranges[inside])
        bare = np.setdiff1d(np.arange(n_beams), beam[inside])
        if size and len(bare):
            away = np.abs((place - bare[:, None]) * span)
            away = np.minimum(away, np.abs(2.0 * np.pi - away))
            nearest = away.argmin(axis=1)
            is_near = away[np.arange(len(bare)), nearest] <= 0.51 * max(abs(step), span)
            mapped[bare[is_near]] = ranges[nearest[is_near]]
        self.ranges, self.scan_time = mapped.astype(np.float32)[None], _seconds(msg.header.stamp)
        self.scanner = (size, float(msg.range_max), abs(step) * max(size - 1, 0), abs(step))
        self.good_scans = self.good_scans + 1 if self._scan_fault() == "" else 0

    def odometry(self, msg: Any) -> None:
        """Take a nav_msgs/Odometry."""
        self.pose, self.pose_time = _pose(msg.pose.pose), _seconds(msg.header.stamp)
        self.frame, robot, twist = msg.header.frame_id, self.contract["robot"], msg.twist.twist
        ahead, left, turn = float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)
        if robot["drive"] == "omni":
            self.velocity = np.array([[ahead, left]])
        elif robot["drive"] == "omni_angular":
            self.velocity = np.array([[ahead, left, turn]])
        elif robot["steers"]:  # at rest the wheels stay where they were
            before = 0.0 if self.velocity is None else float(self.velocity[0, 1])
            self.velocity = np.array([[ahead, np.arctan(turn * robot["wheelbase"] / ahead) if ahead else before]])
        else:
            self.velocity = np.array([[ahead, turn]])

    def goal(self, msg: Any) -> None:
        """Take a geometry_msgs/PoseStamped as the goal; a new place begins anew."""
        found = _pose(msg.pose)
        if not self.contract["goal"]["heading"]:
            found[0, 2] = np.nan
        if self.goal_pose is None or np.any(found[0, :2] != self.goal_pose[0, :2]):
            self.forget("action", "pending")
        self.goal_pose, self.goal_frame, self.way = found, msg.header.frame_id, None

    def path(self, msg: Any) -> None:
        """Take a nav_msgs/Path: its point some metres ahead is the goal, at last its end."""
        if msg.poses:
            self.way = np.concatenate([_pose(one.pose) for one in msg.poses])
            self.goal_pose, self.goal_frame = self.way[-1:].copy(), msg.header.frame_id

    def tick(self, now: float) -> tuple[Any, ...]:
        """Return what to drive: (v, w, reason), (vx, vy, reason) for omni, (vx, vy, w, reason) for omni_angular."""
        elapsed, is_back = now - self.now, now < self.now
        self.now = now
        fault = "the clock jumps back" if is_back else self._fault()
        if fault:
            self.good_scans, self.is_stopped = 0, True
            return (*self._still(), fault)
        if self.is_stopped and self.good_scans < GOOD_SCANS:
            return (*self._still(), FAULTS)
        self.is_stopped = False
        reason = self._rest()
        if reason:
            return (*self._still(), reason)
        values = {"ranges": self.ranges, "pose": self.pose, "velocity": self.velocity, "goal": self._aim()}
        values["elapsed"] = np.array([[elapsed if np.isfinite(elapsed) else 0.0]])
        given = {name: value for name, value in {**values, **self.states}.items() if name in self.contract["inputs"]}
        found = dict(zip(self.outputs, self.session.run(None, given), strict=True))
        command = [float(number) for number in found["command"][0]]
        if not np.all(np.isfinite(command)):
            self.good_scans, self.is_stopped = 0, True
            return (*self._still(), "the command is not finite")
        self.states = {name: found[f"{name}_next"] for name in self.states}
        if self.contract["robot"]["steers"]:
            command[1] = command[0] * float(np.tan(command[1])) / self.contract["robot"]["wheelbase"]
        return (*command, "")

    def _still(self) -> list[float]:
        """Return a command to stand, and remember that it was given."""
        if "pending" in self.states:
            pending = self.states["pending"]
            self.states["pending"] = np.concatenate([pending[:, 1:], np.zeros_like(pending[:, :1])], axis=1)
        return [0.0] * len(self.contract["outputs"]["command"])

    def _fault(self) -> str:
        stop = self.contract["stop"]
        if "ranges" in self.contract["inputs"]:
            if self.now - self.scan_time > stop["scan_age"]:
                return f"the scan is {self.now - self.scan_time:.2f} s old"
            if fault := self._scan_fault():
                return fault
        if self.now - self.pose_time > stop["odometry_age"]:
            return f"the odometry is {self.now - self.pose_time:.2f} s old"
        finite = all(np.isfinite(part).all() for part in (self.pose, self.velocity))
        return "" if finite else "the odometry is not finite"

    def _scan_fault(self) -> str:
        tested, names = self.contract["scan"]["tested"], ("beams", "range_max", "field_of_view")
        for name, found in zip(names, self.scanner, strict=False):
            low, high = tested[name]
            slack = self.scanner[3] + 0.01 if name == "field_of_view" else 0.01 * high
            if not low - slack <= found <= high + slack:
                return f"the scanner's {name} is {found:.4g}, tested from {low:.4g} to {high:.4g}"
        share = self.contract["stop"]["lost_beams"]
        return f"{self.lost:.0%} of the beams are lost" if self.lost > share else ""

    def _rest(self) -> str:
        if self.goal_pose is None:
            return "no goal"
        if self.goal_frame != self.frame:
            return f"the goal is in frame '{self.goal_frame}', the odometry in '{self.frame}'"
        if not np.isfinite(self.goal_pose[0, :2]).all():
            return "the goal is not finite"
        gap = self.goal_pose[0] - self.pose[0]
        gap[2] = 0.0 if np.isnan(gap[2]) else np.remainder(gap[2] + np.pi, 2.0 * np.pi) - np.pi
        return "arrived" if np.sqrt(gap @ gap) < self.contract["goal"]["tolerance"] else ""

    def _aim(self) -> Any:
        if self.way is None:
            return self.goal_pose
        away = np.hypot(*(self.way[:, :2] - self.pose[0, :2]).T)
        nearest = int(away.argmin())
        beyond = np.flatnonzero(away[nearest:] >= self.ahead)
        return self.way[-1:] if not len(beyond) else self.way[nearest + beyond[0]][None]


def _from_edge(angles: Any, half: float, n_beams: int) -> Any:
    """Return angles [rad] from the first beam on, those before half a beam or after all of them a turn further."""
    outside = (angles < -half) | (angles >= (2 * n_beams - 1) * half)
    return np.where(outside, np.remainder(angles + half, 2.0 * np.pi) - half, angles)


def _seconds(stamp: Any) -> float:
    return float(stamp.sec + 1e-9 * stamp.nanosec) if hasattr(stamp, "sec") else float(stamp)


def _pose(pose: Any) -> Any:
    q = pose.orientation
    heading = np.arctan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
    return np.array([[pose.position.x, pose.position.y, heading]], np.float64)
