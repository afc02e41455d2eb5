"""ORCA for a group (van den Berg, Guy, Lin, Manocha 2011: Reciprocal n-body collision avoidance)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from irsim_gym.behaviors import renewal
from irsim_gym.behaviors.orca_crowd import Crowd, lay_squares, reserve
from irsim_gym.behaviors.orca_map import SIGHT
from irsim_gym.behaviors.orca_planning import Scratch, command_plans, plan_velocities
from irsim_gym.behaviors.orca_walls import EDGE
from irsim_gym.behaviors.surroundings import most_map_walls, scene_of
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kind
class OrcaGroup:
    """All bodies of a group avoid each other, each taking half of the effort, and what never moves."""

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

    neighborDist: float = option(15.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")  # noqa: N815
    maxNeighbors: int = option(10, ge=0, meaning="Greatest number of bodies that are seen.")  # noqa: N815
    timeHorizon: float = option(20.0, gt=0.0, unit="s", meaning="Collisions with bodies later than this are ignored.")  # noqa: N815
    timeHorizonObst: float = option(  # noqa: N815
        10.0, gt=0.0, unit="s", meaning="Collisions with walls later than this are ignored."
    )
    safe_radius: float = option(0.1, ge=0.0, unit="m", meaning="Distance added around each body.")
    maxSpeed: float | None = option(None, gt=0.0, unit="m/s", meaning="Greatest speed; by default the drive's.")  # noqa: N815
    sidestep: bool = option(
        False, meaning="A body that others hold up wants to go to its right, so that none wait for each other for ever."
    )
    wander: bool = renewal.WANDER
    loop: bool = renewal.LOOP
    range_low: tuple[float, float, float] = renewal.LOW
    range_high: tuple[float, float, float] = renewal.HIGH

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from renewal.renewal_problems(self)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Mark who is avoided, and make scratch memory."""
        n_bodies, n_parts = len(model.role), model.local_segments.shape[1] + model.local_discs.shape[1]
        is_member = np.zeros(n_bodies, np.bool_)
        is_member[group.members] = True
        is_wall = ~model.movable & (is_member | ~model.unobstructed)
        n_sides = most_map_walls(model, SIGHT)
        most = min(group.options[0].maxNeighbors, len(group.members))
        seen, decides = is_member & model.movable, np.zeros(n_bodies, np.bool_)
        deciding = group.members[group.arrays["decides"]]
        decides[deciding] = True
        concerned = np.flatnonzero(seen | decides)
        squares = lay_squares(model.bounds, len(concerned), group.options[0].neighborDist, most)
        group.arrays |= {
            "concerned": concerned,
            "squares": squares,
            "seen": seen,
            "plans": decides,
            "is_wall": is_wall,
            "walls": np.flatnonzero(is_wall),
            "deciding": deciding,
            "nearby": np.zeros((n_slots, n_bodies), np.int64),
            "parts": np.zeros((n_slots, n_parts), np.int64),
            "parts_gap": np.zeros((n_slots, n_parts)),
            "owners": np.zeros((n_slots, n_parts), np.int64),
            "sides": np.zeros((n_slots, n_sides, 4)),
            "sides_gap": np.zeros((n_slots, n_sides)),
            "sides_order": np.zeros((n_slots, n_sides), np.int64),
            "edge": np.zeros((n_slots, EDGE)),
            "planes": np.zeros((n_slots, n_parts + n_sides + most, 3)),
            "spare": np.zeros((n_slots, n_parts + n_sides + most, 3)),
            **reserve(n_slots, len(concerned), most, int(squares[3] * squares[4])),
        }

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands and ``state.plan``; all see each other as they were before."""
        arrays, slot = group.arrays, shard.slot
        if not len(arrays["deciding"]):
            return
        plan_velocities(
            shard.worlds,
            arrays["concerned"],
            arrays["squares"],
            group.params,
            model,
            state,
            arrays["seen"],
            arrays["plans"],
            arrays["walls"],
            arrays["is_wall"],
            scene_of(model, state),
            Crowd(*(arrays[name][slot] for name in Crowd._fields)),
            Scratch(*(arrays[name][slot] for name in Scratch._fields)),
        )
        command_plans(shard.worlds, arrays["deciding"], model, state)
