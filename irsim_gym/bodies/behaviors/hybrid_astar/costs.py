"""Costs of paths to a goal without obstacles, by position and heading relative to the goal.

This is the obstacle-free heuristic of Dolgov, Thrun, Montemerlo and Diebel (2008): a car that stands beside its goal is
far from it. Dijkstra's search starts at the goal and follows the moves of the body backwards.
"""

from typing import NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Floats, Pose, Record, Records
from irsim_gym.base.kernels import kernel
from irsim_gym.bodies.behaviors.hybrid_astar.moves import N_HEADINGS, pose_after
from irsim_gym.bodies.behaviors.hybrid_astar.queue import NOBODY, PoseNodes, note_pose, pop, push

COARSE = 2
"""Ratio of the table's resolution to that of the search: cells are so many times as wide, headings so many times fewer.
"""
N_TURNS = N_HEADINGS // COARSE
"""Number of headings in the table."""
LEAST_HALF, FARTHEST = 1, 16
"""Minimum and maximum number of cells from the goal to the edge of the table."""
STEERING = 0.3
"""Cost of a change of how far moves turn [s/rad]."""
TURNS_AWAY = 4.0
"""Extent of the table, in radii of the sharpest arc."""


class Aim(NamedTuple):
    """The goal of a search.

    Attributes:
        x: x of the goal [m].
        y: y of the goal [m].
        heading: Heading at the goal [rad]; NaN for any.
        radius: Distance below which the body has arrived; with a heading, metres and radians combined.
    """

    x: float
    y: float
    heading: float
    radius: float


@kernel
def aim_gap(aim: Aim, pose: Pose) -> float:
    """Return how far a pose is from a goal [m], where radians count like metres."""
    dx, dy, turn = pose[0] - aim.x, pose[1] - aim.y, 0.0
    if aim.heading == aim.heading:
        # The heading NaN, which does not equal itself, admits any.
        turn = (pose[2] - aim.heading + np.pi) % (2.0 * np.pi) - np.pi
    return float(np.sqrt(dx * dx + dy * dy + turn * turn))


@kernel
def seconds_of(options: Record, move: Record, gear: int, turn: float) -> float:
    """Return the cost of a move [s] next to another one: a change of gear costs something, and so does steering.

    Args:
        options: Those of ``HybridAstar``.
        move: The move.
        gear: The gear of the other one; 0 if there is none.
        turn: How far the other one turns [rad].
    """
    # Within a gear, steering has its price; a change of gear has its own, and comes with any steering. Driving back
    # costs no more than driving ahead: with a factor of 1.2, of which the distance of the disc in `cost_to_go` does
    # not know, searches in `parking` took four times as long.
    if gear == move.gear:
        return float(move.seconds + STEERING * np.abs(move.turn - turn))
    return float(move.seconds + (options.change_cost if gear != 0 else 0.0))


@kernel
def lay_costs(options: Record, aim: Aim, cell: float, moves: Records, nodes: PoseNodes, costs: Floats) -> None:
    """Write the costs to a goal at the origin [s]; inf where no way stays within the table.

    Writes: nodes, costs.

    Args:
        options: Those of ``HybridAstar``.
        aim: The goal.
        cell: Side of a cell [m].
        moves: The moves.
        nodes: Scratch.
        costs: Written: the cost in each cell and heading, shape ``(columns, rows, N_TURNS)``; the goal is in their
            middle.
    """
    costs[:] = np.inf
    # count: poses in `nodes`; size: entries in the queue.
    half, count, size = costs.shape[0] // 2, 0, 0
    for i in range(-half, half + 1):
        for j in range(-half, half + 1):
            for k in range(N_TURNS):
                # All cells that count as arrived are goals, at no cost.
                pose = (i * cell, j * cell, 2.0 * np.pi * k / N_TURNS)
                if aim_gap(aim, pose) < aim.radius:
                    count, size = offer_pose(nodes, costs, cell, pose, 0.0, NOBODY, count, size)
    # As long as there is room for every successor of another pose.
    while size > 0 and count + moves.shape[0] <= nodes.cost.shape[0]:
        node = pop(nodes, size)
        size -= 1
        here, cost = (nodes.pose[node, 0], nodes.pose[node, 1], nodes.pose[node, 2]), nodes.cost[node]
        i, j, k = costs_cell(costs, cell, here)
        # The cell has been reached at a lower cost since this entry was made.
        if cost > costs[i, j, k]:
            continue
        # The move that follows the one to be added, on the way to the goal.
        gear, turn = 0, 0.0
        if nodes.move[node] != NOBODY:
            gear, turn = moves[nodes.move[node]].gear, moves[nodes.move[node]].turn
        for m in range(moves.shape[0]):
            # The body comes from where the opposite of the move leads.
            move = moves[m]
            before = pose_after(here, (-move.ahead, -move.left, -move.turn), 1.0)
            count, size = offer_pose(
                nodes, costs, cell, before, cost + seconds_of(options, move, gear, turn), m, count, size
            )  # fmt: skip


@kernel
def offer_pose(
    nodes: PoseNodes, costs: Floats, cell: float, pose: Pose, cost: float, move: int, count: int, size: int
) -> tuple[int, int]:
    """Put a pose into the queue if its cell in the table was reached at a higher cost; return the new counts.

    Writes: nodes, costs.
    """
    i, j, k = costs_cell(costs, cell, pose)
    if i < 0 or cost >= costs[i, j, k]:
        return count, size
    costs[i, j, k] = cost
    note_pose(nodes, count, pose, cost, NOBODY, move)
    return count + 1, push(nodes, size, cost, count)


@kernel
def costs_cell(costs: Floats, cell: float, pose: Pose) -> tuple[int, int, int]:
    """Return the cell of the table for a pose relative to the goal; the first number is -1 beside the table."""
    half = costs.shape[0] // 2
    # Cells are centred on multiples of their side, and the goal is in the middle of cell (half, half).
    i, j = np.floor(pose[0] / cell + 0.5) + half, np.floor(pose[1] / cell + 0.5) + half
    if not (0.0 <= i <= 2 * half and 0.0 <= j <= 2 * half):
        return -1, -1, -1
    # The nearest of N_TURNS headings; the last modulo takes a full turn to 0.
    turns = pose[2] / (2.0 * np.pi)
    return int(i), int(j), int((turns - np.floor(turns)) * N_TURNS + 0.5) % N_TURNS


@kernel
def cost_without_obstacles(aim: Aim, costs: Floats, cell: float, pose: Pose) -> float:
    """Return the cost of the way from a pose to a goal [s] where nothing is in the way; 0 far from it."""
    dx, dy, heading = pose[0] - aim.x, pose[1] - aim.y, pose[2]
    if aim.heading == aim.heading:
        cosine, sine = np.cos(aim.heading), np.sin(aim.heading)
        # Into the frame of the goal, in which the table was made. With any heading the world's frame serves.
        dx, dy, heading = cosine * dx + sine * dy, cosine * dy - sine * dx, heading - aim.heading
    i, j, k = costs_cell(costs, cell, (dx, dy, heading))
    if i < 0:
        return 0.0
    return float(costs[i, j, k])
