"""What a random draw is tested for: spacing, room for start and goal, and a way between them.

The kernels share bundles of arrays: ``shapes`` (present, solid, reach, and the outline tables of the model),
``targets`` (has_goal, stands, goal_renewal, waypoints, waypoint_count), ``scene`` (pose, segments, discs, placed, and
the map's cells or None) and ``grids`` (rigid, blocks, and a coarse and a fine grid as ``paths.regions`` takes them).
"""

from __future__ import annotations

from typing import Any

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.geometry.cells import cells_are_closer, outline_near_cells
from irsim_gym.geometry.overlap import outline_distance, outlines_overlap, point_outline_distance
from irsim_gym.jit import kernel
from irsim_gym.paths.regions import way_exists
from irsim_gym.world.model import KEEP_GOAL, WANDER, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState


def bundles(model: WorldModel, state: WorldState) -> tuple[Any, Any, Any]:
    """Return ``shapes``, ``targets`` and ``scene`` of a simulation."""
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
    targets = (model.has_goal, model.stands, model.goal_renewal, model.waypoints, model.waypoint_count)
    return shapes, targets, (state.pose, state.segments, state.discs, state.placed, model.cells)


@kernel
def is_spaced(
    points: Floats, others: Ints, count: int, is_member: Flags, b: int, spacing: float, present: Flags, placed: Flags
) -> bool:
    """Return whether point ``b`` keeps its distance from those members among ``others[:count]`` that are placed."""
    for i in range(count):
        q = others[i]
        dx, dy = points[q, 0] - points[b, 0], points[q, 1] - points[b, 1]
        if q != b and is_member[q] and present[q] and placed[q] and dx * dx + dy * dy < spacing * spacing:
            return False
    return True


@kernel
def is_start_free(
    w: int, b: int, clearance: float, shapes: Any, targets: Any, scene: Any, others: Ints, count: int
) -> bool:
    """Return whether body b, where its outline stands, is clear of the map and of ``others[:count]`` that are placed.

    A body that will not move is clear of all placed bodies' goals too.
    """
    present, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    stands = targets[1]
    pose, segments, discs, placed, cells = scene
    reaches, n_segments, n_discs = (
        reach[row_of(reach, w)],
        segment_count[row_of(segment_count, w)],
        disc_count[row_of(disc_count, w)],
    )
    own_segments, own_discs = n_segments[b], n_discs[b]
    if outline_near_cells(
        cells, segments[w], segment_start[b], own_segments, discs[w], disc_start[b], own_discs, solid[b], clearance
    ):
        return False
    if stands[b] and not is_clear_of_goals(w, b, clearance, shapes, targets, scene):
        return False
    for i in range(count):
        q = others[i]
        if q == b or not placed[w, q] or not present[w, q]:
            continue
        dx, dy = pose[w, q, 0] - pose[w, b, 0], pose[w, q, 1] - pose[w, b, 1]
        near = reaches[b] + reaches[q] + clearance
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
            n_segments[q],
            disc_start[q],
            n_discs[q],
            solid[q],
        ):
            return False
    return True


@kernel
def is_clear_of_goals(w: int, b: int, clearance: float, shapes: Any, targets: Any, scene: Any) -> bool:
    """Return whether body b, where its outline stands, is clear of the goals of all placed bodies."""
    present, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    has_goal, _, goal_renewal, waypoints, waypoint_count = targets
    _, segments, discs, placed, _ = scene
    reaches, n_segments, n_discs = (
        reach[row_of(reach, w)],
        segment_count[row_of(segment_count, w)],
        disc_count[row_of(disc_count, w)],
    )
    for q in range(present.shape[1]):
        if not has_goal[q] or goal_renewal[q] == WANDER or q == b or not placed[w, q] or not present[w, q]:
            continue
        for k in range(waypoint_count[w, q] if goal_renewal[q] == KEEP_GOAL else 1):
            goal = waypoints[w, q, k]
            gap = point_outline_distance(
                goal[0],
                goal[1],
                segments[w],
                segment_start[b],
                n_segments[b],
                discs[w],
                disc_start[b],
                n_discs[b],
                solid[b],
            )
            if gap < reaches[q] + clearance:
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
def is_goal_free(w: int, b: int, clearance: float, shapes: Any, targets: Any, scene: Any) -> bool:
    """Return whether a disc around body b at its goal is clear of the map, placed static bodies and others' goals."""
    present, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    has_goal, stands, goal_renewal, waypoints, _ = targets
    pose, segments, discs, placed, cells = scene
    reaches, n_segments, n_discs = (
        reach[row_of(reach, w)],
        segment_count[row_of(segment_count, w)],
        disc_count[row_of(disc_count, w)],
    )
    x, y, room = waypoints[w, b, 0, 0], waypoints[w, b, 0, 1], reaches[b] + clearance
    if cells_are_closer(cells, x, y, room):
        return False
    for q in range(present.shape[1]):
        if q == b or not placed[w, q] or not present[w, q]:
            continue
        if has_goal[q] and goal_renewal[q] != WANDER:
            dx, dy = waypoints[w, q, 0, 0] - x, waypoints[w, q, 0, 1] - y
            apart = reaches[b] + reaches[q]
            if dx * dx + dy * dy < apart * apart:
                return False
        if not stands[q]:
            continue
        dx, dy = pose[w, q, 0] - x, pose[w, q, 1] - y
        near = reaches[b] + reaches[q] + clearance
        if dx * dx + dy * dy > near * near:
            continue
        gap = point_outline_distance(
            x,
            y,
            segments[w],
            segment_start[q],
            n_segments[q],
            discs[w],
            disc_start[q],
            n_discs[q],
            solid[q],
        )
        if gap < reaches[b] + clearance:
            return False
    return True


@kernel
def has_way(w: int, b: int, shapes: Any, targets: Any, scene: Any, grids: Any) -> bool:
    """Return whether a disc around body b has a free way to its goal past the placed static bodies.

    What a coarse grid finds is a proof; only where it finds nothing the fine one is asked.
    """
    present, stands, placed = shapes[0], targets[1], scene[3]
    rigid, blocks, coarse, fine = grids
    for q in range(blocks.shape[0]):
        blocks[q] = q != b and placed[w, q] and present[w, q] and stands[q]
    proven = False
    for grid in (coarse, fine):
        proven = proven or has_way_on(w, b, shapes, targets, scene, rigid[0], blocks, grid)
    return proven


@kernel
def has_way_on(w: int, b: int, shapes: Any, targets: Any, scene: Any, rigid: bool, blocks: Flags, grid: Any) -> bool:
    """Return whether a grid proves that there is a way."""
    _, solid, reach, segment_start, segment_count, _, disc_start, disc_count, _ = shapes
    pose, segments, discs, _, cells = scene
    goal = targets[3][w, b, 0]
    outlines = (
        segments[w],
        segment_start,
        segment_count[row_of(segment_count, w)],
        discs[w],
        disc_start,
        disc_count[row_of(disc_count, w)],
        solid,
        blocks,
        cells,
    )
    radius, x, y = reach[row_of(reach, w), b], pose[w, b, 0], pose[w, b, 1]
    return bool(way_exists(outlines, pose[w], rigid, radius, x, y, goal[0], goal[1], grid))
