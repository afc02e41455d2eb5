"""Time to tracks: the time until the agent touches a moving body that its scans show, for each of many velocities."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.simulator.tracks.tracker import Tracker, is_mover
from irsim_gym.tasks.observations.bodies.time_to_collision import MovingPoint, ObservesTimes, Velocities, meet_disc
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.tracks import learner_tracks
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, Shard, Simulation, State, Struct, Term, kernel, kind
from irsim_gym.tasks.terms.graph import RobotValues, Value
from irsim_gym.tasks.terms.term import Needs


@dataclass
class TrackedTimes(Struct):
    """The tracks, and the observed velocities."""

    tracker: Tracker
    table: Velocities


@kind
class TimeToTracks(ObservesTimes):
    """Time until a disc around the agent touches a body of ``tracks``, with the columns of ``time_to_collision``."""

    needs: ClassVar[Needs] = learner_tracks.NEEDS
    told: ClassVar[Mapping[str, bool]] = learner_tracks.TOLD

    size: float = learner_tracks.SIZE
    accel: float = learner_tracks.ACCEL
    keep: float = learner_tracks.KEEP
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    join, begin = learner_tracks.share_tracks, staticmethod(learner_tracks.begin_tracks)

    def arrays(self, simulation: Simulation, agents: Ints) -> TrackedTimes:
        """Return the tracks, the velocities in the body frame and the radii of the discs around the agents."""
        tracker = learner_tracks.new_tracker(self, simulation, agents, "time_to_tracks")
        return TrackedTimes(tracker, self.velocities(simulation.model, agents))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph, see ``HasGraph``; the robot's own tracker gives the bodies."""
        return self.times_graph(term.arrays.table, agent, robot)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Follow the tracks, and write the nearness of the first collision for each velocity."""
        learner_tracks.follow_all(shard.worlds, shard.slot, term.agents, term.arrays.tracker, model, state, episode)
        write_track_times(shard.worlds, term.bound, term.arrays, state, episode)


@kernel
def write_track_times(worlds: Ints, term: Bound, timed: TrackedTimes, state: State, episode: EpisodeState) -> None:
    """Write the nearness of the first collision for each velocity.

    Reads: term (agents, column, options), timed (table, tracker), state (pose), episode (observation).
    Writes: episode (observation).
    """
    options, table, horizon = term.options[0], timed.table, np.float32(term.options[0].horizon)
    far = np.inf if np.isnan(options.range) else options.range
    for w in worlds:
        for a in range(term.agents.shape[0]):
            tracks, pose = timed.tracker.tracks[w, a], state.pose[w, term.agents[a]]
            row = episode.observation[w, a, term.column : term.column + table.ahead.shape[1]]
            row[:] = horizon
            cosine, sine = np.cos(pose[2]), np.sin(pose[2])
            for t in range(tracks.shape[0]):
                track = tracks[t]
                dx, dy = track.x - pose[0], track.y - pose[1]
                if is_mover(track) and np.sqrt(dx * dx + dy * dy) - track.radius <= far:
                    x, y = dx * cosine + dy * sine, dy * cosine - dx * sine
                    vx, vy = track.vx * cosine + track.vy * sine, track.vy * cosine - track.vx * sine
                    meet_disc(
                        MovingPoint(x, y, vx, vy, table.radius[a] + track.radius), table.ahead[a], table.aside[a], row
                    )
            for j in range(row.shape[0]):
                row[j] = np.float32(1.0) - row[j] / horizon
