"""The shield ``stop_in_time`` for the driver: a robot is slowed down until it can stop before what its scan shows.

It does what the simulator's does, for a disc around the robot's origin, with NumPy alone. It follows the robot from its
latest scan on: through the commands under way, the new one for a period, and then a full stop.
"""

from __future__ import annotations

from cmath import rect
from collections import deque
from math import ceil, exp
from typing import Any

import numpy as np

TOLERANCE, FLAT, ROUNDING, ANGLE = 5e-4, 3e-4, 1e-9, 1e-6
"""Added to the margin [m], of one surface (share of an inverse range), rounding errors of distances and of angles."""
HALVINGS, SPACING, REST = 7, 0.02, 2e-5
"""Of the speed; farthest places on a way [m]; who goes no farther in a period stands [m]."""
LONGEST, SENT = 10_000, 100
"""Periods of a stop, and commands under way, at most."""
AXES = {"diff": [0, 2], "omni": [0, 1], "omni_angular": [0, 1, 2]}
"""Where the components of a command stand among the velocity ahead, to the left [m/s] and the turn rate [rad/s]."""


class Shield:
    """The shield of one robot, by ``shield``, ``robot`` and ``period`` of contract.json."""

    def __init__(self, contract: dict[str, Any]) -> None:
        self.form, self.robot, self.period = contract["shield"], contract["robot"], contract["period"]
        axes, self.limits, self.sent = AXES[self.robot["drive"]], np.full(3, np.inf), deque([np.zeros(3)] * SENT, SENT)
        self.limits[axes] = [np.inf if one is None else one for one in self.robot["acceleration"]]
        self.whole = np.eye(3)[axes]  # from a command to all three axes

    def slowed(self, driver: Any, command: Any) -> tuple[Any, str]:
        """Return a command, or the fastest one of its sort after which the robot can stop, and why it is another one.

        It keeps its turn rate where the robot may turn on the spot, else its arc.
        """
        msg, ranges, lost, velocity = driver.seen
        step, twist, share, turns = msg.angle_increment, command @ self.whole, 1.0, 1.0
        if abs(2.0 * np.pi - abs(step) * len(ranges)) < 0.5 * abs(step):  # the first beam comes behind the last
            ranges, lost = np.resize(ranges, len(ranges) + 1), np.resize(lost, len(ranges) + 1)
        off = np.sign(step) * (np.arctan2(twist[1], twist[0]) - driver.mount[2] - msg.angle_min) + ANGLE
        looks = np.remainder(off, 2.0 * np.pi) <= abs(step) * (len(ranges) - 1) + 2.0 * ANGLE or not twist[:2].any()
        self.walls = walls_of(msg, ranges, lost, driver.mount, self.robot["radius"])
        self.gaps = distances(np.zeros(1), self.walls)[0] - self.robot["radius"]
        self.velocity = np.nan_to_num(velocity[0], posinf=0.0, neginf=0.0) @ self.whole
        self.delay = self.form["latency"] + max(driver.now - driver.scan_time, 0.0)
        if not (looks and self._stops(twist)):
            share, turns = 0.0, float(self._stops(twist * [0.0, 0.0, 1.0]))
            for k in range(HALVINGS if looks else 0):
                more = share + 0.5 ** (k + 1)
                share = more if self._stops(twist * [more, more, max(turns, more)]) else share
        self.sent.append(twist * [share, share, max(turns, share)])
        slower = self.whole @ self.sent[-1]
        if "pending" in driver.states:
            driver.states["pending"][0, -1] = slower
        return slower, "slowed by stop_in_time" if np.any(slower != command) else ""

    def _stops(self, twist: Any) -> bool:
        """Return whether the robot can stop after a command."""
        way, most = self._way(twist), self.form["margin"] + TOLERANCE
        near = self.gaps < np.abs(way).max() + most
        least = self.robot["radius"] + np.minimum(self.gaps, most)[near] - ROUNDING
        return bool((distances(way, self.walls[:, near]) >= least).all())

    def _way(self, twist: Any) -> Any:
        """Return places on two ways of a command, (2, n), as complex numbers [m].

        On the first it turns after each period, as in the simulator, on the second halfway; an arc lies between.
        """
        n, lag = min(ceil(self.delay / self.period - 1e-9), SENT), self.form["lag"]
        now, turn = self.velocity.tolist(), 0.0
        asked, ways = np.array([*self.sent, twist])[-n - 1 :].tolist(), ([0j], [0j])
        for k in range(n + LONGEST):
            span = self.delay - (n - 1) * self.period if k == 0 < n else self.period
            share, wanted = 1.0 - exp(-span / lag) if lag else 1.0, asked[k] if k <= n else [0.0] * 3
            for axis, most in enumerate(self.limits * span):
                now[axis] += min(max((wanted[axis] - now[axis]) * share, -most), most)
            far = complex(now[0], now[1]) * span
            if k > n and abs(far) < REST * share:
                break
            count = int(abs(far) / SPACING) + 1
            for way, angle in zip(ways, (turn, turn + 0.5 * now[2] * span)):  # noqa: B905  (as in drive.py)
                way += [way[-1] + far * rect(part / count, angle) for part in range(1, count + 1)]
            turn += now[2] * span
        return np.array(ways)


def walls_of(msg: Any, ranges: Any, lost: Any, mount: Any, radius: float) -> Any:
    """Return the lines that a scan shows to the robot, (2, n), as complex numbers [m].

    Neighbouring beams are joined, without those that are lost. The surface that a beam has hit may go on up to the next
    beam, as it did before: two lines to there, on either side.
    """
    step = float(msg.angle_increment)
    near = 1.0 / np.clip(ranges, max(msg.range_min, 1e-3), msg.range_max)
    eye, looks = complex(mount[0], mount[1]), np.exp(1j * (msg.angle_min + mount[2] + step * np.arange(len(near))))
    on, back, hits = _going_on(near, step)[:-1], _going_on(near[::-1], step)[::-1][1:], near * msg.range_max > 1.0001
    ahead, behind = looks[1:] / np.where(hits[:-1], on, near[1:]), looks[:-1] / np.where(hits[1:], back, near[:-1])
    tips = eye + np.array([ahead, behind])
    tips *= np.maximum(1.0, (radius + 0.2 * TOLERANCE) / np.abs(tips))  # nothing stands in the robot
    ends = eye + looks / near
    known, begin, end = ends[~lost], ends[:-1], ends[1:]
    return np.array([[*known[:-1], *begin, *end, *end, *begin], [*known[1:], *tips[0], *tips[0], *tips[1], *tips[1]]])


def _going_on(near: Any, step: float) -> Any:
    """Return the inverse range of the next beam on the surface that each has hit; at least its own.

    It is its own, too, where three beams do not agree, because the one before has hit something else.
    """
    bend, before, earlier = 2.0 - 2.0 * np.cos(step), np.roll(near, 1), np.roll(near, 2)
    rise = (1.0 - bend) * near - before
    agree = (rise <= (1.0 - bend) * before - earlier + FLAT * near) & (np.arange(len(near)) >= 2)
    return near + np.where(agree, np.maximum(rise, 0.0), 0.0)


def distances(places: Any, walls: Any) -> Any:
    """Return how far places (..) are from lines (2, w), all complex numbers: (.., w)."""
    along, away = walls[1] - walls[0], places[..., None] - walls[0]
    share = (away * along.conj()).real / np.maximum(np.abs(along) ** 2, 1e-18)
    return np.abs(away - np.clip(share, 0.0, 1.0) * along)
