"""Social forces of a group: all members decide from the same moment, and further forces keep parties together.

The forces within a party are those of Moussaid et al. (2010), as in IR-SIM: coherence, repulsion and gaze.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from irsim_gym.base.arraytypes import Flags, Ints, Vector
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.bodies.behaviors.shared.steering import clear_command, wanted_velocity
from irsim_gym.bodies.behaviors.shared.surroundings import MARGIN
from irsim_gym.bodies.behaviors.social_force.pushes import follow, planned_velocity
from irsim_gym.bodies.behaviors.social_force.social_force import SocialForces
from irsim_gym.bodies.behaviors.social_force.walls import SocialTables
from irsim_gym.simulator.world.names import Group, Model, Shard, State, Struct, kernel, kind, option, row_of


@kind
class SocialForceGroup(SocialForces):
    """The same for all bodies of a group, which may walk together in smaller ones.

    All members decide from the same moment. ``social_groups`` counts members in the order of the file, from 0.
    """

    social_groups: tuple[tuple[int, ...], ...] = option((), meaning="Lists of members who walk together.")
    force_factor_coherence: float = option(2.0, ge=0.0, meaning="Weight of the pull to the others of the list.")
    force_factor_group_repulsion: float = option(1.0, ge=0.0, meaning="Weight of the push from those too near.")
    group_repulsion_threshold: float | None = option(
        None, ge=0.0, unit="m", meaning="A member closer than this is too near; default: when the bodies touch."
    )
    force_factor_gaze: float = option(3.0, ge=0.0, meaning="Weight of the force that keeps the others in sight.")
    gaze_vision_angle: float = option(90.0, gt=0.0, le=180.0, unit="deg", meaning="Others are seen up to this angle.")
    interaction_range: float = option(1.0, gt=0.0, unit="m", meaning="With circular interaction, reach of a push.")

    def further_problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        listed = [member for party in self.social_groups for member in party]
        for member in sorted({one for one in listed if listed.count(one) > 1}):
            yield "social_groups", f"member {member} is listed twice"
        if any(member < 0 for member in listed):
            yield "social_groups", f"members are counted from 0, got {min(listed)}"

    def without_member(self, member: int) -> Self:
        """Return these options for a group that has lost a member; later members move up by one."""
        # Members are named by their numbers: those behind the lost one move up.
        parties = (tuple(one - (one > member) for one in party if one != member) for party in self.social_groups)
        return replace(self, social_groups=tuple(party for party in parties if party))

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Allocate scratch memory and number the parties of members.

        Raises:
            IrsimGymError: If a party names a member that the group does not have.
        """
        party = np.full(len(group.members), -1)
        for number, listed in enumerate(group.options[0].social_groups):
            if listed and max(listed) >= len(party):
                raise IrsimGymError(
                    f"group_behavior.social_groups names member {max(listed)}, but the group has {len(party)} members, "
                    f"counted from 0"
                )
            party[list(listed)] = number
        group.tables = [
            PartyTables(group.arrays["decides"], party, SocialTables.reserve(group, model, together=True))
            for _ in range(n_slots)
        ]

    @staticmethod
    def decide(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Write the commands of the members that decide."""
        decide_social_group(shard.worlds, group.members, group.params, model, state, group.tables[shard.slot])


@dataclass
class PartyTables(Struct):
    """Tables for the decisions of a group's members; each shard has its own.

    Attributes:
        decides: Whether each member's command is written, shape ``(n_members,)``.
        party: Number of each member's party, -1 for none, shape ``(n_members,)``.
        forces: Tables for the forces.
    """

    decides: Flags
    party: Ints
    forces: SocialTables


@kernel
def decide_social_group(
    worlds: Ints, members: Ints, params: Any, model: Model, state: State, tables: PartyTables
) -> None:
    """Write the commands of the members; members without a goal stay, but give way.

    Reads: model (acceleration_limit, bucket_frame, centroid, disc_count, disc_start, drawn_speed, drive, has_goal,
        heedless, map_disc, map_frame, map_squares, movable, present, radius, reach, role, seen_row, segment_count,
        segment_start, solid, step_time, velocity_max, watchers), state (bucket_first, bucket_next, discs, goal, pose,
        segments, twist, velocity), tables (decides, forces, party).
    Writes: state (command), tables (forces).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            if not tables.decides[k]:
                continue
            clear_command(state, w, b)
            if model.present[w, b]:
                wanted = wanted_velocity(model, state, w, b) if model.has_goal[b] else (0.0, 0.0)
                extra = force_of_party(model, state, w, k, members, tables.party, params[k])
                velocity = planned_velocity(model, state, w, b, params[k], wanted, extra, tables.forces)
                follow(model, state, w, b, velocity)


@kernel
def force_of_party(model: Model, state: State, w: int, k: int, members: Ints, party: Ints, options: Any) -> Vector:
    """Return the force that keeps member k with the others of its party: coherence, repulsion and gaze [m/s2].

    Reads: model (present, radius), state (pose, twist).
    """
    if party[k] < 0:
        return 0.0, 0.0
    b, pose, radius = members[k], state.pose[w], model.radius[row_of(model.radius, w)]
    x, y, r = pose[b, 0], pose[b, 1], radius[b] + MARGIN
    count, sum_x, sum_y, push_x, push_y = 0, 0.0, 0.0, 0.0, 0.0
    for other in range(members.shape[0]):
        q = members[other]
        if party[other] != party[k] or not model.present[w, q]:
            continue
        count += 1
        sum_x, sum_y = sum_x + pose[q, 0], sum_y + pose[q, 1]
        dx, dy = x - pose[q, 0], y - pose[q, 1]
        # NaN stands for the default: the members' discs touch.
        near = options.group_repulsion_threshold
        if np.isnan(near):
            near = r + (radius[q] + MARGIN)
        if q != b and np.hypot(dx, dy) < near:
            push_x, push_y = push_x + dx, push_y + dy
    if count < 2:
        return 0.0, 0.0
    mean_x, mean_y = sum_x / count, sum_y / count
    # A soft switch between 0 and 1: one half at (count - 1) / 2 metres from the centre of the party.
    pull = (np.tanh(np.hypot(mean_x - x, mean_y - y) - (count - 1.0) / 2.0) + 1.0) / 2.0
    # The mean of the others, from that of all.
    others_x, others_y = (count * mean_x - x) / (count - 1.0), (count * mean_y - y) / (count - 1.0)
    vx, vy = state.twist[w, b, 0], state.twist[w, b, 1]
    turn = head_turn((vx, vy), (others_x - x, others_y - y), options.gaze_vision_angle * np.pi / 180.0)
    coherence, repulsion = options.force_factor_coherence, options.force_factor_group_repulsion
    gaze = options.force_factor_gaze
    return (
        coherence * ((mean_x - x) * pull) + repulsion * push_x - gaze * (turn * vx),
        coherence * ((mean_y - y) * pull) + repulsion * push_y - gaze * (turn * vy),
    )


@kernel
def head_turn(velocity: Vector, offset: Vector, sight: float) -> float:
    """Return the angle [rad] by which a walker has to turn its head to see a point at an offset [m]."""
    vx, vy, dx, dy = velocity[0], velocity[1], offset[0], offset[1]
    speed, distance = np.hypot(vx, vy), np.hypot(dx, dy)
    if speed <= 1e-9 or distance <= 1e-9:
        return 0.0
    cosine = (vx * dx + vy * dy) / (speed * distance)
    return float(max(np.arccos(max(min(cosine, 1.0), -1.0)) - sight, 0.0))
