"""Goals drawn at random, clear of some areas."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.session.vectors import row_of
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.irsim_readings import IrSimReadings


def draw(
    simulation: Simulation, low: Sequence[float], high: Sequence[float], areas: list[Any], room: float, tries: int
) -> tuple[Floats, bool]:
    """Draw a goal x, y, heading [m, m, rad] from the world's random stream.

    Args:
        simulation: The simulation.
        low: Minimum x, y, heading; a missing heading is -pi.
        high: Maximum; a missing heading is pi.
        areas: Shapely geometries that a disc of radius ``room`` around the goal must not touch.
        room: Radius of the disc [m].
        tries: Maximum number of draws.

    Returns:
        The last draw, shape ``(3,)``, and whether it is clear of the areas.

    Raises:
        ValueError: The bounds are no two or three finite numbers each, or crossed.
    """
    import shapely

    least, greatest = _bound(low, -math.pi), _bound(high, math.pi)
    if (least > greatest).any():
        raise ValueError(f"range_limits are the least and the greatest [x, y, heading], got {[low, high]!r}")
    for _ in range(tries):
        goal = simulation.uniform(least.tolist(), greatest.tolist())
        if not shapely.dwithin(areas, shapely.Point(goal[:2]), room).any():
            return goal, True
    return goal, False


def _bound(values: Sequence[float], heading: float) -> Floats:
    row = row_of(values)
    if row.size not in (2, 3) or not np.isfinite(row).all():
        raise ValueError(f"range_limits are the least and the greatest [x, y, heading], got {values!r}")
    return np.append(row, heading)[:3] if row.size == 2 else row


def area(body: IrSimReadings) -> Any:
    """Return what a body covers as a shapely geometry: of a map its occupied cells, not only their boundary."""
    import shapely

    return shapely.build_area(body.geometry) if body.shape == "map" else body.geometry
