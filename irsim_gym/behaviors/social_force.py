"""Social forces (Moussaid et al. 2009): a goal pulls a body, and other bodies and walls push it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

from irsim_gym.behaviors.renewal import RenewsGoals, renewal_problems
from irsim_gym.behaviors.social_pushes import follow, planned_velocity
from irsim_gym.behaviors.social_walls import SocialTables
from irsim_gym.behaviors.steering import clear_command, wanted_velocity
from irsim_gym.world.names import Group, Ints, Model, Shard, State, kernel, kind, option

DESIRED = option(1.0, ge=0.0, meaning="Weight of the force towards the goal.")
SOCIAL = option(2.1, ge=0.0, meaning="Weight of the force away from other bodies.")
OBSTACLE = option(10.0, ge=0.0, meaning="Weight of the force away from walls.")
SIGMA = option(0.8, gt=0.0, unit="m", meaning="Distance over which the force of a wall fades.")
IMPORTANCE = option(2.0, ge=0.0, meaning="Weight of relative velocity against relative position.")
GAMMA = option(0.35, gt=0.0, unit="s", meaning="Range of the interaction for each m/s of its velocity.")
ANGULAR = option(2.0, ge=0.0, meaning="Decay of the sideways force with the angle.")
VELOCITY = option(3.0, ge=0.0, meaning="Decay of the braking force with the angle.")
RELAXATION = option(0.5, gt=0.0, unit="s", meaning="Time in which the desired velocity is taken up.")
NEIGHBORS = option(10.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")
SPEED = option(1.5, gt=0.0, unit="m/s", meaning="Desired and maximum speed.")
SAFETY = option(0.0, ge=0.0, unit="m", meaning="Distance added around each body.")

INTERACTION = option(
    "moussaid",
    meaning="How others push: by position and velocity (Moussaid et al. 2009), or straight away, fading with the "
    "gap between the discs (circular; Helbing and Molnar 1995).",
)
RANGE = option(1.0, gt=0.0, unit="m", meaning="With interaction: circular, gap over which a push fades.")

NO_FORCE = 0.0, 0.0
"""The further force on a body that walks alone [m/s2]."""


@kind
class SocialForce(RenewsGoals):
    """Follow the sum of a pull to the goal and pushes from bodies and walls."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which other bodies are avoided.")
    vmax: float = SPEED
    neighbor_threshold: float = NEIGHBORS
    relaxation_time: float = RELAXATION
    force_factor_desired: float = DESIRED
    force_factor_social: float = SOCIAL
    force_factor_obstacle: float = OBSTACLE
    sigma_obstacle: float = SIGMA
    lambda_importance: float = IMPORTANCE
    gamma: float = GAMMA
    n_angular: float = ANGULAR
    n_velocity: float = VELOCITY
    safety_radius: float = SAFETY
    interaction: Literal["moussaid", "circular"] = INTERACTION
    interaction_range: float = RANGE

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from renewal_problems(self)

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate scratch memory for the bodies and walls that one body sees."""
        group.tables = [SocialTables.reserve(group, model, together=False) for _ in range(n_slots)]

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the members' commands."""
        decide_social_force(shard.worlds, group.members, group.params, model, state, group.tables[shard.slot])


@kernel
def decide_social_force(
    worlds: Ints, members: Ints, params: Any, model: Model, state: State, tables: SocialTables
) -> None:
    """Write the commands of bodies that follow social forces; bodies without a goal stand still.

    Reads: model (acceleration_limit, bucket_frame, centroid, disc_count, disc_start, drawn_speed, drive, has_goal,
        heedless, map_disc, map_frame, map_squares, movable, present, radius, reach, role, seen_row, segment_count,
        segment_start, solid, step_time, velocity_max, watchers), state (bucket_first, bucket_next, discs, goal, pose,
        segments, twist, velocity), tables (among, by_hypot, discs, lines, nearby, nearest, sides).
    Writes: state (command), tables (discs, nearby, nearest, sides).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            clear_command(state, w, b)
            if model.has_goal[b] and model.present[w, b]:
                wanted = wanted_velocity(model, state, w, b)
                follow(model, state, w, b, planned_velocity(model, state, w, b, params[k], wanted, NO_FORCE, tables))
