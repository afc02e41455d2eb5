"""Drives a robot by an exported policy: anything with the fields of ROS messages in, velocities out."""

from __future__ import annotations

import hashlib
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime

SCANS = runpy.run_path(str(Path(__file__).with_name("scans.py")))


class Driver:
    """One robot, by contract.json. With no_return="zero", 0 is no return; mount: where the scanner is on the robot."""

    def __init__(self, contract: str | Path, no_return: str = "", ahead: float = 2.0, mount: Any = None) -> None:
        self.contract = SCANS["read_contract"](Path(contract))
        model, options = Path(contract).with_name("policy.onnx").read_bytes(), onnxruntime.SessionOptions()
        if hashlib.sha256(model).hexdigest() != self.contract["hashes"]["onnx"]:
            raise ValueError(f"{contract} belongs to another policy.onnx: their hashes differ")
        options.intra_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
        made_of, hashes = self.session.get_modelmeta().custom_metadata_map, self.contract["hashes"]
        if others := [name for name in ("policy", "scenario") if made_of.get(name) != hashes[name]]:
            raise ValueError(f"{contract} says that its policy.onnx was made of another {' and '.join(others)}")
        if apart := SCANS["differing"](self.session, self.contract):
            raise ValueError(f"{contract} and its policy.onnx differ in inputs or states: {', '.join(apart)}")
        self.own: dict[str, Any] = self.contract["scan"] or {"no_return": "", "mount": ()}
        self.no_return, self.ahead, self.mount = no_return or self.own["no_return"], ahead, mount or self.own["mount"]
        self.now = self.scan_time = self.pose_time = self.bodies_time = -np.inf
        self.good_scans, self.has_fault, self.scan_fault, self.note, self.frame, self.goal_frame = 0, False, *[""] * 4
        nothing: Any = None
        self.ranges = self.seen = self.pose = self.way = self.map = self.shield = nothing
        self.velocity, self.others = np.zeros((1, len(self.contract["robot"]["low"]))), np.zeros((1, 0, 5))
        self.states: dict[str, Any] = {}
        if self.contract["seen_map"]:
            self.map = runpy.run_path(str(Path(contract).with_name("perceive.py")))["SeenMap"](self.contract)
        if self.contract.get("shield"):
            self.shield = runpy.run_path(str(Path(contract).with_name("shield.py")))["Shield"](self.contract)
        self.forget()

    def forget(self, *kept: str) -> None:
        """Begin anew, as for a new goal."""
        for name, state in self.contract["states"].items():
            if name not in kept:
                self.states[name] = np.full([1, *state["shape"]], np.array(state["start"], float), state["dtype"])
        if self.map:
            self.map.forget()

    def scan(self, msg: Any) -> None:
        """Take a sensor_msgs/LaserScan: its beams are found by their angles, and the shortest of a share counts."""
        ranges, step, size = np.array(msg.ranges, float), float(msg.angle_increment), len(msg.ranges)
        ranges[(ranges == 0.0) & (self.no_return == "zero")] = np.inf
        lost = SCANS["lost_beams"](msg, self.no_return)
        ranges[lost | (ranges > msg.range_max)], ranges[ranges == -np.inf] = np.inf, 0.0
        self.ranges = SCANS["as_beams"](ranges[None], (msg.angle_min, step), self.mount, self.own)
        found = {"beams": size, "range_max": msg.range_max, "field_of_view": abs(step) * max(size - 1, 0)}
        found["x"], found["y"], found["turn"] = self.mount
        self.scan_fault, self.note = SCANS["compared"](found, self.own, abs(step))
        self.scan_time, self.seen = SCANS["seconds"](msg.header.stamp), (msg, ranges, lost, self.velocity)
        if size and lost.mean() > self.contract["stop"]["lost_beams"]:
            self.scan_fault = f"{lost.mean():.0%} of the beams are lost"
        self.good_scans = 0 if self.scan_fault else self.good_scans + 1

    def odometry(self, msg: Any) -> None:
        """Take a nav_msgs/Odometry."""
        self.pose, self.frame = SCANS["pose"](msg.pose.pose), msg.header.frame_id
        self.pose_time = SCANS["seconds"](msg.header.stamp)
        robot, twist = self.contract["robot"], msg.twist.twist
        x, y, turn, before = twist.linear.x, twist.linear.y, twist.angular.z, self.velocity[0, 1]
        if robot["steers"]:  # the wheels of a car that stands are taken to stay where they were
            turn = np.arctan(turn * robot["wheelbase"] / x) if x else before
        self.velocity = np.array([{"omni": [x, y], "omni_angular": [x, y, turn]}.get(robot["drive"], [x, turn])], float)

    def bodies(self, rows: Any, stamp: Any) -> None:
        """Take other bodies: rows of x, y, vx, vy, radius in the frame of the odometry; rows of NaN are absent."""
        self.others, self.bodies_time = np.array(rows, float).reshape(1, len(rows), 5), SCANS["seconds"](stamp)

    def goal(self, msg: Any) -> None:
        """Take a geometry_msgs/PoseStamped as the goal; a new place begins anew."""
        found = SCANS["pose"](msg.pose)
        if self.way is None or np.any(found[0, :2] != self.way[-1, :2]):
            self.forget("action", "pending")
        self.way, self.goal_frame = found, msg.header.frame_id

    def path(self, msg: Any) -> None:
        """Take a nav_msgs/Path: the goal is its point ``ahead`` metres on, at last its end."""
        self.way = np.concatenate([SCANS["pose"](one.pose) for one in msg.poses]) if msg.poses else None
        self.goal_frame = msg.header.frame_id

    def tick(self, now: float) -> tuple[Any, ...]:
        """Return what to drive: (v, w, reason), of omni (vx, vy, reason), of omni_angular (vx, vy, w, reason)."""
        elapsed, is_back, self.now = now - self.now, now < self.now, now
        fault = "the clock jumps back" if is_back else self._fault()
        self.good_scans = 0 if fault else self.good_scans
        self.has_fault = bool(fault) or (self.has_fault and self.good_scans < 3)
        if reason := fault or ("waits for good scans" if self.has_fault else self._rest()):
            return self._still(reason)
        away = np.hypot(*(self.way[:, :2] - self.pose[0, :2]).T)
        beyond = np.flatnonzero((np.arange(len(away)) >= away.argmin()) & (away >= self.ahead))
        goal, waited = self.way[[beyond[0] if len(beyond) else -1]], np.array([[elapsed if elapsed < np.inf else 0.0]])
        values = {"ranges": self.ranges, "pose": self.pose, "velocity": self.velocity, "goal": goal, "elapsed": waited}
        way = {"way_on_seen_map": self.map.way(self.ranges[0], self.pose[0], goal[0])[None]} if self.map else {}
        known = {**values, **way, **self.states, "bodies": self.others}
        given = {name: known[name] for name in self.contract["inputs"]}
        found, *after = self.session.run(["command", *(f"{name}_next" for name in self.states)], given)
        command, robot = found[0].astype(float), self.contract["robot"]
        if not np.isfinite(command).all():
            self.good_scans, self.has_fault = 0, True
            return self._still("the command is not finite")
        self.states = dict(zip(self.states, after))  # noqa: B905  (Python 3.8 knows no strict)
        if self.shield:
            command, reason = self.shield.slowed(self, command)
        if robot["steers"]:
            command[1] = command[0] * np.tan(command[1]) / robot["wheelbase"]
        return (*command.tolist(), reason)

    def _still(self, reason: str) -> tuple[Any, ...]:
        self.states["action"] = np.full_like(self.states["action"], self.contract["states"]["action"]["start"])
        if self.shield:
            self.shield.sent.append(np.zeros(3))
        if "pending" in self.states:  # this command is under way, too
            self.states["pending"] = np.pad(self.states["pending"][:, 1:], ((0, 0), (0, 1), (0, 0)))
        return (*[0.0] * self.velocity.shape[1], reason)

    def _fault(self) -> str:
        times = [("scan is", self.scan_time, "tested" in self.own), ("odometry is", self.pose_time, True)]
        for what, time, is_needed in [*times, ("bodies are", self.bodies_time, self.contract["bodies"])]:
            name, age = what.split()[0], self.now - time
            if is_needed and age > self.contract["stop"][f"{name}_age"]:
                return f"the {what} {age:.2f} s old" if age < np.inf else f"no {name} yet"
        if np.any(np.isfinite(self.others).any(axis=2) & ~np.isfinite(self.others).all(axis=2)):
            return "the bodies are not finite"
        return self.scan_fault if all(np.isfinite([*self.pose[0], *self.velocity[0]])) else "the odometry is not finite"

    def _rest(self) -> str:
        if self.way is None:
            return "no goal"
        if self.goal_frame != self.frame:
            return f"the goal is in frame '{self.goal_frame}', the odometry in '{self.frame}'"
        gap = self.way[-1] - self.pose[0]
        gap[2] = np.remainder(gap[2] + np.pi, 2.0 * np.pi) - np.pi if self.contract["goal"]["heading"] else 0.0
        if not np.isfinite(gap).all():
            return "the goal is not finite"
        off = self.map.fault(self.pose[0], self.way[-1]) if self.map else ""
        return "arrived" if np.sqrt(gap @ gap) < self.contract["goal"]["tolerance"] else off
