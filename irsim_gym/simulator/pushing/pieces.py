"""The pieces of bodies in the world frame, and the deepest contact of two bodies."""

import numpy as np

from irsim_gym.base.arraytypes import CellMaps, Floats
from irsim_gym.simulator.cell_maps.cells import cell_range
from irsim_gym.simulator.geometry.separation import APART, Overlap, Piece, overlap
from irsim_gym.simulator.pushing.matter import Matter
from irsim_gym.simulator.pushing.memory import Pushing
from irsim_gym.simulator.world.names import kernel, row_of

NEARBY = 1e-3
"""Edges of the map that are farther from a piece than this [m] are not looked at."""


@kernel
def begin_motion(w: int, slot: int, b: int, push: Pushing, matter: Matter, pose: Floats) -> None:
    """Note where a body is before it is pushed, and place its pieces there.

    Reads: push (motions), matter (centre, corners, first_corner, first_piece).
    Writes: push (corners, motions).
    """
    motion, centre = push.motions[slot, b], matter.centre[row_of(matter.centre, w), b]
    motion.x, motion.y, motion.heading = pose[0], pose[1], pose[2]
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    motion.cx = pose[0] + cosine * centre[0] - sine * centre[1]
    motion.cy = pose[1] + sine * centre[0] + cosine * centre[1]
    motion.dx, motion.dy, motion.turn, motion.mark = 0.0, 0.0, 0.0, 0
    place_pieces(w, slot, b, push, matter)


@kernel
def pushed_origin(slot: int, b: int, push: Pushing) -> tuple[float, float]:
    """Return where a body's origin is after it was pushed, and turned about its centre of mass [m].

    Reads: push (motions).
    """
    motion = push.motions[slot, b]
    x, y = motion.x - motion.cx, motion.y - motion.cy
    cosine, sine = np.cos(motion.turn), np.sin(motion.turn)
    return motion.cx + cosine * x - sine * y + motion.dx, motion.cy + sine * x + cosine * y + motion.dy


@kernel
def place_pieces(w: int, slot: int, b: int, push: Pushing, matter: Matter) -> None:
    """Write the corners of a body's pieces in the world frame.

    Reads: push (motions), matter (corners, first_corner, first_piece).
    Writes: push (corners).
    """
    row, heading = row_of(matter.corners, w), push.motions[slot, b].heading + push.motions[slot, b].turn
    x, y = pushed_origin(slot, b, push)
    cosine, sine = np.cos(heading), np.sin(heading)
    for k in range(matter.first_corner[matter.first_piece[b]], matter.first_corner[matter.first_piece[b + 1]]):
        ahead, left = matter.corners[row, k, 0], matter.corners[row, k, 1]
        push.corners[slot, k, 0] = x + cosine * ahead - sine * left
        push.corners[slot, k, 1] = y + sine * ahead + cosine * left


@kernel
def deepest(w: int, slot: int, a: int, b: int, push: Pushing, matter: Matter, cells: CellMaps | None) -> Overlap:
    """Return the deepest overlap of a piece of body a with one of body b, the first of equal ones.

    Reads: push (boxes, corners, margin), matter (edge_rank, first_corner, first_piece, n_corners, rounding).
    Writes: push (corners).
    """
    best, row = APART, row_of(matter.n_corners, w)
    for i in range(matter.first_piece[a], matter.first_piece[a + 1]):
        one = matter.first_corner[i], matter.n_corners[row, i], matter.rounding[row, i]
        if one[1] == 0:
            continue
        if cells is not None and b == cells.body:
            found = deepest_in_map(w, slot, a, one, push, matter, cells)
            best = found if found[0] > best[0] else best
            continue
        for k in range(matter.first_piece[b], matter.first_piece[b + 1]):
            other = matter.first_corner[k], matter.n_corners[row, k], matter.rounding[row, k]
            if other[1] > 0:
                found = overlap(push.corners[slot], one, other)
                best = found if found[0] > best[0] else best
    return best


@kernel
def deepest_in_map(w: int, slot: int, a: int, piece: Piece, push: Pushing, matter: Matter, cells: CellMaps) -> Overlap:
    """Return the deepest overlap of a piece of body a with an edge of an occupied cell, or with the disc in one.

    As in IR-SIM, only edges count that body a may reach by itself in this step, however far others push it.

    Reads: push (boxes, corners, margin), matter (edge_rank).
    Writes: push (corners).
    """
    corners = push.corners[slot]
    squares = cells.squares[w if w < cells.squares.shape[0] else 0]
    edge = corners.shape[0] - 2, 2 if cells.radius == 0.0 else 1, cells.radius
    columns, rows = squares.shape[1], squares.shape[2]
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for k in range(piece[0], piece[0] + piece[1]):
        x0, x1 = min(x0, corners[k, 0]), max(x1, corners[k, 0])
        y0, y1 = min(y0, corners[k, 1]), max(y1, corners[k, 1])
    about = piece[2] + NEARBY
    first_i, last_i = cell_range(x0 - about, x1 + about, cells.x, cells.width, columns)
    first_j, last_j = cell_range(y0 - about, y1 + about, cells.y, cells.height, rows)
    box, margin, best, best_rank = push.boxes[slot, a], push.margin[slot] + NEARBY, APART, 0
    here = x0 - about, y0 - about, x1 + about, y1 + about
    reach = box[0] - margin, box[1] - margin, box[2] + margin, box[3] + margin
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
                place_edge(corners, edge, i + di, j + dj, is_flat, cells)
                if is_away(corners, edge, here) or is_away(corners, edge, reach):
                    continue
                found = overlap(corners, piece, edge)
                rank = 0
                if matter.edge_rank.shape[1] > 0:
                    rank = matter.edge_rank[0 if is_flat else 1, i + di, j + dj]
                if found[0] > best[0] or (found[0] == best[0] and found[0] > -np.inf and rank < best_rank):
                    best, best_rank = found, rank
    return best


@kernel
def place_edge(corners: Floats, edge: Piece, i: int, j: int, is_flat: bool, cells: CellMaps) -> None:
    """Write the ends of an edge of cell (i, j), below it or to its left; or the middle of the cell, for its disc."""
    k, along = edge[0], 0.5 if edge[1] == 1 else 0.0
    corners[k, 0], corners[k, 1] = cells.x + (i + along) * cells.width, cells.y + (j + along) * cells.height
    if edge[1] == 2:
        corners[k + 1, 0] = cells.x + (i + int(is_flat)) * cells.width
        corners[k + 1, 1] = cells.y + (j + int(not is_flat)) * cells.height


@kernel
def is_away(corners: Floats, edge: Piece, box: tuple[float, float, float, float]) -> bool:
    """Return whether the box around an edge or a disc does not meet a box: x0, y0, x1, y1 [m]."""
    first, last, radius = edge[0], edge[0] + edge[1] - 1, edge[2]
    low_x, high_x = min(corners[first, 0], corners[last, 0]), max(corners[first, 0], corners[last, 0])
    low_y, high_y = min(corners[first, 1], corners[last, 1]), max(corners[first, 1], corners[last, 1])
    return bool(
        low_x - radius > box[2] or high_x + radius < box[0] or low_y - radius > box[3] or high_y + radius < box[1]
    )
