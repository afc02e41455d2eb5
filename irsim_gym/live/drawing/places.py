"""Reads points that are given as rows, columns, or lists of either."""

import numpy as np
from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Flags, Floats

FEWEST, MOST = 2, 4
"""Possible numbers of coordinates of a point: x and y, optionally a heading and one more. Others are ignored."""

FARTHEST = 1e9
"""Upper bound of coordinates [m]."""


def rows(points: ArrayLike, *, columns: bool = False, least: int = FEWEST) -> Floats:
    """Return points as rows.

    Args:
        points: An array with a row ``x, y, ...`` per point, or a list of points, each flat or a column.
        columns: Whether to read an array with two, three or four rows as IR-SIM does: with one column per point.
        least: Number of coordinates that each point must have.

    Returns:
        Shape ``(n, d)``, where ``d`` is the least number of coordinates that a point has.

    Raises:
        ValueError: These are no points.
    """
    table = _table(points, columns)
    if table is None or (len(table) and not least <= table.shape[1] <= MOST):
        names = ", ".join(("x", "y", "u", "v")[:least])
        shape = f"shape {np.shape(points)}" if isinstance(points, np.ndarray) else repr(points)[:60]
        raise ValueError(f"points are rows ({names}) or a list of points, got {shape}")
    return table if len(table) else np.zeros((0, least))


def _table(points: ArrayLike, columns: bool) -> Floats | None:
    """Return points as rows; None if their shape is not that of points."""
    if isinstance(points, list | tuple) and any(np.ndim(point) for point in points):
        try:
            flat = [np.asarray(point, np.float64).ravel() for point in points]
        except (TypeError, ValueError):
            return None
        sizes = [len(point) for point in flat]
        is_point = all(min(np.shape(point)[1:], default=1) == 1 or np.shape(point)[0] == 1 for point in points)
        if not is_point or max(sizes) > MOST:
            return None
        return np.array([point[: min(sizes)] for point in flat]).reshape(len(flat), -1)
    try:
        table = np.asarray(points, np.float64)
    except (TypeError, ValueError):
        return None
    if table.size == 0:
        return np.zeros((0, FEWEST))
    if table.ndim == 1:
        return table[None]
    if table.ndim != 2:
        return None
    if columns and FEWEST <= len(table) <= MOST:
        return np.asarray(table.T)
    if table.shape[1] == 1:
        return np.asarray(table.T)
    return table


def _are_near(points: Floats) -> Flags:
    """Return which points are finite and near enough to be drawn."""
    return np.asarray((np.abs(points[:, :2]) < FARTHEST).all(axis=1))


def finite(points: Floats) -> Floats:
    """Return the finite points, without further coordinates, shape ``(n, 2)``."""
    return points[_are_near(points), :2].copy()


def runs(points: Floats) -> list[Floats]:
    """Return the pieces of a line between points that are not finite, each of shape ``(n, 2)``."""
    near = _are_near(points)
    # Where ``known`` changes: first row and end of each run, in turn.
    edges = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(np.int8), [0]])))
    return [points[first:end, :2].copy() for first, end in edges.reshape(-1, 2).tolist()]
