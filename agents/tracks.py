"""Follows what moves in a robot's scans, with NumPy alone: a tracker for ``Driver.bodies`` of an exported policy.

    tracks = Tracks(contract["scan"], contract["period"])
    driver.bodies(tracks.rows(driver.ranges[0], driver.pose[0]), stamp)  # once for each scan

Each step is that of the simulator's tracker: neighbouring points of a scan form clusters, clusters of successive scans
tracks, and a track counts once scans have shown that it moves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
LARGEST, STRAIGHT = 0.35, 0.02
"""Radius of discs whose points are joined, and how near to a line four points are joined for it [m]."""
ANCHOR, SMALLEST, WIDEST, DRIFT, ROUNDS, NEAR_ENOUGH = 1.0 / 0.3**2, 0.05, 0.6, 0.005**2, 3, 1e-4**2
"""Of a fit: weight of the expected centre, bounds of the radius, growth of its variance, rounds, last step squared."""
GATE, SHIFT, MARGIN, EDGE, SLOWEST, VAGUE, UNSURE = 0.35, 0.3, 0.1, 0.6, 0.1, 0.02, 0.002
"""How far a cluster may be from its track; of the judgement whether a track moves, see the simulator [m, m/s, m2]."""
RADIUS, SPREAD, PACE, SLOTS, PROOFS, MOST_PROOFS = 0.3, 0.1, 1.0, 32, 2, 6
"""Of new tracks: radius and deviations of radius and speed; how many there are; scans that show that one moves."""
SERIES = (
    0.0028662257,
    -0.0161657367,
    0.0429096138,
    -0.0752896400,
    0.1065626393,
    -0.1420889944,
    0.1999355085,
    -0.3333314528,
)
"""Of the arctangent, from the highest power of the squared ratio on."""
NUMBERS = ("x", "y", "vx", "vy", "begin_x", "begin_y", "radius", "spread", "place", "both", "speed", "lost")
"""Of a track: centre, velocity, where it began, radius, variances of radius, place and speed, time unseen."""


class Tracks:
    """The tracks of one robot: what the observation ``tracks`` shows in the simulator.

    Args:
        scan: ``scan`` of contract.json.
        step: Time from one scan to the next [s].
        size: Wider clusters of points stand [m].
        accel: Deviation of the bodies' accelerations [m/s2].
        keep: How long a body is followed that is no longer seen [s].
        noise: Standard deviation of the readings [m].
    """

    def __init__(
        self,
        scan: dict[str, Any],
        step: float,
        size: float = 1.2,
        accel: float = 1.5,
        keep: float = 1.0,
        noise: float = 0.0,
    ) -> None:
        self.dt, self.size, self.accel, self.keep, self.noise = step, size, accel, keep, noise
        self.variance = UNSURE * UNSURE + noise * noise
        self.least, self.most, self.mount = np.float32(scan["range_min"]), np.float32(scan["range_max"]), scan["mount"]
        self.spacing, self.n = float(scan["step"]) or 1.0, int(scan["beams"])
        self.closes, self.first = self.spacing * (self.n + 0.5) > 2.0 * np.pi, scan["first"] + self.mount[2]
        angles = scan["first"] + scan["step"] * np.arange(self.n) + self.mount[2]
        self.beams_x, self.beams_y = np.cos(angles), np.sin(angles)
        self.kept = math.ceil(1.0 / self.dt) + 1
        self.scans, self.eyes = np.zeros((self.kept, self.n), np.float32), np.zeros((self.kept, 3))
        self.forget()

    def forget(self) -> None:
        """Begin without tracks."""
        self.n_scans = 0
        self.of = {name: np.zeros(SLOTS) for name in NUMBERS}
        self.score, self.used = np.zeros(SLOTS, np.int64), np.zeros(SLOTS, np.bool_)

    def rows(self, ranges: Array, pose: Array) -> Array:
        """Take a scan, and return what moves, as rows of x, y, vx, vy, radius in the frame of the pose, ``(32, 5)``.

        Rows of NaN are absent.

        Args:
            ranges: The scan as the scanner reports it [m], see REP 117, ``(n_beams,)``, float32.
            pose: The robot's pose [m, m, rad].
        """
        self._follow(np.clip(np.where(np.isnan(ranges), self.most, ranges), np.float32(0.0), self.most), pose)
        self.n_scans += 1
        moves = self.used & (self.score >= PROOFS)
        return np.where(moves[:, None], np.stack([self.of[k] for k in ("x", "y", "vx", "vy", "radius")], 1), np.nan)

    def _follow(self, ranges: Array, pose: Array) -> None:
        """Predict the tracks, match them with clusters, correct them, and begin and end some."""
        row, cosine, sine = self.n_scans % self.kept, math.cos(pose[2]), math.sin(pose[2])
        x = float(pose[0]) + cosine * self.mount[0] - sine * self.mount[1]
        y = float(pose[1]) + sine * self.mount[0] + cosine * self.mount[1]
        self.eyes[row], scan = (x, y, pose[2]), self.scans[row]
        scan[:] = ranges
        far = scan.astype(np.float64)
        ends_x = x + far * (cosine * self.beams_x - sine * self.beams_y)
        ends_y = y + far * (sine * self.beams_x + cosine * self.beams_y)
        same, inverse = _joined(scan, self.least, self.most, self.spacing, self.noise, self.closes)
        _mend(scan, same, inverse, self.spacing, self.noise)
        clusters = self._clusters(same, inverse > 0.0, ends_x, ends_y)
        away = [np.array([0.5 * (p[k].min() + p[k].max()) for p in clusters]) for k in (0, 1)]
        behind = 0.6 * RADIUS / np.maximum(np.hypot(away[0] - x, away[1] - y), 1e-9)
        middles = np.stack([away[0] + behind * (away[0] - x), away[1] + behind * (away[1] - y)], 1)
        matched, free, clusters, middles = self._match(clusters, middles)
        used, before = np.flatnonzero(self.used), self.of
        seen, lost = used[matched[used] >= 0], used[matched[used] < 0]
        chosen = [clusters[c] for c in (*matched[seen], *free)]
        if chosen:
            wide, vague = np.full(len(free), RADIUS), np.full(len(free), SPREAD * SPREAD)
            expected = [*middles[free].T, wide, vague]
            names = ("x", "y", "radius", "spread")
            start = [np.append(before[name][seen], new) for name, new in zip(names, expected)]  # noqa: B905
            discs = _discs(chosen, *start, self.variance)
            self._measure(seen, discs[:, : len(seen)], np.array([len(c[0]) == 1 for c in chosen[: len(seen)]]), row)
            self._judge(seen, chosen[: len(seen)])
        self._miss(lost)
        if free:
            self._begin(discs[:, len(seen) :], middles[free])

    def _clusters(self, same: Array, hits: Array, x: Array, y: Array) -> list[Array]:
        """Return the points of the clusters that are not too wide, each ``(2, n)`` [m]."""
        breaks = np.flatnonzero(same[:-1] == 0.0)
        order = np.roll(np.arange(self.n), -int(breaks[0] if len(breaks) else self.n - 1))
        starts, hit = np.flatnonzero((same[order] == 0.0) | (np.arange(self.n) == 0)), hits[order]
        sizes = []
        for ends in (x[order], y[order]):
            low = np.minimum.reduceat(np.where(hit, ends, np.inf), starts)
            sizes.append(np.maximum.reduceat(np.where(hit, ends, -np.inf), starts) - low)
        small = hit[starts] & (np.maximum(*sizes) <= self.size)
        points, stops = np.stack([x[order], y[order]]), np.append(starts[1:], self.n)
        return [points[:, a:b][:, hit[a:b]] for a, b in zip(starts[small], stops[small])]  # noqa: B905

    def _match(self, clusters: list[Array], middles: Array) -> tuple[Array, list[int], list[Array], Array]:
        """Move the tracks on, and return the number of each one's cluster, or -1, those of none, clusters and middles.

        What moves claims its cluster first; a cluster of two moving tracks is parted.
        """
        of, matched, owners = self.of, np.full(SLOTS, -1), [-1] * len(clusters)
        of["x"], of["y"] = of["x"] + of["vx"] * self.dt, of["y"] + of["vy"] * self.dt
        of["speed"] = of["speed"] + (self.accel * self.dt) ** 2
        of["place"] = of["place"] + self.dt * (2.0 * of["both"] + self.dt * of["speed"])
        of["both"] = of["both"] + self.dt * of["speed"]
        gates = (GATE + 2.0 * np.sqrt(np.maximum(of["place"], 0.0))) ** 2
        for t in np.flatnonzero(self.used):
            away = (of["x"][t] - middles[:, 0]) ** 2 + (of["y"][t] - middles[:, 1]) ** 2
            c = int(away.argmin()) if len(away) else -1
            matched[t] = c = c if c >= 0 and away[c] < gates[t] else -1
            if self.score[t] < PROOFS or c < 0:
                continue
            if owners[c] < 0:
                owners[c] = t
                continue
            other, points = owners[c], clusters[c]
            edges = [
                np.abs(np.hypot(points[0] - of["x"][k], points[1] - of["y"][k]) - of["radius"][k]) for k in (t, other)
            ]
            matched[t], nearer = -1, edges[0] < edges[1]
            order, middle = _parted(nearer)
            if nearer.any() and len(clusters) < self.n:
                matched[t] = len(clusters)
                clusters.append(points[:, order[middle:]])
                owners.append(t)
                middles = np.append(middles, [[of["x"][t], of["y"][t]]], 0)
                clusters[c] = points[:, order[:middle]]
            if middle == 0:
                matched[other] = -1
        for t in np.flatnonzero(self.used & (self.score < PROOFS) & (matched >= 0)):
            if owners[matched[t]] >= 0:
                matched[t] = -1
            else:
                owners[matched[t]] = t
        return matched, [c for c, owner in enumerate(owners) if owner < 0], clusters, middles

    def _measure(self, t: Array, discs: Array, single: Array, row: int) -> None:
        """Correct tracks by the discs through their clusters: a Kalman filter, the same for both coordinates."""
        of, (x, y, radius, spread, doubt) = {name: values[t] for name, values in self.of.items()}, discs
        dx, dy = x - self.eyes[row, 0], y - self.eyes[row, 1]
        away = np.maximum(np.sqrt(dx * dx + dy * dy), 1e-9)
        doubt = doubt + np.where(single, (0.3 * self.spacing * away) ** 2, 0.0)
        grown = (radius - of["radius"]) / away
        gain, rate = of["place"] / (of["place"] + doubt), of["both"] / (of["place"] + doubt)
        for name, step, end in (("x", grown * dx, x), ("y", grown * dy, y)):
            off = end - (of[name] + step)
            self.of["begin_" + name][t] += step
            self.of[name][t] = of[name] + step + gain * off
            self.of["v" + name][t] += rate * off
        self.of["radius"][t], self.of["spread"][t], self.of["lost"][t] = radius, spread, 0.0
        self.of["speed"][t] -= rate * of["both"]
        self.of["place"][t], self.of["both"][t] = (1.0 - gain) * of["place"], (1.0 - gain) * of["both"]

    def _judge(self, t: Array, clusters: list[Array]) -> None:
        """Count the scans that show that tracks move: they are where there was free space, or have left free places."""
        several = np.array([points.shape[1] > 1 for points in clusters], np.bool_)
        asked = several & (self.score[t] <= MOST_PROOFS)
        t, spots = t[asked], [points[:, [0, len(points[0]) // 2, -1]] for points in clusters if len(points[0]) > 1]
        if not len(t):
            return
        x, y = np.stack([spot for spot, is_asked in zip(spots, asked[several]) if is_asked], 2)  # noqa: B905
        of = {name: values[t] for name, values in self.of.items()}
        pace = np.sqrt(of["vx"] * of["vx"] + of["vy"] * of["vy"])
        doubtful = (pace < SLOWEST) | (of["place"] > VAGUE) | (of["radius"] >= WIDEST)
        back = np.maximum((SHIFT / (np.maximum(pace, 1e-9) * self.dt) + 0.5).astype(np.int64), 1)
        back = np.minimum(np.minimum(back, self.n_scans), self.kept - 1)
        ago = np.stack([back, (back + 1) // 2])
        left_x, left_y = x[1] - ago * self.dt * of["vx"], y[1] - ago * self.dt * of["vy"]
        was, now = self._look(ago, left_x, left_y), self._look(0 * ago, left_x, left_y)
        moves = (self._look(ago[:, None], x, y) > 0.0).any(axis=(0, 1))
        moves |= ((now > 0.0) & (was > -2.0 * MARGIN) & (was < 0.0)).any(axis=0)
        score = np.where(
            moves & ~doubtful, np.minimum(self.score[t] + 1, MOST_PROOFS), np.maximum(self.score[t] - 1, 0)
        )
        left = (of["x"] - of["begin_x"]) ** 2 + (of["y"] - of["begin_y"]) ** 2 > SHIFT * SHIFT
        self.score[t] = np.where(~doubtful & (score >= PROOFS) & left, MOST_PROOFS + 1, score)

    def _miss(self, t: Array) -> None:
        """Count the time for which tracks have not been seen, three times where beams pass through them."""
        known = self.score[t] >= PROOFS
        passed = (
            self._look(np.zeros(len(t), np.int64), self.of["x"][t], self.of["y"][t]) > MARGIN - self.of["radius"][t]
        )
        self.of["lost"][t] += np.where(known & passed, 3.0 * self.dt, self.dt)
        self.used[t] = self.of["lost"][t] < np.where(known, self.keep, 2.5 * self.dt)

    def _look(self, ago: Array, x: Array, y: Array) -> Array:
        """Return how far beyond points, and a margin, both beams beside them reached some steps ago; -9 without any."""
        row = (self.n_scans - ago) % self.kept
        dx, dy = x - self.eyes[row, 0], y - self.eyes[row, 1]
        place = np.remainder(_angle(dy, dx) - self.eyes[row, 2] - self.first, 2.0 * np.pi)
        first, away = (place / self.spacing).astype(np.int64), np.sqrt(dx * dx + dy * dy)
        k = np.minimum(first, self.n - 2)
        reach = np.minimum(np.abs(self.scans[row, k]), np.abs(self.scans[row, k + 1])).astype(np.float64)
        margin = MARGIN + EDGE * away * self.spacing + 3.0 * self.noise
        return np.where(first < self.n - 1, reach - away - margin, -9.0)

    def _begin(self, discs: Array, middles: Array) -> None:
        """Begin tracks at clusters, unless a body that is known to move is there, or all places are taken."""
        moving = np.flatnonzero(self.used & (self.score >= PROOFS))
        reach = (self.of["radius"][moving] + MARGIN) ** 2
        away = [(middles[:, k, None] - self.of[name][moving]) ** 2 for k, name in enumerate("xy")]
        chosen = np.flatnonzero(~(away[0] + away[1] < reach).any(axis=1))
        slots = np.flatnonzero(~self.used)[::-1][: len(chosen)]
        x, y, radius, spread, doubt = discs[:, chosen[: len(slots)]]
        values = (x, y, 0.0, 0.0, x, y, radius, spread, doubt, 0.0, PACE * PACE, 0.0)
        for name, value in zip(NUMBERS, values):  # noqa: B905
            self.of[name][slots] = value
        self.score[slots], self.used[slots] = 0, True


def _angle(y: Array, x: Array) -> Array:
    """Return angles as the simulator has them, to 2e-8 rad: seen from where they were hit, points lie right on beams.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
    """
    across, up = np.abs(x), np.abs(y)
    ratio = np.minimum(across, up) / np.maximum(np.maximum(across, up), 1e-300)
    angle = ratio + ratio * (ratio * ratio * np.polyval(SERIES, ratio * ratio))
    angle = np.where(up > across, 0.5 * np.pi - angle, angle)
    return np.copysign(np.where(x < 0.0, np.pi - angle, angle), y)


def _parted(flags: Array) -> tuple[list[int], int]:
    """Return an order in which what is flagged comes last, and where it begins: that of the simulator's kernel."""
    order, k, middle = list(range(len(flags))), 0, len(flags)
    while k < middle:
        if flags[order[k]]:
            middle -= 1
            order[k], order[middle] = order[middle], order[k]
        else:
            k += 1
    return order, middle


def _joined(ranges: Array, least: Any, most: Any, spacing: float, noise: float, closes: bool) -> tuple[Array, Array]:
    """Return whether each beam hits the same surface as the one before it, and inverse readings; 0 without a hit."""
    valid, yes = (least < ranges) & (ranges < most), np.float32(1.0)
    inverse = np.divide(yes, ranges, out=np.zeros_like(ranges), where=valid)
    if len(ranges) < 4:
        return np.zeros_like(ranges), inverse
    bend, slack = np.float32(2.0 * math.cos(spacing)), np.float32(2.0 * STRAIGHT + 4.0 * noise)
    before, now, after = inverse[:-2], inverse[1:-1], inverse[2:]
    off = np.abs(before + after - bend * now)
    flat = np.pad((off <= slack * now * now) & (before > 0.0) & (after > 0.0), 1)
    last = np.roll(ranges, 1)
    jump = np.maximum(np.abs(ranges - last) - np.float32(3.0 * noise), np.float32(0.0))
    near = jump * jump <= np.float32(2.0 * LARGEST * spacing) * np.minimum(last, ranges)
    same = near & valid & np.roll(valid, 1)
    same[2:-1] |= (flat[1:-2] & (flat[:-3] | flat[2:-1])) | (flat[2:-1] & flat[3:])
    same[0] &= closes
    return same.astype(np.float32), inverse


def _mend(ranges: Array, same: Array, inverse: Array, spacing: float, noise: float) -> None:
    """Bridge gaps of one or two beams without a hit, unless the edges on both sides recede: they were lost."""
    hits = inverse > 0.0
    for i in np.flatnonzero(hits[3:] & ~hits[2:-1] & (hits[1:-2] | hits[:-3])) + 3:
        last = i - 2 if hits[i - 2] else i - 3
        ahead, behind = (last - 1) % len(ranges), (i + 1) % len(ranges)
        one, other = ranges[last], ranges[i]
        recede = float(one - ranges[ahead]) > float(ranges[behind] - other) + 4.0 * noise
        if not (hits[ahead] and hits[behind] and recede):
            near = float((other - one) * (other - one)) <= 2.0 * LARGEST * spacing * (i - last) * float(min(one, other))
            ranges[last + 1 : i], same[last + 1 : i + 1] = -min(one, other), near


def _discs(clusters: list[Array], x: Array, y: Array, radius: Array, spread: Array, noise: float) -> Array:
    """Return the discs whose edges are nearest to the points of clusters.

    They are rows of x, y, radius and the variances of radius and place, ``(5, n)``.

    Args:
        clusters: Points [m], each ``(2, n)``.
        x: Where the centres are expected [m]; y and radius likewise.
        y: As ``x``.
        radius: As ``x``.
        spread: Variance of the radii [m2].
        noise: Variance of the points [m2].
    """
    count = np.array([points.shape[1] for points in clusters])
    points, there = np.zeros((2, len(count), count.max())), np.arange(count.max()) < count[:, None]
    points[:, there] = np.concatenate(clusters, axis=1)
    cx, cy, r, open_, weight = x.copy(), y.copy(), radius.copy(), np.ones(len(count), np.bool_), 1.0 / noise
    misfit, left = np.zeros(len(count)), np.zeros(len(count))
    rr = 1.0 / spread + weight * count
    for _ in range(ROUNDS):
        dx, dy = cx[:, None] - points[0], cy[:, None] - points[1]
        away = np.maximum(np.sqrt(dx * dx + dy * dy), 1e-9)
        ux, uy, off = dx / away * there, dy / away * there, (away - r[:, None]) * there
        xx, yy = ANCHOR + weight * (ux * ux).sum(1), ANCHOR + weight * (uy * uy).sum(1)
        xy, bx, by = weight * (ux * uy).sum(1), -weight * ux.sum(1), -weight * uy.sum(1)
        gx = ANCHOR * (cx - x) + weight * (ux * off).sum(1)
        gy = ANCHOR * (cy - y) + weight * (uy * off).sum(1)
        gr = (r - radius) / spread - weight * off.sum(1)
        misfit = np.where(open_, (off * off).sum(1), misfit)
        xx, xy, yy = xx - bx * bx / rr, xy - bx * by / rr, yy - by * by / rr
        hx, hy, whole = gx - bx * gr / rr, gy - by * gr / rr, xx * yy - xy * xy
        sx, sy = (yy * hx - xy * hy) / whole, (xx * hy - xy * hx) / whole
        cx, cy = np.where(open_, cx - sx, cx), np.where(open_, cy - sy, cy)
        r = np.where(open_, np.clip(r - (gr - bx * sx - by * sy) / rr, SMALLEST, WIDEST), r)
        variance = 1.0 / rr + (bx * bx * yy - 2.0 * bx * by * xy + by * by * xx) / (whole * rr * rr)
        left, open_ = np.where(open_, variance, left), open_ & (sx * sx + sy * sy >= NEAR_ENOUGH)
    doubt = noise + misfit / count
    return np.stack([cx, cy, r, np.minimum(left * doubt / noise, spread) + DRIFT, doubt])
