"""Tracks of moving bodies, from each learner's own scans and odometry. Observations of a task share them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Labels, Rays, Records
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.simulator.engine.own_scans import own_scan
from irsim_gym.simulator.world.own_scan import OwnScan
from irsim_gym.tasks.observations.scan.ranges import shared_sensors
from irsim_gym.tasks.observations.tracks.clusters import CLUSTER
from irsim_gym.tasks.terms import EpisodeState, Model, Shard, Simulation, State, Struct, Term, kernel, option
from irsim_gym.tasks.terms.term import Needs

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


NEEDS: Needs = ("scan", "odometry")
SIZE = option(1.2, gt=0.0, unit="m", meaning="Wider clusters stand.")
ACCEL = option(1.5, gt=0.0, unit="m/s2", meaning="Deviation of the bodies' accelerations.")
KEEP = option(1.0, ge=0.0, unit="s", meaning="How long a body is followed that is no longer seen.")
TOLD: Mapping[str, bool] = {"moving": True}
"""What a substitute for a missing sensor is given beside the options that it shares."""


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
    def over(cls, options: Any, simulation: Simulation, agents: Ints, name: str) -> Self:
        """Return a tracker that has seen nothing yet.

        Args:
            options: An observation with the options ``size``, ``accel`` and ``keep``.
            simulation: The simulation.
            agents: Body of each learner, shape ``(n_agents,)``.
            name: Name of the observation.
        """
        group, members = shared_sensors(simulation, agents, name)
        scan, n_slots = own_scan(group, members), simulation.shards.n_slots
        sensors, n_beams = [group.options[k] for k in members], scan.ranges.shape[2]
        spacing = float(np.ptp(scan.angles[0])) / (n_beams - 1) if n_beams > 1 else 1.0
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


def share_tracks(options: Any, term: Term, earlier: Sequence[Term]) -> None:
    """Share the tracks of an earlier observation that follows them alike; the method ``join`` of such observations."""
    own = term.arrays.tracker
    for one in earlier:
        other = getattr(one.arrays, "tracker", None)
        if other and (other.size, other.accel, other.keep) == (own.size, own.accel, own.keep):
            term.arrays.tracker = other


def begin_tracks(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
    """Delete the tracks; the method ``begin`` of observations that follow them."""
    forget_tracks(shard.worlds, term.arrays.tracker, episode)


@kernel
def forget_tracks(worlds: Ints, tracker: Tracker, episode: EpisodeState) -> None:
    """Delete the tracks of agents whose episodes begin.

    Reads: episode (began).
    Writes: tracker (noted, tracks).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a]:
                tracker.noted[w, a] = -1
                for t in range(tracker.tracks.shape[2]):
                    tracker.tracks[w, a, t].used = False
