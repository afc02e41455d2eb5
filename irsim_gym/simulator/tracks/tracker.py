"""The memory of tracks: discs that follow what a body's own scans show to move."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Labels, Rays, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.base.kernels.structs import Struct, record_type
from irsim_gym.simulator.tracks.clusters import CLUSTER
from irsim_gym.simulator.world.own_scan import OwnScan

TRACK = record_type(
    "x y vx vy begin_x begin_y radius spread place both speed lost", score=np.int64, cluster=np.int64, used=np.bool_
)
"""A disc: centre [m], velocity [m/s], where it began [m], radius [m] and its variance; variances of each coordinate of
place and speed and their covariance; the time for which it has not been seen [s]; how often it was seen to move; its
cluster or -1.
"""

SLOTS = 32
"""Number of tracks that are followed, those of what stands included."""
MEMORY = 1.0
"""How far scans are remembered [s]."""
PROOFS = 2
"""How many scans must have shown that it moves."""


SIZE, ACCEL, KEEP = 1.2, 1.5, 1.0
"""Defaults of ``Tracker``: width of a cluster [m], deviation of accelerations [m/s2], time unseen [s]."""


@dataclass
class Tracker(Struct):
    """The tracks, and what they follow from.

    Attributes:
        scan: The scans; member k has the tracks k.
        limits: Valid readings lie between these two [m], shape ``(n_members, 2)``.
        noise: Standard deviation of the readings [m], shape ``(n_members,)``.
        spacing: Angle between neighbouring beams [rad].
        closes: Whether the beams go round a full circle.
        size: Greatest extent of a cluster [m].
        accel: Deviation of accelerations [m/s2].
        keep: How long tracks are followed unseen [s].
        tracks: The tracks, shape ``(n_worlds, n_members, n_tracks)``.
        noted: Step of the latest scan, or -1, shape ``(n_worlds, n_members)``.
        scans: The latest scans [m], shape ``(n_worlds, n_members, n_kept, n_beams)``; the index of a scan is its step
            modulo ``n_kept``.
        eyes: The poses of the sensor then [m, m, rad], shape ``(n_worlds, n_members, n_kept, 3)``.
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
    def over(
        cls, scan: OwnScan, n_slots: int, step_time: float, size: float = SIZE, accel: float = ACCEL, keep: float = KEEP
    ) -> Self:
        """Return a tracker that has seen nothing yet.

        Args:
            scan: The scans to follow, of one kind for all.
            n_slots: How many threads may follow at once.
            step_time: Duration of a step [s].
            size: As the attribute, and likewise the others.
            accel: As ``size``.
            keep: As ``size``.
        """
        members, n_beams = scan.sensors, scan.ranges.shape[2]
        spacing = float(np.ptp(scan.angles[0])) / (n_beams - 1) if n_beams > 1 else 1.0
        shape = len(scan.ranges), len(members)
        kept = int(np.ceil(MEMORY / step_time)) + 1
        return cls(
            scan=scan,
            limits=np.stack([scan.range_min, scan.range_max], 1)[members].astype(np.float32),
            noise=scan.noise[members],
            spacing=spacing,
            closes=spacing * (n_beams + 0.5) > 2.0 * np.pi,
            size=size,
            accel=accel,
            keep=keep,
            tracks=np.zeros((*shape, SLOTS), TRACK),
            noted=np.full(shape, -1, np.int32),
            scans=np.zeros((*shape, kept, n_beams), np.float32),
            eyes=np.zeros((*shape, kept, 3)),
            joined=np.zeros((n_slots, 3, n_beams), np.float32),
            points=np.zeros((n_slots, 2, 2, n_beams)),
            clusters=np.zeros((n_slots, n_beams), CLUSTER),
        )


@kernel(inlined=True)
def is_mover(one: Any) -> bool:
    """Return whether scans have shown that a track moves."""
    return bool(one.used and one.score >= PROOFS)


def are_movers(tracks: Records) -> Flags:
    """Return what ``is_mover`` does for each of many tracks, in their shape."""
    return np.asarray(tracks["used"] & (tracks["score"] >= PROOFS))


@kernel
def forget_tracks(w: int, a: int, tracker: Tracker) -> None:
    """Delete the tracks of a member.

    Writes: tracker (noted, tracks).
    """
    tracker.noted[w, a] = -1
    for t in range(tracker.tracks.shape[2]):
        tracker.tracks[w, a, t].used = False
