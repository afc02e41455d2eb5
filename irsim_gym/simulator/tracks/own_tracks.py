"""Members of a group that decide by tracks: what their own scans show to move, in place of what does."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from irsim_gym.simulator.tracks.following import Moment, follow_scan
from irsim_gym.simulator.tracks.tracker import TRACK, Tracker, forget_tracks
from irsim_gym.simulator.world.names import Flags, Group, Ints, Model, Records, Shard, State, Struct, kernel


@dataclass
class OwnTracks(Struct):
    """The tracks of those members of a group that decide by them.

    Attributes:
        row: Row of each body in ``tracks``, -1 for those that are told what moves, shape ``(n_bodies,)``.
        tracks: The tracks, shape ``(n_worlds, n_rows, n_tracks)``.
        tracker: What they follow from; None if nobody decides by them.
    """

    row: Ints
    tracks: Records
    tracker: Tracker | None

    @classmethod
    def over(cls, group: Group, chosen: Flags, model: Model, n_slots: int) -> Self:
        """Return the tracks of a group.

        Args:
            group: A group whose members have scans where they are chosen.
            chosen: Which members decide by tracks, shape ``(n_members,)``.
            model: Constants of the worlds.
            n_slots: How many threads may follow at once.
        """
        row = np.full(len(model.role), -1, np.int64)
        if not chosen.any():
            return cls(row, np.zeros((len(model.present), 0, 0), TRACK), None)
        row[group.members[chosen]] = np.arange(chosen.sum())
        tracker = Tracker.over(group.scan.select(np.flatnonzero(chosen)), n_slots, float(model.step_time[0]))
        return cls(row, tracker.tracks, tracker)

    def follow(self, group: Group, model: Model, state: State, shard: Shard) -> None:
        """Bring the tracks of the members of a group up to their latest scans."""
        if self.tracker is not None:
            follow_members(shard.worlds, shard.slot, group.members, self.row, self.tracker, model, state)

    def forget(self, shard: Shard) -> None:
        """Delete the tracks of worlds that begin."""
        if self.tracker is not None:
            forget_members(shard.worlds, self.tracker)


@kernel
def follow_members(
    worlds: Ints, slot: int, members: Ints, row: Ints, tracker: Tracker, model: Model, state: State
) -> None:
    """Bring the tracks of bodies up to their latest scans.

    Reads: tracker (accel, closes, clusters, eyes, joined, keep, limits, noise, noted, points, scan, scans, size,
        spacing, tracks), model (step_time), state (pose, step).
    Writes: tracker (clusters, eyes, joined, noted, points, scans, tracks).
    """
    for w in worlds:
        for b in members:
            if row[b] >= 0:
                follow_scan(Moment(w, row[b], state.step[w], slot, model.step_time[0]), state.pose[w, b], tracker)


@kernel
def forget_members(worlds: Ints, tracker: Tracker) -> None:
    """Delete all tracks of some worlds.

    Writes: tracker (noted, tracks).
    """
    for w in worlds:
        for a in range(tracker.noted.shape[1]):
            forget_tracks(w, a, tracker)
