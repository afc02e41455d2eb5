"""Optimal reciprocal collision avoidance (van den Berg, Guy, Lin, Manocha: Reciprocal n-body collision avoidance, 2011)."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.orca_lines import away, disc_plane
from irsim_gym.behaviors.orca_neighbors import find_nearest, find_walls
from irsim_gym.behaviors.orca_walls import EDGE, is_covered, see_edge, wall_plane
from irsim_gym.behaviors.steering import to_command
from irsim_gym.geometry.linear_program import choose
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import DIFFERENTIAL, WorldModel
from irsim_gym.world.state import WorldState

AT_GOAL = 0.1
"""An omnidirectional body this near to its goal wants to stand still [m]."""

TOLERANCE = 0.1
"""A differential body does not turn for a smaller angle [rad]."""

SLOW = 0.02
"""A differential body does not move for a lower speed [m/s]."""

HALF, WHOLE = 0.5, 1.0


@kind
class OrcaGroup:
    """All bodies of a group avoid each other, each taking half of the effort, and what never moves."""

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

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Mark who is avoided, and make scratch memory."""
        n_bodies, n_parts = len(model.role), model.local_segments.shape[1] + model.local_discs.shape[1]
        is_member = np.zeros(n_bodies, np.bool_)
        is_member[group.members] = True
        is_wall = ~model.movable & ~model.unobstructed
        most = min(group.options[0].maxNeighbors, len(group.members))
        group.arrays |= {
            "seen": is_member & model.movable & ~model.unobstructed,
            "is_wall": is_wall,
            "walls": np.flatnonzero(is_wall),
            "deciding": group.members[group.arrays["decides"]],
            "found": np.zeros((n_slots, n_bodies), np.int64),
            "nearest": np.zeros((n_slots, most), np.int64),
            "nearest_gap": np.zeros((n_slots, most)),
            "parts": np.zeros((n_slots, n_parts), np.int64),
            "parts_gap": np.zeros((n_slots, n_parts)),
            "owners": np.zeros((n_slots, n_parts), np.int64),
            "edge": np.zeros((n_slots, EDGE)),
            "planes": np.zeros((n_slots, n_parts + most, 3)),
            "spare": np.zeros((n_slots, n_parts + most, 3)),
        }
        decides = np.zeros(n_bodies, np.bool_)
        decides[group.arrays["deciding"]] = True
        group.arrays["plans"] = decides

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands and ``state.plan``; all see each other as they were before."""
        arrays, slot = group.arrays, shard.slot
        if not len(arrays["deciding"]):
            return
        plan_velocities(
            shard.worlds,
            arrays["deciding"],
            group.params,
            model.step_time,
            model.drive,
            model.velocity_max,
            model.radius,
            model.has_goal,
            model.present,
            arrays["seen"],
            arrays["plans"],
            model.bucket_frame,
            state.bucket_first,
            state.bucket_next,
            state.pose,
            state.twist,
            state.goal,
            state.plan,
            arrays["walls"],
            arrays["is_wall"],
            model.reach,
            model.solid,
            model.segment_start,
            model.segment_count,
            state.segments,
            model.disc_start,
            model.disc_count,
            state.discs,
            arrays["found"][slot],
            arrays["nearest_gap"][slot],
            arrays["nearest"][slot],
            arrays["parts_gap"][slot],
            arrays["parts"][slot],
            arrays["owners"][slot],
            arrays["edge"][slot],
            arrays["planes"][slot],
            arrays["spare"][slot],
            state.command,
        )
        command_plans(
            shard.worlds,
            arrays["deciding"],
            model.step_time,
            model.drive,
            model.velocity_max,
            model.present,
            state.pose,
            state.plan,
            state.command,
        )


@kernel
def speed_cap(drive: int, fastest: Floats, most: float) -> float:
    """Return the speed [m/s] that a drive can hold in every direction, no more than ``most`` (NaN: no bound)."""
    speed = fastest[0] if drive == DIFFERENTIAL else min(fastest[0], fastest[1])
    return float(max(min(speed, most) if most == most else speed, 0.0))


@kernel
def preferred_velocity(
    drive: int, fastest: Floats, speed: float, dx: float, dy: float
) -> tuple[float, float]:
    """Return the velocity [m/s] towards a goal at (dx, dy) [m].

    As in IR-SIM, an omnidirectional body stops near its goal and leans to the axis on which it is faster; a
    differential one always drives at full speed.
    """
    if drive == DIFFERENTIAL:
        angle = np.arctan2(dy, dx)
        return speed * np.cos(angle), speed * np.sin(angle)
    distance = np.sqrt(dx * dx + dy * dy)
    if distance <= AT_GOAL:
        return 0.0, 0.0
    vx, vy = fastest[0] * dx / distance, fastest[1] * dy / distance
    length = np.sqrt(vx * vx + vy * vy)
    if length < 1e-9:
        return 0.0, 0.0
    return speed * vx / length, speed * vy / length


@kernel
def plan_velocities(
    worlds: Ints,
    deciding: Ints,
    params: Any,
    step_time: Floats,
    drive: Ints,
    velocity_max: Floats,
    radius: Floats,
    has_goal: Flags,
    present: Flags,
    seen: Flags,
    plans: Flags,
    frame: Floats,
    bucket_first: Ints,
    bucket_next: Ints,
    pose: Floats,
    twist: Floats,
    goal: Floats,
    plan: Floats,
    walls: Ints,
    is_wall: Flags,
    reach: Floats,
    solid: Flags,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    found: Ints,
    nearest_gap: Floats,
    nearest: Ints,
    parts_gap: Floats,
    parts: Ints,
    owners: Ints,
    edge: Floats,
    planes: Floats,
    spare: Floats,
    command: Floats,
) -> None:
    """Write the velocities that the members choose, in the world frame, to the first two components of ``command``."""
    options = params[0]
    for i in range(worlds.shape[0]):
        w = worlds[i]
        radii = radius[w % radius.shape[0]]
        for k in range(deciding.shape[0]):
            b = deciding[k]
            if not present[w, b]:
                continue
            fastest = velocity_max[w % velocity_max.shape[0], b]
            speed, own = speed_cap(drive[b], fastest, options.maxSpeed), radii[b] + options.safe_radius
            n_parts, n_hard = 0, 0
            if walls.shape[0] > 0:
                n_parts = find_walls(
                    pose[w, b, 0], pose[w, b, 1], options.timeHorizonObst * speed + own, walls, is_wall, frame,
                    bucket_first[w], bucket_next[w], present[w], pose[w], reach[w % reach.shape[0]],
                    segment_start, segment_count[w % segment_count.shape[0]], segments[w],
                    disc_start, disc_count[w % disc_count.shape[0]], discs[w],
                    found, parts_gap, parts, owners,
                )  # fmt: skip
                n_hard = add_walls(
                    parts[:n_parts], owners, own, options.timeHorizonObst, pose[w, b], plan[w, b], solid,
                    segment_start, segment_count[w % segment_count.shape[0]], segments[w], discs[w], edge, planes,
                )  # fmt: skip
            n_near = find_nearest(
                b, options.neighborDist, frame, bucket_first[w], bucket_next[w], seen, present[w], pose[w],
                found, nearest_gap, nearest,
            )  # fmt: skip
            for j in range(n_near):
                q = nearest[j]
                both = own + radii[q] + options.safe_radius
                overlap = nearest_gap[j] <= both * both
                other = plan[w, q] if plans[q] else twist[w, q]
                disc_plane(
                    pose[w, q, 0] - pose[w, b, 0], pose[w, q, 1] - pose[w, b, 1],
                    plan[w, b, 0], plan[w, b, 1], other[0], other[1],
                    both, step_time[0] if overlap else options.timeHorizon, HALF, planes[n_hard + j],
                )  # fmt: skip
            wanted_x, wanted_y = 0.0, 0.0
            if has_goal[b]:
                wanted_x, wanted_y = preferred_velocity(
                    drive[b], fastest, speed, goal[w, b, 0] - pose[w, b, 0], goal[w, b, 1] - pose[w, b, 1]
                )
            command[w, b, 0], command[w, b, 1] = choose(
                planes, n_hard, n_hard + n_near, speed, wanted_x, wanted_y, spare
            )


@kernel
def add_walls(
    parts: Ints,
    owners: Ints,
    radius: float,
    horizon: float,
    pose: Floats,
    velocity: Floats,
    solid: Flags,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    discs: Floats,
    edge: Floats,
    planes: Floats,
) -> int:
    """Write the half-planes of what never moves, as ``find_walls`` found it; return their number.

    A disc that is touched already need not be left at once, as a wall need not; only going nearer is forbidden.
    """
    count = 0
    for i in range(parts.shape[0]):
        s, q = parts[i], owners[parts[i]]
        if s >= segments.shape[0]:
            d = s - segments.shape[0]
            x, y, both = discs[d, 0] - pose[0], discs[d, 1] - pose[1], discs[d, 2] + radius
            gap2 = x * x + y * y
            if gap2 <= both * both:
                planes[count, 0], planes[count, 1] = away(-x, -y, np.sqrt(gap2), x, y)
                planes[count, 2] = 0.0
            else:
                disc_plane(x, y, velocity[0], velocity[1], 0.0, 0.0, both, horizon, WHOLE, planes[count])
            count += 1
        elif see_edge(segments, segment_start[q], segment_count[q], s, solid[q], pose[0], pose[1], edge):
            covered = is_covered(planes, count, edge[0], edge[1], edge[2], edge[3], radius, horizon)
            if not covered and wall_plane(edge, velocity[0], velocity[1], radius, horizon, planes[count]):
                count += 1
    return count


@kernel
def command_plans(
    worlds: Ints,
    deciding: Ints,
    step_time: Floats,
    drive: Ints,
    velocity_max: Floats,
    present: Flags,
    pose: Floats,
    plan: Floats,
    command: Floats,
) -> None:
    """Keep the chosen velocities as plans, and turn them into commands of the drives."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(deciding.shape[0]):
            b = deciding[k]
            if not present[w, b]:
                continue
            plan[w, b, 0], plan[w, b, 1] = command[w, b, 0], command[w, b, 1]
            to_command(
                drive[b],
                pose[w, b, 2],
                plan[w, b, 0],
                plan[w, b, 1],
                step_time[0],
                TOLERANCE,
                SLOW,
                velocity_max[w % velocity_max.shape[0], b, 1],
                command[w, b],
            )
