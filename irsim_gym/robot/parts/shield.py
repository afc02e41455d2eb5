"""The shield ``stop_in_time`` for the driver: a robot is slowed down until it can stop before what its scan shows.

It does what the simulator's does, for a disc around the robot's origin, with NumPy alone. It follows the robot from its
latest scan on: through the commands under way, the new one for a period, and then a full stop.
"""

from __future__ import annotations

from typing import Any

import numpy as np

TOLERANCE, FLAT, ROUNDING = 5e-4, 3e-4, 1e-9
"""As in the simulator: added to the margin [m], of one surface (share of an inverse range), rounding errors."""
HALVINGS, SPACING, REST, LONGEST = 7, 0.02, 2e-5, 10_000
"""Of the speed; farthest places on a way [m]; who goes no farther in a period stands [m]; periods of a stop at most."""
AXES = {"diff": [0, 2], "omni": [0, 1], "omni_angular": [0, 1, 2]}
"""Where the components of a command stand among the velocity ahead, to the left [m/s] and the turn rate [rad/s]."""


class Shield:
    """The shield of one robot, by ``shield``, ``robot`` and ``period`` of contract.json."""

    def __init__(self, contract: dict[str, Any]) -> None:
        self.form, robot, self.period = contract["shield"], contract["robot"], contract["period"]
        self.axes, self.limits, self.sent = AXES[robot["drive"]], np.full(3, np.inf), [np.zeros(3)]
        self.limits[self.axes] = [np.inf if one is None else one for one in robot["acceleration"]]

    def slowed(self, driver: Any, command: Any) -> tuple[Any, str]:
        """Return a command, or the fastest one of its sort after which the robot can stop, and why it is another one.

        It keeps its turn rate where the robot may turn on the spot, else its arc.
        """
        (twist, self.velocity), (msg, ranges, lost, velocity) = np.zeros((2, 3)), driver.seen
        twist[self.axes], self.velocity[self.axes] = command, velocity[0]
        self.walls = walls_of(msg, ranges, lost, driver.mount, self.form["radius"])
        self.delay = self.form["latency"] + driver.now - driver.scan_time
        half = 0.5 * (len(ranges) - 1) * msg.angle_increment
        off = np.arctan2(twist[1], twist[0]) - driver.mount[2] - msg.angle_min - half
        looks = abs(np.remainder(off + np.pi, 2.0 * np.pi) - np.pi) <= abs(half) + ROUNDING or not twist[:2].any()
        shares = np.ones(3)
        if not (looks and self._stops(twist)):
            turns, low, high = float(self._stops(twist * [0.0, 0.0, 1.0])), 0.0, 1.0
            for _ in range(HALVINGS if looks else 0):
                share = 0.5 * (low + high)
                stops = self._stops(twist * [share, share, max(turns, share)])
                low, high = (share, high) if stops else (low, share)
            shares = np.array([low, low, max(turns, low)])
        self.sent = [*self.sent[-99:], twist * shares]
        if "pending" in driver.states:
            driver.states["pending"][0, -1] = command * shares[self.axes]
        return command * shares[self.axes], "slowed by stop_in_time" if np.any(twist * shares != twist) else ""

    def _stops(self, twist: Any) -> bool:
        """Return whether the robot can stop after a command."""
        way, most = self._way(twist), self.form["margin"] + TOLERANCE
        gaps = _distances(np.zeros(1), self.walls)[0] - self.form["radius"]
        near = gaps < np.abs(way).max() + most
        least = self.form["radius"] + np.minimum(gaps, most)[near] - ROUNDING
        return bool((_distances(way, self.walls[:, near]) >= least).all())

    def _way(self, twist: Any) -> Any:
        """Return places on the way of a command, with turns after each period and halfway.

        The first is how the simulator drives; a real arc lies between the two.
        """
        n, lag, now = int(np.ceil(self.delay / self.period - 1e-9)), self.form["lag"], self.velocity
        asked = [*[np.zeros(3)] * (n - len(self.sent)), *(self.sent[-n:] if n else ()), twist]
        places, turn = [np.zeros((1, 2), complex)], 0.0
        for k in range(n + LONGEST):
            span = self.delay - (n - 1) * self.period if k == 0 < n else self.period
            share, change = 1.0 - np.exp(-span / lag) if lag else 1.0, self.limits * span
            now = np.clip(now + ((asked[k] if k <= n else 0.0) - now) * share, now - change, now + change)
            step = complex(now[0], now[1]) * span
            if k > n and abs(step) < REST * share:
                return np.concatenate(places)
            parts = np.arange(1, int(abs(step) / SPACING) + 2)[:, None]
            far = step * np.exp(1j * (turn + np.array([0.0, 0.5]) * now[2] * span))
            places.append(places[-1][-1] + parts / len(parts) * far)
            turn += now[2] * span
        return np.full((1, 2), np.inf)  # it never stands


def walls_of(msg: Any, ranges: Any, lost: Any, mount: Any, radius: float) -> Any:
    """Return the lines that a scan shows to the robot, (2, n), as complex numbers [m].

    Neighbouring beams are joined, without those that are lost. The surface that a beam has hit may go on up to the next
    beam, as it did before: two lines to there, on either side.
    """
    step = float(msg.angle_increment)
    near = 1.0 / np.clip(ranges, max(msg.range_min, 1e-3), msg.range_max)
    eye, looks = complex(mount[0], mount[1]), np.exp(1j * (msg.angle_min + mount[2] + step * np.arange(len(near))))
    on, back, hits = _going_on(near, step)[:-1], _going_on(near[::-1], step)[::-1][1:], near * msg.range_max > 1.0001
    tips = eye + np.array(
        [looks[1:] / np.where(hits[:-1], on, near[1:]), looks[:-1] / np.where(hits[1:], back, near[:-1])]
    )
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


def _distances(places: Any, walls: Any) -> Any:
    """Return how far places (..) are from lines (2, w), all complex numbers: (.., w)."""
    along, away = walls[1] - walls[0], places[..., None] - walls[0]
    share = (away * along.conj()).real / np.maximum(np.abs(along) ** 2, 1e-18)
    return np.abs(away - np.clip(share, 0.0, 1.0) * along)
