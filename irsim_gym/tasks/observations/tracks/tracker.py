"""Tracks of moving bodies, from each learner's own scans and odometry. Observations of a task share them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Labels, Rays, Records
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.base.options import option_fields
from irsim_gym.simulator.engine.own_scans import own_scan
from irsim_gym.simulator.geometry.angles import TURN, nearly_arctan2, wrap
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR, shared_sensors
from irsim_gym.tasks.observations.tracks.clusters import CLUSTER, find_clusters, fit_disc, join_beams
from irsim_gym.tasks.terms import EpisodeState, Model, Shard, Simulation, State, Struct, Term, kernel, kind, option
from irsim_gym.tasks.terms.term import Needs

TRACK = record_type("x y vx vy radius spread place both speed lost", score=np.int64, cluster=np.int64, used=np.bool_)
"""A disc: centre [m], velocity [m/s], radius [m] and its variance; variances of each coordinate of place and speed and
their covariance; the time for which it has not been seen [s]; how often it was seen to move; its cluster or -1.
"""

SLOTS = 32
"""Least number of tracks that are followed, the standing ones included."""
MEMORY = 1.0
"""How far scans are remembered [s]."""
SHIFT = 0.3
"""How far something has to move before scans are compared [m]."""
MARGIN = 0.1
"""How much deeper than a disc's front a beam must reach for the place to count as free [m]."""
PROOFS = 2
"""How many scans must have shown that it moves."""
SLOWEST = 0.1
"""What is slower than this stands [m/s]."""
UNSURE = 0.002
"""Deviation of readings without noise, and of discs from what bodies are [m]."""
RADIUS, SPREAD, PACE = 0.3, 0.1, 1.0
"""Radius [m], its deviation [m] and the deviation of each component of the velocity [m/s] of a new track."""


@kind
class FollowsTracks:
    """The options of observations that follow tracks."""

    needs: ClassVar[Needs] = ("scan", "odometry")

    size: float = option(1.2, gt=0.0, unit="m", meaning="Wider clusters stand.")
    accel: float = option(1.5, gt=0.0, unit="m/s2", meaning="Deviation of the bodies' accelerations.")
    keep: float = option(1.0, ge=0.0, unit="s", meaning="How long a body is followed that is no longer seen.")
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def substitute(self, kind: type) -> Any:
        """Return an observation of what a robot without a sensor is told, with the same options, as far as it has them.

        Args:
            kind: A kind of observation.
        """
        known = option_fields(kind)
        told = {key: getattr(self, key) for key in option_fields(type(self)) if key in known}
        return kind(**told, **({"moving": True} if "moving" in known else {}))

    def join(self, term: Term, earlier: Sequence[Term]) -> None:
        """Share the tracks of an earlier observation that follows them alike."""
        for other in earlier:
            if isinstance(other.options, FollowsTracks) and other.options.follows == self.follows:
                term.arrays.tracker = other.arrays.tracker

    @property
    def follows(self) -> tuple[float, float, float]:
        """The options that tracks depend on."""
        return self.size, self.accel, self.keep

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Delete the tracks."""
        forget_tracks(shard.worlds, term.arrays.tracker, episode)


@dataclass
class Tracker(Struct):
    """The tracks, and what they follow from.

    Attributes:
        scan: The scans; member k is learner k.
        limits: Valid readings lie between these two [m], shape ``(n_agents, 2)``.
        noise: Standard deviation of the readings [m], shape ``(n_agents,)``.
        spacing: Angle between neighbouring beams [rad].
        closes: Whether the beams go round a full circle.
        size: Greatest extent of a cluster [m].
        accel: Deviation of accelerations [m/s2].
        keep: How long tracks are followed unseen [s].
        tracks: The tracks, shape ``(n_worlds, n_agents, n_tracks)``.
        noted: Step of the latest scan, or -1, shape ``(n_worlds, n_agents)``.
        scans: The latest scans [m], shape ``(n_worlds, n_agents, n_kept, n_beams)``; the index of a scan is its step
            modulo ``n_kept``.
        eyes: The poses of the sensor then [m, m, rad], shape ``(n_worlds, n_agents, n_kept, 3)``.
        joined: Scratch, see ``join_beams``, shape ``(n_slots, 3, n_beams)``.
        points: Scratch, see ``find_clusters``, shape ``(n_slots, 2, 2, n_beams)``.
        clusters: Scratch, likewise, shape ``(n_slots, n_beams)``.
    """

    scan: OwnScan
    limits: Rays
    noise: Floats
    spacing: float
    closes: bool
    size: float
    accel: float
    keep: float
    tracks: Records
    noted: Labels
    scans: Rays
    eyes: Floats
    joined: Rays
    points: Floats
    clusters: Records

    @classmethod
    def over(cls, options: FollowsTracks, simulation: Simulation, agents: Ints, name: str) -> Self:
        """Return a tracker that has seen nothing yet.

        Args:
            options: The options of an observation.
            simulation: The simulation.
            agents: Body of each learner, shape ``(n_agents,)``.
            name: Name of the observation.
        """
        group, members = shared_sensors(simulation, agents, name)
        scan, n_slots = own_scan(group, members), simulation.shards.n_slots
        sensors = [group.options[k] for k in members]
        angles, n_beams = scan.angles[0], scan.ranges.shape[2]
        spacing = float(angles[-1] - angles[0]) / max(n_beams - 1, 1) if n_beams else 1.0
        shape = simulation.n_worlds, len(agents)
        kept = int(np.ceil(MEMORY / float(simulation.model.step_time[0]))) + 1
        return cls(
            scan=scan,
            limits=np.stack([scan.range_min, scan.range_max], 1)[members].astype(np.float32),
            noise=np.array([getattr(s, "std", 0.0) if getattr(s, "noise", False) else 0.0 for s in sensors]),
            spacing=spacing,
            closes=spacing * (n_beams + 0.5) > 2.0 * np.pi,
            size=options.size,
            accel=options.accel,
            keep=options.keep,
            tracks=np.zeros((*shape, SLOTS), TRACK),
            noted=np.full(shape, -1, np.int32),
            scans=np.zeros((*shape, kept, n_beams), np.float32),
            eyes=np.zeros((*shape, kept, 3)),
            joined=np.zeros((n_slots, 3, n_beams), np.float32),
            points=np.zeros((n_slots, 2, 2, n_beams)),
            clusters=np.zeros((n_slots, n_beams), CLUSTER),
        )


@kernel
def forget_tracks(worlds: Ints, tracker: Tracker, episode: EpisodeState) -> None:
    """Delete the tracks of agents whose episodes begin."""
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a]:
                tracker.noted[w, a] = -1
                for t in range(tracker.tracks.shape[2]):
                    tracker.tracks[w, a, t].used = False


@kernel
def follow_all(
    worlds: Ints, slot: int, agents: Ints, tracker: Tracker, model: Model, state: State, episode: EpisodeState
) -> None:
    """Bring the tracks up to the latest scans, unless they are."""
    dt = model.step_time[0]
    for w in worlds:
        for a in range(agents.shape[0]):
            step = episode.steps[w, a]
            if step != tracker.noted[w, a] and tracker.scan.ranges.shape[2] > 0:
                note_scan(w, a, step, state.pose[w, agents[a]], slot, tracker)
                n_clusters = see_clusters(w, a, step, slot, tracker)
                follow(w, a, step, slot, n_clusters, dt, tracker)
                tracker.noted[w, a] = step


@kernel
def note_scan(w: int, a: int, step: int, pose: Floats, slot: int, tracker: Tracker) -> None:
    """Keep a scan and the sensor's pose, and write where its beams end."""
    scan, s, row = tracker.scan, tracker.scan.sensors[a], step % tracker.scans.shape[2]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * scan.offset[s, 0] - sine * scan.offset[s, 1]
    y = pose[1] + sine * scan.offset[s, 0] + cosine * scan.offset[s, 1]
    eye, ends, kept = tracker.eyes[w, a, row], tracker.points[slot, 0], tracker.scans[w, a, row]
    eye[0], eye[1], eye[2] = x, y, pose[2]
    for i in range(kept.shape[0]):
        reading, ahead, left = scan.ranges[w, s, i], scan.beams_x[s, i], scan.beams_y[s, i]
        kept[i] = reading
        ends[0, i] = x + reading * (cosine * ahead - sine * left)
        ends[1, i] = y + reading * (sine * ahead + cosine * left)


@kernel
def see_clusters(w: int, a: int, step: int, slot: int, tracker: Tracker) -> int:
    """Write the clusters of the latest scan and where their bodies may have their centres; return their number."""
    ranges, limits = tracker.scans[w, a, step % tracker.scans.shape[2]], tracker.limits[a]
    joined, clusters = tracker.joined[slot], tracker.clusters[slot]
    join_beams(ranges, limits, tracker.spacing, tracker.noise[a], tracker.closes, joined)
    count = find_clusters(ranges, limits, tracker.size, joined, tracker.points[slot], clusters)
    eye = tracker.eyes[w, a, step % tracker.eyes.shape[2]]
    for c in range(count):
        dx, dy = clusters[c].x - eye[0], clusters[c].y - eye[1]
        behind = 0.6 * RADIUS / max(np.sqrt(dx * dx + dy * dy), 1e-9)
        clusters[c].x, clusters[c].y = clusters[c].x + behind * dx, clusters[c].y + behind * dy
    return count


@kernel
def follow(w: int, a: int, step: int, slot: int, n_clusters: int, dt: float, tracker: Tracker) -> None:
    """Predict the tracks, match them with the clusters, correct them, and begin and end some."""
    tracks, clusters = tracker.tracks[w, a], tracker.clusters[slot]
    eye = tracker.eyes[w, a, step % tracker.eyes.shape[2]]
    for t in range(tracks.shape[0]):
        if tracks[t].used:
            predict(tracks[t], dt, tracker.accel)
            tracks[t].cluster = nearest_cluster(tracks[t], clusters, n_clusters)
            if tracks[t].score >= PROOFS and tracks[t].cluster >= 0:
                n_clusters = claim(t, tracks, clusters, n_clusters, tracker.points[slot, 1])
    for t in range(tracks.shape[0]):
        one = tracks[t]
        if not one.used:
            continue
        if one.cluster >= 0 and one.score < PROOFS:
            if clusters[one.cluster].track < 0 and nearest_track(one.cluster, tracks, clusters) == t:
                clusters[one.cluster].track = t
            else:
                one.cluster = -1
        if one.cluster >= 0:
            points = tracker.points[slot, 1, :, clusters[one.cluster].first : clusters[one.cluster].last]
            measure(one, points, eye, a, tracker)
            judge(w, a, step, one, points, dt, tracker)
        else:
            one.lost += dt
            if one.score < PROOFS:
                one.used = one.lost < 2.5 * dt
            else:
                one.lost += 2.0 * dt if look(w, a, step, one.x, one.y, tracker) > MARGIN - one.radius else 0.0
                one.used = one.lost < tracker.keep
    for c in range(n_clusters):
        if clusters[c].track < 0:
            begin(clusters[c], eye, slot, a, tracks, tracker)


@kernel
def predict(one: Any, dt: float, accel: float) -> None:
    """Move a track on; its velocity may have changed at once."""
    one.x, one.y = one.x + one.vx * dt, one.y + one.vy * dt
    one.speed += (accel * dt) ** 2
    one.place += dt * (2.0 * one.both + dt * one.speed)
    one.both += dt * one.speed


@kernel
def apart(one: Any, cluster: Any) -> float:
    """Return the square of the distance between a track and a cluster [m2]; infinity if it is too large."""
    dx, dy = one.x - cluster.x, one.y - cluster.y
    square = dx * dx + dy * dy
    return square if square <= (0.35 + 2.0 * np.sqrt(one.place)) ** 2 else np.inf


@kernel
def nearest_cluster(one: Any, clusters: Records, n_clusters: int) -> int:
    """Return the cluster nearest to a track, or -1."""
    least, found = np.inf, -1
    for c in range(n_clusters):
        square = apart(one, clusters[c])
        if square < least:
            least, found = square, c
    return found


@kernel
def nearest_track(c: int, tracks: Records, clusters: Records) -> int:
    """Return the track nearest to a cluster among those whose nearest it is."""
    least, found = np.inf, -1
    for t in range(tracks.shape[0]):
        if tracks[t].used and tracks[t].cluster == c:
            square = apart(tracks[t], clusters[c])
            if square < least:
                least, found = square, t
    return found


@kernel
def claim(t: int, tracks: Records, clusters: Records, n_clusters: int, points: Floats) -> int:
    """Give a moving track its nearest cluster, and return the number of clusters.

    Of a cluster that another one has claimed it gets the points that are nearer to its own edge, as a new cluster.
    """
    whole = clusters[tracks[t].cluster]
    if whole.track < 0:
        whole.track = t
        return n_clusters
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
    if middle < whole.last and n_clusters < clusters.shape[0]:
        part = clusters[n_clusters]
        part.x, part.y, part.first, part.last, part.track = tracks[t].x, tracks[t].y, middle, whole.last, t
        whole.last, tracks[t].cluster = middle, n_clusters
        n_clusters += 1
    if whole.first == whole.last:
        other.cluster = -1
    return n_clusters


@kernel
def from_edge(one: Any, points: Floats, k: int) -> float:
    """Return the distance of a point from the edge of a track's disc [m]."""
    dx, dy = points[0, k] - one.x, points[1, k] - one.y
    return abs(np.sqrt(dx * dx + dy * dy) - one.radius)


@kernel
def measure(one: Any, points: Floats, eye: Floats, a: int, tracker: Tracker) -> None:
    """Correct a track by the disc through its cluster: a Kalman filter, the same for both coordinates."""
    noise = UNSURE * UNSURE + tracker.noise[a] ** 2
    x, y, radius, spread, doubt = fit_disc(points, one.x, one.y, one.radius, one.spread, noise)
    dx, dy = x - eye[0], y - eye[1]
    away = max(np.sqrt(dx * dx + dy * dy), 1e-9)
    if points.shape[1] == 1:
        doubt += (0.3 * tracker.spacing * away) ** 2
    # A centre that was found with another radius would have lain as much farther, or nearer.
    grown = (radius - one.radius) / away
    one.x, one.y, one.radius, one.spread = one.x + grown * dx, one.y + grown * dy, radius, spread
    gain, rate = one.place / (one.place + doubt), one.both / (one.place + doubt)
    off_x, off_y = x - one.x, y - one.y
    one.x, one.y, one.vx, one.vy = (
        one.x + gain * off_x,
        one.y + gain * off_y,
        one.vx + rate * off_x,
        one.vy + rate * off_y,
    )
    one.speed -= rate * one.both
    one.place, one.both, one.lost = (1.0 - gain) * one.place, (1.0 - gain) * one.both, 0.0


@kernel
def look(w: int, a: int, step: int, x: float, y: float, tracker: Tracker) -> float:
    """Return how far beyond a point, and a margin, both beams beside it reached in a step [m]; -9 without beams."""
    row, s = step % tracker.scans.shape[2], tracker.scan.sensors[a]
    eye, ranges = tracker.eyes[w, a, row], tracker.scans[w, a, row]
    dx, dy = x - eye[0], y - eye[1]
    place = wrap(nearly_arctan2(dy, dx) - eye[2] - tracker.scan.angles[s, 0])
    first = int((place if place >= 0.0 else place + TURN) / tracker.spacing)
    if first >= ranges.shape[0] - 1:
        return -9.0
    away = np.sqrt(dx * dx + dy * dy)
    return min(ranges[first], ranges[first + 1]) - away - MARGIN - 3.0 * tracker.noise[a] - away * tracker.spacing


@kernel
def judge(w: int, a: int, step: int, one: Any, points: Floats, dt: float, tracker: Tracker) -> None:
    """Count the scans that show that a track moves: it is where there was free space, or has left a place that is free.

    A track of which that is known is not judged again. The points are those of its cluster, ``(2, n)``.
    """
    pace = np.sqrt(one.vx * one.vx + one.vy * one.vy)
    if one.score >= PROOFS or pace < SLOWEST or points.shape[1] == 1:
        one.score = one.score if one.score >= PROOFS else max(one.score - 1, 0)
        return
    middle, last = points.shape[1] // 2, points.shape[1] - 1
    back = min(max(int(SHIFT / (pace * dt) + 0.5), 1), step, tracker.scans.shape[2] - 1)
    moves = False
    for ago in (back, (back + 1) // 2):
        for k in (0, middle, last):
            moves = moves or look(w, a, step - ago, points[0, k], points[1, k], tracker) > 0.0
        x, y = points[0, middle] - ago * dt * one.vx, points[1, middle] - ago * dt * one.vy
        was = look(w, a, step - ago, x, y, tracker)
        moves = moves or (look(w, a, step, x, y, tracker) > 0.0 and -2.0 * MARGIN < was < 0.0)
    one.score += 1 if moves else -min(one.score, 1)


@kernel
def begin(cluster: Any, eye: Floats, slot: int, a: int, tracks: Records, tracker: Tracker) -> None:
    """Begin a track at a cluster, unless a known body is there or all places are taken."""
    free = -1
    for t in range(tracks.shape[0]):
        one = tracks[t]
        if not one.used:
            free = t
        elif one.score >= PROOFS:
            dx, dy = one.x - cluster.x, one.y - cluster.y
            if dx * dx + dy * dy < (one.radius + MARGIN) ** 2:
                return
    if free < 0:
        return
    one, points = tracks[free], tracker.points[slot, 1, :, cluster.first : cluster.last]
    noise = UNSURE * UNSURE + tracker.noise[a] ** 2
    x, y, radius, spread, doubt = fit_disc(points, cluster.x, cluster.y, RADIUS, SPREAD * SPREAD, noise)
    one.x, one.y, one.vx, one.vy, one.radius, one.spread = x, y, 0.0, 0.0, radius, spread
    one.place, one.both, one.speed, one.lost, one.score, one.cluster, one.used = (
        doubt,
        0.0,
        PACE * PACE,
        0.0,
        0,
        -1,
        True,
    )
