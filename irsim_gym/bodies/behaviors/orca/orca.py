"""ORCA for a group (van den Berg, Guy, Lin, Manocha 2011: Reciprocal n-body collision avoidance)."""

from typing import ClassVar

import numpy as np

from irsim_gym.bodies.behaviors.orca.crowd import Crowd, lay_squares
from irsim_gym.bodies.behaviors.orca.map import SIGHT
from irsim_gym.bodies.behaviors.orca.neighbors import OrcaObstacles
from irsim_gym.bodies.behaviors.orca.planning import OrcaTables, command_plans, plan_velocities
from irsim_gym.bodies.behaviors.shared.map_parts import most_map_discs, most_map_walls
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.geometry.linear_program import HALF_PLANE
from irsim_gym.simulator.world.names import Group, Model, Shard, State, kind, option


@kind
class OrcaGroup(RenewsGoals):
    """All bodies of a group avoid each other, each taking half of the effort, and what never moves."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

    neighborDist: float = option(15.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")  # noqa: N815
    maxNeighbors: int = option(10, ge=0, meaning="Maximum number of bodies that are seen.")  # noqa: N815
    timeHorizon: float = option(20.0, gt=0.0, unit="s", meaning="Collisions with bodies later than this are ignored.")  # noqa: N815
    timeHorizonObst: float = option(10.0, gt=0.0, unit="s", meaning="The same for walls.")  # noqa: N815
    safe_radius: float = option(0.1, ge=0.0, unit="m", meaning="Distance added around each body.")
    maxSpeed: float | None = option(None, gt=0.0, unit="m/s", meaning="Maximum speed; by default the drive's.")  # noqa: N815
    sidestep: bool = option(False, meaning="A body that others hold up wants to its right, lest all wait for ever.")

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Mark the bodies to avoid, and allocate scratch memory."""
        n_bodies, n_parts = len(model.role), model.local_segments.shape[1] + model.local_discs.shape[1]
        is_member, plans = np.zeros(n_bodies, np.bool_), np.zeros(n_bodies, np.bool_)
        is_member[group.members] = True
        deciding = group.members[group.arrays["decides"]]
        plans[deciding] = True
        # Members that never move are walls to the others, even if `unobstructed`: they cannot take half of the effort.
        is_wall, seen = ~model.movable & (is_member | ~model.unobstructed), is_member & model.movable
        # Upper bounds of what map_parts finds: walls within SIGHT of the body, and discs whose edges are.
        members, n_sides = np.flatnonzero(seen | plans), most_map_walls(model, SIGHT)
        n_discs = most_map_discs(model, SIGHT + model.map_disc[0])
        most = min(group.options[0].maxNeighbors, len(group.members))
        squares = lay_squares(model.bounds, len(members), group.options[0].neighborDist, most)
        n_planes = n_parts + n_sides + n_discs + most
        group.tables = [
            OrcaTables(
                deciding=deciding,
                crowd=Crowd.reserve(members, squares, seen, plans, most),
                obstacles=OrcaObstacles.reserve(is_wall, n_parts, n_sides, n_discs),
                planes=np.zeros(n_planes, HALF_PLANE),
                spare=np.zeros(n_planes, HALF_PLANE),
            )
            for _ in range(n_slots)
        ]

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands and ``state.plan``; all see each other as they were before."""
        tables = group.tables[shard.slot]
        if len(tables.deciding):
            plan_velocities(shard.worlds, group.params, model, state, tables)
            command_plans(shard.worlds, model, state, tables)
