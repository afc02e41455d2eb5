"""circle: evenly on a circle, facing the centre, with the goal opposite."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.placements.manual import put_on_start, world_box
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

MARGIN = 0.5


@kind
class CirclePlacement:
    """Starts on a circle; each goal lies on the other side."""

    is_random: ClassVar[bool] = False
    ensures_way: ClassVar[bool] = False
    gives_goal: ClassVar[bool] = True

    center: tuple[float, float] | tuple[float, float, float] | None = option(
        None, unit="m", meaning="Centre; by default the centre of the world."
    )
    radius: float | None = option(
        None, gt=0.0, unit="m", meaning="Radius; by default half of the world's shorter side, less 0.5 m."
    )

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> str | None:
        """Write the members' starts and goals; return what does not fit the world."""
        options = group.options[0]
        low, high = world_box(model, MARGIN)
        center = (low[:2] + high[:2]) / 2.0 if options.center is None else np.array(options.center[:2])
        radius = float(np.min(high[:2] - low[:2])) / 2.0 if options.radius is None else options.radius
        if radius <= 0.0:
            return f"needs a radius: half of the world's shorter side, less {MARGIN} m, is {radius:g} m"
        for k, b in enumerate(group.members):
            angle = 2.0 * np.pi * k / len(group.members)
            arm = radius * np.array([np.cos(angle), np.sin(angle)])
            model.start[:, b] = [*(center + arm), angle - np.pi]
            model.waypoints[:, b, 0] = [*(center - arm), angle - np.pi]
        return None

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard, failed: Ints) -> None:
        """Put the members on their starts."""
        put_on_start(shard.worlds, group.members, model.start, state.pose, state.placed)
