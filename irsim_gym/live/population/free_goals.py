"""Goals drawn at random, clear of some bodies."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.population import body_info
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.outline import outline_rows


def draw(
    simulation: Simulation, low: Sequence[float], high: Sequence[float], bodies: Iterable[int], room: float, tries: int
) -> tuple[Floats, bool]:
    """Draw a goal x, y, heading [m, m, rad] from the world's random stream.

    Args:
        simulation: The simulation.
        low: Minimum x, y, heading; a missing heading is -pi.
        high: Maximum; a missing heading is pi.
        bodies: Bodies that a disc of radius ``room`` around the goal must not touch.
        room: Radius of the disc [m].
        tries: Maximum number of draws.

    Returns:
        The last draw, shape ``(3,)``, and whether it is clear of the bodies.

    Raises:
        ValueError: The bounds are no two or three finite numbers each, or crossed.
    """
    least, greatest = _bound(low, -math.pi), _bound(high, math.pi)
    if (least > greatest).any():
        raise ValueError(f"range_limits are the least and the greatest [x, y, heading], got {[low, high]!r}")
    others = list(bodies)
    for _ in range(tries):
        goal = simulation.uniform(least.tolist(), greatest.tolist())
        if not any(touches(simulation, body, float(goal[0]), float(goal[1]), room) for body in others):
            return goal, True
    return goal, False


def _bound(values: Sequence[float], heading: float) -> Floats:
    try:
        row = np.asarray(values, np.float64).reshape(-1)
    except (TypeError, ValueError):
        row = np.zeros(0)
    if row.size not in (2, 3) or not np.isfinite(row).all():
        raise ValueError(f"range_limits are the least and the greatest [x, y, heading], got {values!r}")
    return np.append(row, heading)[:3] if row.size == 2 else row


def touches(simulation: Simulation, body: int, x: float, y: float, radius: float) -> bool:
    """Return whether a disc touches a body or lies inside of it, the obstacle map included."""
    if body_info.is_map(simulation, body):
        return _touches_map(simulation, x, y, radius)
    segments, discs = outline_rows(simulation.model, simulation.state, 0, body)
    if (np.hypot(discs[:, 0] - x, discs[:, 1] - y) <= discs[:, 2] + radius).any():
        return True
    starts, ends = segments[:, :2] - (x, y), segments[:, 2:] - (x, y)
    along = ends - starts
    lengths = np.maximum(np.sum(along * along, axis=1), np.finfo(np.float64).tiny)
    # Coordinates are relative to the disc's centre, so the nearest point of a segment is that to the origin.
    nearest = starts + np.clip(-np.sum(starts * along, axis=1) / lengths, 0.0, 1.0)[:, None] * along
    if (np.hypot(nearest[:, 0], nearest[:, 1]) <= radius).any():
        return True
    return bool(simulation.model.solid[body]) and _is_inside(starts, ends)


def _is_inside(starts: Floats, ends: Floats) -> bool:
    """Return whether the origin lies inside closed outlines: a ray from it crosses them an odd number of times."""
    rises = (starts[:, 1] > 0.0) != (ends[:, 1] > 0.0)
    a, b = starts[rises], ends[rises]
    # Where the edge crosses the x axis; only crossings to the right of the origin count.
    right = a[:, 0] - a[:, 1] * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1]) > 0.0
    return bool(np.count_nonzero(right) % 2)


def _touches_map(simulation: Simulation, x: float, y: float, radius: float) -> bool:
    left, bottom, width, height, body = simulation.model.map_frame.item()
    if body < 0:
        return False
    occupied = simulation.model.map_squares[0, 0] == 0
    columns, rows = occupied.shape
    first, last = (max(math.floor((x + side * radius - left) / width), 0) for side in (-1, 1))
    low, high = (max(math.floor((y + side * radius - bottom) / height), 0) for side in (-1, 1))
    disc = float(simulation.model.map_disc[0])
    if disc > 0.0:
        columns_rows = np.argwhere(occupied)
        centres = np.array([left, bottom]) + (columns_rows + 0.5) * [width, height]
        return bool((np.hypot(*(centres - [x, y]).T) <= radius + disc).any())
    i, j = np.nonzero(occupied[first : min(last, columns - 1) + 1, low : min(high, rows - 1) + 1])
    beside = x - np.clip(x, left + (i + first) * width, left + (i + first + 1) * width)
    above = y - np.clip(y, bottom + (j + low) * height, bottom + (j + low + 1) * height)
    return bool((np.hypot(beside, above) <= radius).any())
