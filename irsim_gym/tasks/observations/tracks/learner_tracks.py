"""Tracks of moving bodies, from each learner's own scans and odometry. Observations of a task share them."""

from collections.abc import Mapping, Sequence
from typing import Any

from irsim_gym.base.arraytypes import Ints
from irsim_gym.simulator.engine.own_scans import own_scan
from irsim_gym.simulator.tracks import tracker as defaults
from irsim_gym.simulator.tracks.following import Moment, follow_scan
from irsim_gym.simulator.tracks.tracker import Tracker, forget_tracks
from irsim_gym.tasks.observations.scan.ranges import shared_sensors
from irsim_gym.tasks.terms import EpisodeState, Model, Shard, Simulation, State, Term, kernel, option
from irsim_gym.tasks.terms.term import Needs

NEEDS: Needs = ("scan", "odometry")
SIZE = option(defaults.SIZE, gt=0.0, unit="m", meaning="Wider clusters stand.")
ACCEL = option(defaults.ACCEL, gt=0.0, unit="m/s2", meaning="Deviation of the bodies' accelerations.")
KEEP = option(defaults.KEEP, ge=0.0, unit="s", meaning="How long a body is followed that is no longer seen.")
TOLD: Mapping[str, bool] = {"moving": True}
"""What a substitute for a missing sensor is given beside the options that it shares."""


def new_tracker(options: Any, simulation: Simulation, agents: Ints, name: str) -> Tracker:
    """Return a tracker for learners that has seen nothing yet.

    Args:
        options: An observation with the options ``size``, ``accel`` and ``keep``.
        simulation: The simulation.
        agents: Body of each learner, shape ``(n_agents,)``.
        name: Name of the observation.
    """
    scan, dt = own_scan(*shared_sensors(simulation, agents, name)), float(simulation.model.step_time[0])
    tracker = Tracker.over(scan, simulation.shards.n_slots, dt, options.size, options.accel, options.keep)
    simulation.trackers.append(tracker)
    return tracker


def share_tracks(options: Any, term: Term, earlier: Sequence[Term]) -> None:
    """Share the tracks of an earlier observation that follows them alike; the method ``join`` of such observations."""
    own = term.arrays.tracker
    for one in earlier:
        other = getattr(one.arrays, "tracker", None)
        if other and (other.size, other.accel, other.keep) == (own.size, own.accel, own.keep):
            term.arrays.tracker = other


def begin_tracks(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
    """Delete the tracks; the method ``begin`` of observations that follow them."""
    forget_begun(shard.worlds, term.arrays.tracker, episode)


@kernel
def forget_begun(worlds: Ints, tracker: Tracker, episode: EpisodeState) -> None:
    """Delete the tracks of agents whose episodes begin.

    Reads: episode (began).
    Writes: tracker (noted, tracks).
    """
    for w in worlds:
        for a in range(episode.began.shape[1]):
            if episode.began[w, a]:
                forget_tracks(w, a, tracker)


@kernel
def follow_all(
    worlds: Ints, slot: int, agents: Ints, tracker: Tracker, model: Model, state: State, episode: EpisodeState
) -> None:
    """Bring the tracks up to the latest scans, unless they are.

    Reads: tracker (accel, closes, clusters, eyes, joined, keep, limits, noise, noted, points, scan, scans, size,
        spacing, tracks), model (step_time), state (pose, step).
    Writes: tracker (clusters, eyes, joined, noted, points, scans, tracks).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            at = Moment(w, a, state.step[w], slot, model.step_time[0])
            follow_scan(at, state.pose[w, agents[a]], tracker)
