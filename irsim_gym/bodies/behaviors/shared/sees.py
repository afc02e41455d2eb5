"""Options and parts of behaviours that see what moves by tracks: in their own scans, in place of being told."""

from typing import Literal

import numpy as np

from irsim_gym.base.arraytypes import Flags
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.tracks.own_tracks import OwnTracks
from irsim_gym.simulator.world.names import Group, Model, Shard, kind, option


@kind
class SeesMovers(RenewsGoals):
    """Options of behaviours that are told what moves, or see it by their own scans."""

    sees: Literal["bodies", "tracks"] = option(
        "bodies",
        meaning="How it knows what moves: it is told (bodies), or its own scans show it (tracks: the observation "
        "tracks says how). It is told what stands.",
    )

    @property
    def reads_scan(self) -> bool:
        """Whether the body needs a range sensor."""
        return self.sees == "tracks"

    @staticmethod
    def begin(group: Group, shard: Shard) -> None:
        """Delete the tracks."""
        group.tracked.forget(shard)


def tracks_of(group: Group, model: Model, n_slots: int, decides: Flags | bool = True) -> OwnTracks:
    """Note and return the tracks of the members with ``sees: tracks`` that decide, and have a sensor."""
    by_tracks = np.array([options.sees == "tracks" for options in group.options], np.bool_)
    has_sensor = False if group.scan is None else group.scan.sensors >= 0
    tracked = group.tracked = OwnTracks.over(group, by_tracks & has_sensor & decides, model, n_slots)
    return tracked
