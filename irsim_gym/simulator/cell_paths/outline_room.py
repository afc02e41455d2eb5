"""The distance of an outline at any pose from obstacles."""

from typing import NamedTuple

import numpy as np

from irsim_gym.simulator.cell_maps.world_maps import outline_map_distance
from irsim_gym.simulator.geometry.overlap import outline_distance
from irsim_gym.simulator.geometry.polygons import holds_point
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.paths.clearance import Obstacles
from irsim_gym.simulator.world.names import BodyOutline, Model, Pose, kernel, outline_of, own_outline, row_of


class PoseShape(NamedTuple):
    """The outline of a body for tests at any pose.

    Attributes:
        own: The outline in the body's frame.
        laid: Scratch: the outline at a pose.
        reach: Radius of the disc about the body's origin that encloses it [m].
    """

    own: BodyOutline
    laid: BodyOutline
    reach: float


@kernel
def lay_outline(outline: BodyOutline, pose: Pose, laid: BodyOutline) -> None:
    """Write an outline as it stands at a pose x, y, heading [m, m, rad].

    Args:
        outline: The outline in its body's frame.
        pose: The pose.
        laid: Its rows of segments and discs are written; as many as ``outline`` has.
    """
    x, y, cosine, sine = pose[0], pose[1], np.cos(pose[2]), np.sin(pose[2])
    for k in range(outline.n_segments):
        side, other = outline.segments[outline.first_segment + k], laid.segments[laid.first_segment + k]
        other[0] = x + (cosine * side[0] - sine * side[1])
        other[1] = y + (sine * side[0] + cosine * side[1])
        other[2] = x + (cosine * side[2] - sine * side[3])
        other[3] = y + (sine * side[2] + cosine * side[3])
    for k in range(outline.n_discs):
        side, other = outline.discs[outline.first_disc + k], laid.discs[laid.first_disc + k]
        other[0] = x + (cosine * side[0] - sine * side[1])
        other[1] = y + (sine * side[0] + cosine * side[1])
        other[2] = side[2]


@kernel
def room_at_pose(obstacles: Obstacles, shape: PoseShape, pose: Pose, limit: float) -> float:
    """Return the distance [m] of a body from obstacles, 0 if they touch, ``limit`` if none is nearer.

    Reads: obstacles (blocks, cells, model, state, w).

    Args:
        obstacles: What is in the way; points do not count.
        shape: The body's outline.
        pose: Where it is: x, y, heading [m, m, rad].
        limit: Upper bound of the result [m].
    """
    lay_outline(shape.own, pose, shape.laid)
    model, poses, w, best = obstacles.model, obstacles.state.pose[obstacles.w], obstacles.w, limit
    for b in range(obstacles.blocks.shape[0]):
        if not obstacles.blocks[b]:
            continue
        dx, dy = poses[b, 0] - pose[0], poses[b, 1] - pose[1]
        # Bodies whose enclosing discs are no nearer than the best so far are left out.
        far = model.reach[row_of(model.reach, w), b] + shape.reach + best
        if dx * dx + dy * dy < far * far:
            best = outline_distance(shape.laid, outline_of(model, obstacles.state, w, b), best)
            if best <= 0.0:
                return 0.0
    return outline_map_distance(obstacles.cells, w, shape.laid, best)


@kernel
def largest_disc(model: Model, w: int, b: int) -> float:
    """Return the radius [m] of the largest disc about the origin of body b of world w that lies inside the body.

    It is 0 if the origin lies outside. If the outline has several parts, the disc lies inside a single one.

    Reads: model (disc_count, disc_start, local_discs, local_segments, segment_count, segment_start, solid).
    """
    outline = own_outline(model, w, b)
    best, least2, segments, discs = 0.0, np.inf, outline.segments, outline.discs
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        best = max(best, discs[d, 2] - np.sqrt(discs[d, 0] * discs[d, 0] + discs[d, 1] * discs[d, 1]))
    if not outline.solid or not holds_point(outline, (0.0, 0.0)):
        return best
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        least2 = min(least2, point_segment_distance2(0.0, 0.0, ax, ay, bx, by))
    return float(max(best, np.sqrt(least2)))
