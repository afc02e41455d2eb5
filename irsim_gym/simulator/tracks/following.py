"""How tracks follow bodies from scan to scan."""

from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.simulator.geometry.angles import TURN, nearly_arctan2, wrap
from irsim_gym.simulator.tracks.clusters import WIDEST, find_clusters, fit_disc, join_beams, mend
from irsim_gym.simulator.tracks.tracker import PROOFS, Tracker

GATE = 0.35
"""How far a cluster may be from where a track is expected, beside twice the deviation of that [m]."""
SHIFT = 0.3
"""How far something has to move before scans are compared [m]."""
MARGIN = 0.1
"""How much deeper than a disc's front a beam must reach for the place to count as free [m]."""
EDGE = 0.6
"""... and besides, as a share of the way between two beams there: an edge may stand out between them."""
MOST_PROOFS = 6
"""As many count; each scan that does not show it takes one away."""
SLOWEST = 0.1
"""What is slower than this stands [m/s]."""
VAGUE = 0.02
"""Variance of a place [m2] above which a cluster is no disc that could be seen to move."""
UNSURE = 0.002
"""Deviation of readings without noise, and of discs from what bodies are [m]."""
RADIUS, SPREAD, PACE = 0.3, 0.1, 1.0
"""Radius [m], its deviation [m] and the deviation of each component of the velocity [m/s] of a new track."""


class Moment(NamedTuple):
    """Whose scan is followed: world, member, its step, slot of scratch memory, and how long a step takes [s]."""

    w: int
    a: int
    step: int
    slot: int
    dt: float


@kernel
def follow_scan(at: Moment, pose: Floats, tracker: Tracker) -> None:
    """Bring the tracks up to the latest scan, unless they are.

    Reads: tracker (accel, closes, clusters, eyes, joined, keep, limits, noise, noted, points, scan, scans, size,
        spacing, tracks).
    Writes: tracker (clusters, eyes, joined, noted, points, scans, tracks).

    Args:
        at: Whose scan it is.
        pose: Where its body is [m, m, rad].
        tracker: The tracks.
    """
    if at.step != tracker.noted[at.w, at.a] and tracker.scan.ranges.shape[2] > 0:
        note_scan(at, pose, tracker)
        follow(at, tracker)
        tracker.noted[at.w, at.a] = at.step


@kernel
def note_scan(at: Moment, pose: Floats, tracker: Tracker) -> None:
    """Keep a scan and the sensor's pose, and write where its beams end.

    Reads: tracker (scan).
    Writes: tracker (eyes, points, scans).
    """
    scan, s, row = tracker.scan, tracker.scan.sensors[at.a], at.step % tracker.scans.shape[2]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * scan.offset[s, 0] - sine * scan.offset[s, 1]
    y = pose[1] + sine * scan.offset[s, 0] + cosine * scan.offset[s, 1]
    eye, ends, kept = tracker.eyes[at.w, at.a, row], tracker.points[at.slot, 0], tracker.scans[at.w, at.a, row]
    eye[0], eye[1], eye[2] = x, y, pose[2]
    for i in range(kept.shape[0]):
        reading, ahead, left = scan.ranges[at.w, s, i], scan.beams_x[s, i], scan.beams_y[s, i]
        kept[i] = reading
        ends[0, i] = x + reading * (cosine * ahead - sine * left)
        ends[1, i] = y + reading * (sine * ahead + cosine * left)


@kernel
def follow(at: Moment, tracker: Tracker) -> None:
    """Predict the tracks, match them with the clusters of the latest scan, correct them, and begin and end some.

    Reads: tracker (accel, closes, clusters, eyes, joined, keep, limits, noise, points, scan, scans, size, spacing,
        tracks).
    Writes: tracker (clusters, joined, points, scans, tracks).
    """
    row, joined = at.step % tracker.scans.shape[2], tracker.joined[at.slot]
    ranges, eye, kept = tracker.scans[at.w, at.a, row], tracker.eyes[at.w, at.a, row], tracker.points[at.slot, 1]
    tracks, clusters = tracker.tracks[at.w, at.a], tracker.clusters[at.slot]
    join_beams(ranges, tracker.limits[at.a], tracker.spacing, tracker.noise[at.a], tracker.closes, joined)
    mend(ranges, tracker.spacing, tracker.noise[at.a], joined)
    count = find_clusters(tracker.size, joined, tracker.points[at.slot], clusters)
    push_back(eye, clusters, count)
    for t in range(tracks.shape[0]):
        if tracks[t].used:
            predict(tracks[t], at.dt, tracker.accel)
            tracks[t].cluster = nearest_cluster(tracks[t], clusters, count)
            if tracks[t].score >= PROOFS and tracks[t].cluster >= 0:
                count = claim(at, t, count, tracker)
    for t in range(tracks.shape[0]):
        track = tracks[t]
        if track.used and track.score < PROOFS and track.cluster >= 0:
            if clusters[track.cluster].track >= 0:
                track.cluster = -1
            else:
                clusters[track.cluster].track = t
        if track.used and track.cluster >= 0:
            points = kept[:, clusters[track.cluster].first : clusters[track.cluster].last]
            measure(at, track, points, tracker)
            judge(at, track, points, tracker)
        elif track.used:
            miss(at, track, tracker)
    for c in range(count):
        if clusters[c].track < 0:
            begin(at, clusters[c], kept[:, clusters[c].first : clusters[c].last], tracker)


@kernel
def push_back(eye: Floats, clusters: Records, count: int) -> None:
    """Move the middles of clusters to where the bodies behind them may have their centres."""
    for c in range(count):
        dx, dy = clusters[c].x - eye[0], clusters[c].y - eye[1]
        behind = 0.6 * RADIUS / max(np.sqrt(dx * dx + dy * dy), 1e-9)
        clusters[c].x, clusters[c].y = clusters[c].x + behind * dx, clusters[c].y + behind * dy


@kernel
def predict(one: Any, dt: float, accel: float) -> None:
    """Move a track on; its velocity may have changed at once."""
    one.x, one.y = one.x + one.vx * dt, one.y + one.vy * dt
    one.speed += (accel * dt) ** 2
    one.place += dt * (2.0 * one.both + dt * one.speed)
    one.both += dt * one.speed


@kernel
def nearest_cluster(one: Any, clusters: Records, count: int) -> int:
    """Return the cluster nearest to a track, -1 if all are too far away."""
    least, found = (GATE + 2.0 * np.sqrt(one.place)) ** 2, -1
    for c in range(count):
        dx, dy = one.x - clusters[c].x, one.y - clusters[c].y
        if dx * dx + dy * dy < least:
            least, found = dx * dx + dy * dy, c
    return found


@kernel
def claim(at: Moment, t: int, count: int, tracker: Tracker) -> int:
    """Give a moving track its nearest cluster, and return the number of clusters.

    Of a cluster that another one has claimed it gets the points that are nearer to its own edge, as a new cluster.

    Reads: tracker (clusters, points, tracks).
    Writes: tracker (clusters, points, tracks).
    """
    tracks, clusters, points = tracker.tracks[at.w, at.a], tracker.clusters[at.slot], tracker.points[at.slot, 1]
    whole = clusters[tracks[t].cluster]
    if whole.track < 0:
        whole.track = t
        return count
    middle = whole.last
    k, other = whole.first, tracks[whole.track]
    while k < middle:
        if from_edge(tracks[t], points, k) < from_edge(other, points, k):
            middle -= 1
            for axis in range(2):
                points[axis, k], points[axis, middle] = points[axis, middle], points[axis, k]
        else:
            k += 1
    tracks[t].cluster = -1
    if middle < whole.last and count < clusters.shape[0]:
        part = clusters[count]
        part.x, part.y, part.first, part.last, part.track = tracks[t].x, tracks[t].y, middle, whole.last, t
        whole.last, tracks[t].cluster = middle, count
        count += 1
    if whole.first == whole.last:
        other.cluster = -1
    return count


@kernel
def from_edge(one: Any, points: Floats, k: int) -> float:
    """Return the distance of a point from the edge of a track's disc [m]."""
    dx, dy = points[0, k] - one.x, points[1, k] - one.y
    return float(abs(np.sqrt(dx * dx + dy * dy) - one.radius))


@kernel
def measure(at: Moment, one: Any, points: Floats, tracker: Tracker) -> None:
    """Correct a track by the disc through its cluster: a Kalman filter, the same for both coordinates.

    Reads: tracker (eyes, noise, spacing).
    Writes: one.
    """
    eye = tracker.eyes[at.w, at.a, at.step % tracker.eyes.shape[2]]
    noise = UNSURE * UNSURE + tracker.noise[at.a] ** 2
    x, y, radius, spread, doubt = fit_disc(points, one.x, one.y, one.radius, one.spread, noise)
    dx, dy = x - eye[0], y - eye[1]
    away = max(np.sqrt(dx * dx + dy * dy), 1e-9)
    if points.shape[1] == 1:
        doubt += (0.3 * tracker.spacing * away) ** 2
    # A centre that was found with another radius would have lain as much farther, or nearer.
    grown = (radius - one.radius) / away
    one.x, one.y, one.radius, one.spread = one.x + grown * dx, one.y + grown * dy, radius, spread
    one.begin_x, one.begin_y = one.begin_x + grown * dx, one.begin_y + grown * dy
    gain, rate = one.place / (one.place + doubt), one.both / (one.place + doubt)
    off_x, off_y = x - one.x, y - one.y
    one.x, one.y = one.x + gain * off_x, one.y + gain * off_y
    one.vx, one.vy = one.vx + rate * off_x, one.vy + rate * off_y
    one.speed -= rate * one.both
    one.place, one.both, one.lost = (1.0 - gain) * one.place, (1.0 - gain) * one.both, 0.0


@kernel
def miss(at: Moment, one: Any, tracker: Tracker) -> None:
    """Count the time for which a track has not been seen, three times where beams pass through it; drop it in the end.

    Reads: tracker (eyes, keep, noise, scan, scans, spacing).
    Writes: one.
    """
    is_known = one.score >= PROOFS
    is_gone = is_known and look(at, 0, one.x, one.y, tracker) > MARGIN - one.radius
    one.lost += 3.0 * at.dt if is_gone else at.dt
    one.used = one.lost < (tracker.keep if is_known else 2.5 * at.dt)


@kernel
def look(at: Moment, ago: int, x: float, y: float, tracker: Tracker) -> float:
    """Return how far beyond a point, and a margin, both beams beside it reached some steps ago [m]; -9 without beams.

    Reads: tracker (eyes, noise, scan, scans, spacing).
    """
    row, s = (at.step - ago) % tracker.scans.shape[2], tracker.scan.sensors[at.a]
    eye, ranges = tracker.eyes[at.w, at.a, row], tracker.scans[at.w, at.a, row]
    dx, dy = x - eye[0], y - eye[1]
    place = wrap(nearly_arctan2(dy, dx) - eye[2] - tracker.scan.angles[s, 0])
    first = int((place if place >= 0.0 else place + TURN) / tracker.spacing)
    if not 0 <= first < ranges.shape[0] - 1:
        return -9.0
    away = np.sqrt(dx * dx + dy * dy)
    margin = MARGIN + EDGE * away * tracker.spacing + 3.0 * tracker.noise[at.a]
    return float(min(abs(ranges[first]), abs(ranges[first + 1])) - away - margin)


@kernel
def judge(at: Moment, one: Any, points: Floats, tracker: Tracker) -> None:
    """Count the scans that show that a track moves: it is where there was free space, or has left a place that is free.

    A moving track that has left its beginning is not judged again. What is as wide as a disc can be is part of a wall.
    The points are those of its cluster, ``(2, n)``.

    Reads: tracker (eyes, noise, scan, scans, spacing).
    Writes: one.
    """
    if one.score > MOST_PROOFS or points.shape[1] == 1:
        return
    pace = np.sqrt(one.vx * one.vx + one.vy * one.vy)
    if pace < SLOWEST or one.place > VAGUE or one.radius >= WIDEST:
        one.score = max(one.score - 1, 0)
        return
    middle, last = points.shape[1] // 2, points.shape[1] - 1
    back = min(max(int(SHIFT / (pace * at.dt) + 0.5), 1), at.step, tracker.scans.shape[2] - 1)
    moves = False
    for ago in (back, (back + 1) // 2):
        for k in (0, middle, last):
            moves = moves or look(at, ago, points[0, k], points[1, k], tracker) > 0.0
        x, y = points[0, middle] - ago * at.dt * one.vx, points[1, middle] - ago * at.dt * one.vy
        was = look(at, ago, x, y, tracker)
        moves = moves or (look(at, 0, x, y, tracker) > 0.0 and -2.0 * MARGIN < was < 0.0)
    one.score = min(one.score + 1, MOST_PROOFS) if moves else max(one.score - 1, 0)
    dx, dy = one.x - one.begin_x, one.y - one.begin_y
    if one.score >= PROOFS and dx * dx + dy * dy > SHIFT * SHIFT:
        one.score = MOST_PROOFS + 1


@kernel
def begin(at: Moment, cluster: Any, points: Floats, tracker: Tracker) -> None:
    """Begin a track at a cluster, unless a body that is known to move is there, or all places are taken.

    Reads: tracker (noise, tracks).
    Writes: tracker (tracks).
    """
    free, tracks = -1, tracker.tracks[at.w, at.a]
    for t in range(tracks.shape[0]):
        dx, dy = tracks[t].x - cluster.x, tracks[t].y - cluster.y
        if not tracks[t].used:
            free = t
        elif tracks[t].score >= PROOFS and dx * dx + dy * dy < (tracks[t].radius + MARGIN) ** 2:
            return
    if free >= 0:
        track, noise = tracks[free], UNSURE * UNSURE + tracker.noise[at.a] ** 2
        x, y, radius, spread, doubt = fit_disc(points, cluster.x, cluster.y, RADIUS, SPREAD * SPREAD, noise)
        track.x, track.y, track.vx, track.vy, track.radius, track.spread = x, y, 0.0, 0.0, radius, spread
        track.begin_x, track.begin_y = x, y
        track.place, track.both, track.speed, track.lost = doubt, 0.0, PACE * PACE, 0.0
        track.score, track.cluster, track.used = 0, -1, True
