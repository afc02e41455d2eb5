"""random: uniform in a box, clear of everything, with a goal that can be reached."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Words
from irsim_gym.geometry.frames import place_outline
from irsim_gym.geometry.overlap import outline_distance, outlines_overlap, point_outline_distance
from irsim_gym.jit import kernel
from irsim_gym.placements.manual import world_box
from irsim_gym.rng import uniform
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WANDER, WorldModel
from irsim_gym.world.state import WorldState

MARGIN = 0.5
START_TRIES = 1000
GOAL_TRIES = 100
PATH_TRIES = 8


@kind
class RandomPlacement:
    """Uniform draws without any overlap; a draw that fails too often is an error that names the body."""

    is_random: ClassVar[bool] = True
    gives_goal: ClassVar[bool] = True

    range_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds; by default the world drawn in by 0.5 m, and -pi."
    )
    range_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds; by default the world drawn in by 0.5 m, and pi."
    )
    min_distance: float = option(
        1.0, ge=0.0, unit="m", meaning="Least distance between the origins (and between the goals) of one entry."
    )
    clearance: float = option(0.0, ge=0.0, unit="m", meaning="Surface distance kept from everything else.")
    min_goal_distance: float = option(0.0, ge=0.0, unit="m", meaning="Least distance from start to goal.")
    reachable: bool = option(
        False, meaning="Hand out only goals that a disc around the body can reach past the static bodies."
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        if self.range_low is not None and self.range_high is not None:
            yield from crossed_bounds(self.range_low, self.range_high)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Settle the bounds."""
        options = group.options[0]
        low, high = world_box(model, MARGIN)
        group.arrays["low"] = low if options.range_low is None else np.array(options.range_low, np.float64)
        group.arrays["high"] = high if options.range_high is None else np.array(options.range_high, np.float64)

    @staticmethod
    def draw(group: Group, model: WorldModel, state: WorldState, shard: Shard, failed: Ints) -> None:
        """Draw starts and goals; ``failed[w]`` becomes body + 1 where a member found no place."""
        shapes = (
            model.present,
            model.solid,
            model.reach,
            model.segment_start,
            model.segment_count,
            model.local_segments,
            model.disc_start,
            model.disc_count,
            model.local_discs,
        )
        targets = (model.has_goal, model.movable, model.goal_renewal, model.waypoints)
        scene = (state.pose, state.segments, state.discs, state.placed)
        draw_members(
            shard.worlds,
            group.members,
            group.params[0],
            group.arrays["low"],
            group.arrays["high"],
            shapes,
            targets,
            scene,
            state.random,
            failed,
        )


@kernel
def draw_members(
    worlds: Ints,
    members: Ints,
    options: Any,
    low: Floats,
    high: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    random: Words,
    failed: Ints,
) -> None:
    """Place one member after the other in each world, until one finds no place."""
    present, has_goal, placed = shapes[0], targets[0], scene[3]
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for k in range(members.shape[0]):
            b = members[k]
            if failed[w] > 0 or not present[w, b]:
                continue
            for _ in range(PATH_TRIES if has_goal[b] else 1):
                placed[w, b] = draw_start(w, k, members, options, low, high, shapes, targets, scene, random) and (
                    not has_goal[b] or draw_goal(w, k, members, options, low, high, shapes, targets, scene, random)
                )
                if placed[w, b]:
                    break
            if not placed[w, b]:
                failed[w] = b + 1


@kernel
def draw_start(
    w: int,
    k: int,
    members: Ints,
    options: Any,
    low: Floats,
    high: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    random: Words,
) -> bool:
    """Draw a pose for member k that is clear of everything placed so far; return whether there is one."""
    _, _, _, segment_start, segment_count, local_segments, disc_start, disc_count, local_discs = shapes
    pose, segments, discs, _ = scene
    b = members[k]
    for _ in range(START_TRIES):
        for axis in range(3):
            pose[w, b, axis] = uniform(random, w, low[axis], high[axis])
        if not is_spaced(pose[w], members, k, options.min_distance, shapes[0][w]):
            continue
        place_outline(
            local_segments[w % local_segments.shape[0]],
            local_discs[w % local_discs.shape[0]],
            segment_start[b],
            segment_count[w % segment_count.shape[0], b],
            disc_start[b],
            disc_count[w % disc_count.shape[0], b],
            pose[w, b, 0],
            pose[w, b, 1],
            pose[w, b, 2],
            segments[w],
            discs[w],
        )
        if is_start_free(w, b, options.clearance, shapes, targets, scene):
            return True
    return False


@kernel
def is_spaced(points: Floats, members: Ints, k: int, spacing: float, present: Flags) -> bool:
    """Return whether point ``members[k]`` keeps its distance from those of the earlier members."""
    b = members[k]
    for earlier in range(k):
        q = members[earlier]
        dx, dy = points[q, 0] - points[b, 0], points[q, 1] - points[b, 1]
        if present[q] and dx * dx + dy * dy < spacing * spacing:
            return False
    return True


@kernel
def is_start_free(w: int, b: int, clearance: float, shapes: Any, targets: Any, scene: Any) -> bool:
    """Return whether body b, where its outline stands, is clear of all placed bodies.

    A body that will not move is clear of the placed bodies' goals too.
    """
    present, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    has_goal, movable, goal_renewal, waypoints = targets
    pose, segments, discs, placed = scene
    row, n_segments, n_discs = w % reach.shape[0], w % segment_count.shape[0], w % disc_count.shape[0]
    own_segments, own_discs = segment_count[n_segments, b], disc_count[n_discs, b]
    for q in range(present.shape[1]):
        if q == b or not placed[w, q] or not present[w, q]:
            continue
        if has_goal[q] and not movable[b] and goal_renewal[q] != WANDER:
            goal = waypoints[w, q, 0]
            gap = point_outline_distance(
                goal[0], goal[1], segments[w], segment_start[b], own_segments,
                discs[w], disc_start[b], own_discs, solid[b],
            )  # fmt: skip
            if gap < reach[row, q] + clearance:
                return False
        dx, dy = pose[w, q, 0] - pose[w, b, 0], pose[w, q, 1] - pose[w, b, 1]
        near = reach[row, b] + reach[row, q] + clearance
        if dx * dx + dy * dy > near * near * (1.0 + 1e-12):
            continue
        if is_closer(
            clearance,
            segments[w],
            segment_start[b],
            own_segments,
            discs[w],
            disc_start[b],
            own_discs,
            solid[b],
            segment_start[q],
            segment_count[n_segments, q],
            disc_start[q],
            disc_count[n_discs, q],
            solid[q],
        ):
            return False
    return True


@kernel
def is_closer(
    clearance: float,
    segments: Floats,
    first_a: int,
    count_a: int,
    discs: Floats,
    disc_a: int,
    discs_a: int,
    solid_a: bool,
    first_b: int,
    count_b: int,
    disc_b: int,
    discs_b: int,
    solid_b: bool,
) -> bool:
    """Return whether two outlines of one world touch, or come closer than ``clearance`` [m]."""
    if clearance <= 0.0:
        return bool(
            outlines_overlap(
                segments, first_a, count_a, discs, disc_a, discs_a, solid_a,
                segments, first_b, count_b, discs, disc_b, discs_b, solid_b,
            )
        )  # fmt: skip
    return bool(
        outline_distance(
            segments, first_a, count_a, discs, disc_a, discs_a, solid_a,
            segments, first_b, count_b, discs, disc_b, discs_b, solid_b, clearance,
        ) < clearance
    )  # fmt: skip


@kernel
def draw_goal(
    w: int,
    k: int,
    members: Ints,
    options: Any,
    low: Floats,
    high: Floats,
    shapes: Any,
    targets: Any,
    scene: Any,
    random: Words,
) -> bool:
    """Draw a goal for member k that its footprint can stand on; return whether there is one."""
    waypoints, pose = targets[3], scene[0]
    b = members[k]
    goal = waypoints[w, b, 0]
    for _ in range(GOAL_TRIES):
        for axis in range(3):
            goal[axis] = uniform(random, w, low[axis], high[axis])
        dx, dy = goal[0] - pose[w, b, 0], goal[1] - pose[w, b, 1]
        if dx * dx + dy * dy < options.min_goal_distance * options.min_goal_distance:
            continue
        if not is_spaced(waypoints[w, :, 0], members, k, options.min_distance, shapes[0][w]):
            continue
        if is_goal_free(w, b, options.clearance, shapes, targets, scene):
            return True
    return False


@kernel
def is_goal_free(w: int, b: int, clearance: float, shapes: Any, targets: Any, scene: Any) -> bool:
    """Return whether a disc around body b at its goal is clear of placed static bodies and of others' goals."""
    present, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    has_goal, movable, goal_renewal, waypoints = targets
    pose, segments, discs, placed = scene
    row, n_segments, n_discs = w % reach.shape[0], w % segment_count.shape[0], w % disc_count.shape[0]
    x, y = waypoints[w, b, 0, 0], waypoints[w, b, 0, 1]
    for q in range(present.shape[1]):
        if q == b or not placed[w, q] or not present[w, q]:
            continue
        if has_goal[q] and goal_renewal[q] != WANDER:
            dx, dy = waypoints[w, q, 0, 0] - x, waypoints[w, q, 0, 1] - y
            apart = reach[row, b] + reach[row, q]
            if dx * dx + dy * dy < apart * apart:
                return False
        if movable[q]:
            continue
        dx, dy = pose[w, q, 0] - x, pose[w, q, 1] - y
        near = reach[row, b] + reach[row, q] + clearance
        if dx * dx + dy * dy > near * near:
            continue
        gap = point_outline_distance(
            x,
            y,
            segments[w],
            segment_start[q],
            segment_count[n_segments, q],
            discs[w],
            disc_start[q],
            disc_count[n_discs, q],
            solid[q],
        )
        if gap < reach[row, b] + clearance:
            return False
    return True
