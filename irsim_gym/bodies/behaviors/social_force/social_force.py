"""Social forces (Moussaid et al. 2009): a goal pulls a body, and other bodies and walls push it."""

from typing import Any, ClassVar, Literal

from irsim_gym.bodies.behaviors.shared.steering import clear_command, wanted_velocity
from irsim_gym.bodies.behaviors.social_force.pushes import follow, planned_velocity
from irsim_gym.bodies.behaviors.social_force.walls import SocialTables
from irsim_gym.scenario.specs.wander_goals import RenewsGoals
from irsim_gym.simulator.world.names import Group, Ints, Model, Shard, State, kernel, kind, option

NO_FORCE = 0.0, 0.0
"""The further force on a body that walks alone [m/s2]."""


@kind
class SocialForces(RenewsGoals):
    """The options that bodies and groups under social forces share."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which other bodies are avoided.")
    vmax: float = option(1.5, gt=0.0, unit="m/s", meaning="Desired and maximum speed.")
    neighbor_threshold: float = option(10.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")
    relaxation_time: float = option(0.5, gt=0.0, unit="s", meaning="Time in which the desired velocity is taken up.")
    force_factor_desired: float = option(1.0, ge=0.0, meaning="Weight of the force towards the goal.")
    force_factor_social: float = option(2.1, ge=0.0, meaning="Weight of the force away from other bodies.")
    force_factor_obstacle: float = option(10.0, ge=0.0, meaning="Weight of the force away from walls.")
    sigma_obstacle: float = option(0.8, gt=0.0, unit="m", meaning="Distance over which the force of a wall fades.")
    lambda_importance: float = option(2.0, ge=0.0, meaning="Weight of relative velocity against relative position.")
    gamma: float = option(0.35, gt=0.0, unit="s", meaning="Range of the interaction for each m/s of its velocity.")
    n_angular: float = option(2.0, ge=0.0, meaning="Decay of the sideways force with the angle.")
    n_velocity: float = option(3.0, ge=0.0, meaning="Decay of the braking force with the angle.")
    safety_radius: float = option(0.0, ge=0.0, unit="m", meaning="Distance added around each body.")
    interaction: Literal["moussaid", "circular"] = option(
        "moussaid",
        meaning="How others push: by position and velocity (Moussaid et al. 2009), or straight away, fading with the "
        "gap between the discs (circular; Helbing and Molnar 1995).",
    )


@kind
class SocialForce(SocialForces):
    """Follow the sum of a pull to the goal and pushes from bodies and walls."""

    # Not in the base: Numba takes a record that begins as another does for one of its kind.
    interaction_range: float = option(1.0, gt=0.0, unit="m", meaning="With circular interaction, reach of a push.")

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
                pref = wanted_velocity(model, state, w, b)
                follow(model, state, w, b, planned_velocity(model, state, w, b, params[k], pref, NO_FORCE, tables))
