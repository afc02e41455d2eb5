"""The pieces of bodies in the world frame, and the deepest contact of two bodies."""

import numpy as np

from irsim_gym.simulator.cell_maps.cells import cell_range
from irsim_gym.simulator.geometry.separation import APART, Overlap, Piece, overlap
from irsim_gym.simulator.pushing.matter import Matter
from irsim_gym.simulator.pushing.memory import Pushing
from irsim_gym.simulator.world.names import CellMaps, Cells, Floats, Point, Vector, kernel, row_of

NEARBY = 1e-3
"""Edges of the map that are farther from a piece than this [m] are not looked at."""


@kernel
def begin_motion(w: int, slot: int, b: int, push: Pushing, matter: Matter, pose: Floats) -> None:
    """Note where a body is before it is pushed, and place its pieces there.

    Reads: push (motions), matter (centre, corners, first_corner, first_piece, n_corners, rounding).
    Writes: push (corners, motions, spans).
    """
    motion, centre = push.motions[slot, b], matter.centre[row_of(matter.centre, w), b]
    motion.x, motion.y, motion.heading = pose[0], pose[1], pose[2]
    motion.cosine, motion.sine = np.cos(pose[2]), np.sin(pose[2])
    motion.cx = pose[0] + motion.cosine * centre[0] - motion.sine * centre[1]
    motion.cy = pose[1] + motion.sine * centre[0] + motion.cosine * centre[1]
    motion.dx, motion.dy, motion.turn, motion.mark, motion.moves = 0.0, 0.0, 0.0, 0, 0
    place_pieces(w, slot, b, push, matter)


@kernel
def push_body(w: int, slot: int, b: int, by: Vector, angle: float, push: Pushing, matter: Matter) -> None:
    """Push a body by a vector [m], turn it about its centre of mass by an angle [rad], and place its pieces.

    Reads: push (motions), matter (corners, first_corner, first_piece, n_corners, rounding).
    Writes: push (corners, motions, spans).
    """
    motion = push.motions[slot, b]
    if by[0] == 0.0 and by[1] == 0.0 and angle == 0.0:
        return
    motion.moves += 1
    motion.dx += by[0]
    motion.dy += by[1]
    if angle != 0.0:
        motion.turn += angle
        motion.cosine, motion.sine = np.cos(motion.heading + motion.turn), np.sin(motion.heading + motion.turn)
    place_pieces(w, slot, b, push, matter)


@kernel
def pushed_origin(slot: int, b: int, push: Pushing) -> Point:
    """Return where a body's origin is after it was pushed, and turned about its centre of mass [m].

    Reads: push (motions).
    """
    motion = push.motions[slot, b]
    if motion.turn == 0.0:
        return motion.x + motion.dx, motion.y + motion.dy
    x, y = motion.x - motion.cx, motion.y - motion.cy
    cosine, sine = np.cos(motion.turn), np.sin(motion.turn)
    return motion.cx + cosine * x - sine * y + motion.dx, motion.cy + sine * x + cosine * y + motion.dy


@kernel
def place_pieces(w: int, slot: int, b: int, push: Pushing, matter: Matter) -> None:
    """Write the corners of a body's pieces in the world frame, and the boxes around the pieces.

    Reads: push (motions), matter (corners, first_corner, first_piece, n_corners, rounding).
    Writes: push (corners, spans).
    """
    row, motion = row_of(matter.corners, w), push.motions[slot, b]
    x, y = pushed_origin(slot, b, push)
    for i in range(matter.first_piece[b], matter.first_piece[b + 1]):
        x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
        for k in range(matter.first_corner[i], matter.first_corner[i] + matter.n_corners[row, i]):
            ahead, left = matter.corners[row, k, 0], matter.corners[row, k, 1]
            here_x = x + motion.cosine * ahead - motion.sine * left
            here_y = y + motion.sine * ahead + motion.cosine * left
            push.corners[slot, k, 0], push.corners[slot, k, 1] = here_x, here_y
            x0, y0, x1, y1 = min(x0, here_x), min(y0, here_y), max(x1, here_x), max(y1, here_y)
        span, about = push.spans[slot, i], matter.rounding[row, i]
        span[0], span[1], span[2], span[3] = x0 - about, y0 - about, x1 + about, y1 + about


@kernel
def deepest(w: int, slot: int, a: int, b: int, push: Pushing, matter: Matter, cells: Cells) -> Overlap:
    """Return the deepest overlap of a piece of body a with one of body b, the first of equal ones.

    Reads: push (boxes, corners, margin, spans), matter (edge_rank, first_corner, first_piece, n_corners, rounding).
    Writes: push (corners, spans).
    """
    best, row = APART, row_of(matter.n_corners, w)
    for i in range(matter.first_piece[a], matter.first_piece[a + 1]):
        one = matter.first_corner[i], matter.n_corners[row, i], matter.rounding[row, i]
        if one[1] == 0:
            continue
        if cells is not None and b == cells.body:
            found = deepest_in_map(w, slot, a, i, push, matter, cells)
            best = found if found[0] > best[0] else best
            continue
        for k in range(matter.first_piece[b], matter.first_piece[b + 1]):
            other = matter.first_corner[k], matter.n_corners[row, k], matter.rounding[row, k]
            # Two segments on one line touch wherever they are, as in IR-SIM.
            is_near = (one[1] == 2 and other[1] == 2) or not is_apart(push.spans[slot, i], push.spans[slot, k], NEARBY)
            if other[1] > 0 and is_near:
                found = overlap(push.corners[slot], one, other)
                best = found if found[0] > best[0] else best
    return best


@kernel
def deepest_in_map(w: int, slot: int, a: int, piece: int, push: Pushing, matter: Matter, cells: CellMaps) -> Overlap:
    """Return the deepest overlap of a piece of body a with an edge of an occupied cell, or with the disc in one.

    As in IR-SIM, only edges count that body a may reach by itself in this step, however far others push it.

    Reads: push (boxes, corners, margin, spans), matter (edge_rank, first_corner, n_corners, rounding).
    Writes: push (corners, spans).
    """
    corners = push.corners[slot]
    squares = cells.squares[w if w < cells.squares.shape[0] else 0]
    edge = corners.shape[0] - 2, 2 if cells.radius == 0.0 else 1, cells.radius
    columns, rows = squares.shape[1], squares.shape[2]
    row, here, reach = row_of(matter.n_corners, w), push.spans[slot, piece], push.boxes[slot, a]
    own = matter.first_corner[piece], matter.n_corners[row, piece], matter.rounding[row, piece]
    first_i, last_i = cell_range(here[0] - NEARBY, here[2] + NEARBY, cells.x, cells.width, columns)
    first_j, last_j = cell_range(here[1] - NEARBY, here[3] + NEARBY, cells.y, cells.height, rows)
    best, best_rank, span, margin = APART, 0, push.spans[slot, push.spans.shape[1] - 1], push.margin[slot]
    # Each cell with the sides that it shares with free ones: below, left, above, right.
    for i in range(first_i, last_i + 1):
        for j in range(first_j, last_j + 1):
            if squares[0, i, j] > 0:
                continue
            for side in range(4 if cells.radius == 0.0 else 1):
                is_flat, di, dj = side % 2 == 0, int(side == 3), int(side == 2)
                ni, nj = (i, j - 1 + 2 * dj) if is_flat else (i - 1 + 2 * di, j)
                is_inside = 0 <= ni < columns and 0 <= nj < rows and squares[0, ni, nj] == 0
                if is_inside and cells.radius == 0.0:
                    continue
                place_edge(corners, edge, i + di, j + dj, is_flat, cells, span)
                if is_apart(span, here, NEARBY) or is_apart(span, reach, NEARBY + margin):
                    continue
                found = overlap(corners, own, edge)
                rank = 0
                if matter.edge_rank.shape[1] > 0:
                    rank = matter.edge_rank[0 if is_flat else 1, i + di, j + dj]
                if found[0] > best[0] or (found[0] == best[0] and found[0] > -np.inf and rank < best_rank):
                    best, best_rank = found, rank
    return best


@kernel
def place_edge(corners: Floats, edge: Piece, i: int, j: int, is_flat: bool, cells: CellMaps, span: Floats) -> None:
    """Write the ends of an edge of cell (i, j), below it or to its left, and the box around it.

    With discs in cells: the middle of the cell, and the box around the disc.
    """
    k, along, about = edge[0], 0.5 if edge[1] == 1 else 0.0, edge[2]
    span[0], span[1] = cells.x + (i + along) * cells.width, cells.y + (j + along) * cells.height
    span[2], span[3] = span[0], span[1]
    if edge[1] == 2:
        span[2] = cells.x + (i + int(is_flat)) * cells.width
        span[3] = cells.y + (j + int(not is_flat)) * cells.height
        corners[k + 1, 0], corners[k + 1, 1] = span[2], span[3]
    corners[k, 0], corners[k, 1] = span[0], span[1]
    span[0], span[1], span[2], span[3] = span[0] - about, span[1] - about, span[2] + about, span[3] + about


@kernel(inlined=True)
def is_apart(one: Floats, other: Floats, by: float) -> bool:
    """Return whether two boxes, x0, y0, x1, y1 [m], are apart by more than a distance along an axis."""
    return bool(one[0] > other[2] + by or one[2] < other[0] - by or one[1] > other[3] + by or one[3] < other[1] - by)
