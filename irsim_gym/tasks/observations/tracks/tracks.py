"""Tracks: moving bodies around an agent, as its own scans show them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.simulator.tracks.tracker import Tracker, is_mover
from irsim_gym.tasks.observations.bodies.nearest_bodies import (
    WIDTH,
    Nearest,
    ObservesNearest,
    forget_nearest,
    keep,
    moving,
    nearest_memory,
    write_gaps,
    write_motion,
)
from irsim_gym.tasks.observations.scan.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.tracks import learner_tracks
from irsim_gym.tasks.terms import Bound, EpisodeState, Model, Shard, Simulation, State, Struct, Term, kernel, kind
from irsim_gym.tasks.terms.graph import RobotValues, Value
from irsim_gym.tasks.terms.term import Needs


@dataclass
class Tracked(Struct):
    """The tracks, and scratch memory for the nearest of them."""

    tracker: Tracker
    nearest: Nearest


@kind
class Tracks(ObservesNearest):
    """The nearest moving bodies as the agent's own scans show them, with the columns of ``nearest_bodies``.

    Neighbouring points of a scan form a cluster, clusters of successive scans a track: a disc with a velocity (a Kalman
    filter). It counts once scans have shown that it moves: it is where there was free space, or has left a place that
    is free now. From then on it counts while it is seen, and for ``keep`` where others hide it.
    """

    needs: ClassVar[Needs] = learner_tracks.NEEDS
    told: ClassVar[Mapping[str, bool]] = learner_tracks.TOLD

    size: float = learner_tracks.SIZE
    accel: float = learner_tracks.ACCEL
    keep: float = learner_tracks.KEEP
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    join, begin = learner_tracks.share_tracks, staticmethod(learner_tracks.begin_tracks)

    def arrays(self, simulation: Simulation, agents: Ints) -> Tracked:
        """Return the tracks and scratch memory."""
        return Tracked(learner_tracks.new_tracker(self, simulation, agents, "tracks"), nearest_memory(self, simulation))

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph, see ``HasGraph``; the robot's own tracker gives the bodies."""
        return self.nearest_graph(term.arrays.nearest.sight, model, term.agents[agent], robot)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Follow the tracks, and write the numbers of the nearest ones."""
        learner_tracks.follow_all(shard.worlds, shard.slot, term.agents, term.arrays.tracker, model, state, episode)
        write_tracks(shard.worlds, shard.slot, term.bound, term.arrays, model, state, episode)


@kernel
def write_tracks(
    worlds: Ints, slot: int, term: Bound, tracked: Tracked, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write five numbers for each of the nearest tracks of bodies that move.

    Reads: term (agents, column, options), tracked (nearest, tracker), model (disc_count, disc_start, segment_count,
        segment_start), state (discs, pose, segments, stopped, twist).
    Writes: tracked (nearest), episode (observation).
    """
    nearest, speed = tracked.nearest, term.options[0].speed
    for w in worlds:
        for a in range(term.agents.shape[0]):
            body, tracks = term.agents[a], tracked.tracker.tracks[w, a]
            x, y, heading = state.pose[w, body, 0], state.pose[w, body, 1], state.pose[w, body, 2]
            forget_nearest(slot, nearest)
            for t in range(tracks.shape[0]):
                if is_mover(tracks[t]):
                    dx, dy = tracks[t].x - x, tracks[t].y - y
                    away = np.sqrt(dx * dx + dy * dy)
                    share = (away - tracks[t].radius) / away if away > 0.0 else 1.0
                    keep(away - tracks[t].radius, share * dx, share * dy, t, slot, nearest)
            row = episode.observation[w, a, term.column : term.column + WIDTH * nearest.distance.shape[1]]
            write_gaps(w, body, slot, nearest, term, model, state, row)
            own_x, own_y = moving(w, body, 0, state), moving(w, body, 1, state)
            ahead = np.cos(heading), np.sin(heading)
            for k in range(nearest.distance.shape[1]):
                t, vx, vy = nearest.body[slot, k], 0.0, 0.0
                if t >= 0:
                    vx, vy = tracks[t].vx - own_x, tracks[t].vy - own_y
                way = nearest.way_x[slot, k], nearest.way_y[slot, k]
                write_motion(way, (vx, vy), ahead, speed, row[WIDTH * k : WIDTH * (k + 1)])
