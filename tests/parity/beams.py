"""Scans of both simulators, beam by beam, with an exact ray caster for those that are apart."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

EXACT = 1e-4
INSET = 0.0013
SWAY = 3e-5


def compare_scans(pair: Any) -> None:
    """Compare the ranges of all sensors after a step; counts beams and grazing ones."""
    for b, theirs in enumerate(pair.reference.objects):
        sensors = [one for one in theirs.sensors if one.sensor_type in ("lidar2d", "fmcw_lidar2d")]
        readings = our_readings(pair.sim, b)
        assert len(sensors) == len(readings)
        for sensor, ranges in zip(sensors, readings, strict=True):
            assert len(ranges) == sensor.number
            pair.report.beams += sensor.number
            apart = np.flatnonzero(np.abs(ranges - sensor.range_data) > EXACT)
            if len(apart):
                compare_beams(pair, theirs, sensor, ranges, apart)


def our_readings(sim: Any, b: int) -> list[Any]:
    """Return the ranges of a body's sensors in the order of the file."""
    kinds = {type(option) for option in sim.scenario.bodies[b].sensors}
    assert len(kinds) <= 1
    found = []
    for group in sim.sensors:
        for member in np.flatnonzero(group.members == b):
            found.append(
                (_position(sim, b, group.options[member]), np.asarray(group.arrays["ranges"][0, member], float))
            )
    return [ranges for _, ranges in sorted(found, key=lambda row: row[0])]


def _position(sim: Any, b: int, option: Any) -> int:
    return next(k for k, one in enumerate(sim.scenario.bodies[b].sensors) if one is option)


def compare_beams(pair: Any, theirs: Any, sensor: Any, ranges: Any, apart: Any) -> None:
    """Beams may be apart at discs, by the depth of the polygon along them, and where they graze an edge."""
    targets = [one for one in pair.reference.objects if one is not theirs and not one.unobstructed]
    origin, directions = sensor._beam_origin, sensor._beam_directions
    for k in apart:
        exact, radius, cosine = cast(origin, directions[k], targets)
        exact = float(np.clip(exact, sensor.range_min, sensor.range_max))
        if abs(ranges[k] - sensor.range_data[k]) * cosine <= INSET * radius + EXACT and abs(ranges[k] - exact) <= EXACT:
            continue
        sway = [cast(origin, turned(directions[k], angle), targets)[0] for angle in (-SWAY, 0.0, SWAY)]
        sway = np.clip(sway, sensor.range_min, sensor.range_max)
        near_disc = radius > 0.0 and abs(ranges[k] - exact) <= EXACT
        assert near_disc or min(sway) - EXACT <= ranges[k] <= max(sway) + EXACT, (
            f"beam {k} of {theirs.name} in step {pair.report.steps}: {ranges[k]}, ir-sim {sensor.range_data[k]}, "
            f"exact {exact}"
        )
        pair.report.grazing_beams += 1
    if len(apart):
        pair.report.decisions.add("exact_disc")


def turned(direction: Any, angle: float) -> Any:
    """Return the direction turned by a small angle."""
    x, y = direction
    return np.array([x - angle * y, y + angle * x])


def cast(origin: Any, direction: Any, targets: list[Any]) -> tuple[float, float, float]:
    """Return the exact range of a beam, the radius of the disc it ends at (0: no disc), and the cosine there."""
    best: tuple[float, float, float] = (np.inf, 0.0, 1.0)
    for one in targets:
        if one.shape == "circle":
            found = cast_disc(origin, direction, disc_centre(one), float(one.gf.radius))
        else:
            found = cast_lines(origin, direction, one._geometry)
        best = min(best, found)
    return best


def disc_centre(one: Any) -> Any:
    """Return the centre of a circle, whose corners are evenly spread around it."""
    return shapely.get_coordinates(one._geometry)[:-1].mean(axis=0)


def cast_disc(origin: Any, direction: Any, centre: Any, radius: float) -> tuple[float, float, float]:
    """Return range, radius and the cosine between beam and normal."""
    to_centre = centre - np.asarray(origin).reshape(-1)[:2]
    along = float(to_centre @ direction)
    half2 = radius * radius - float(to_centre @ to_centre) + along * along
    if half2 < 0.0:
        return np.inf, 0.0, 1.0
    half = np.sqrt(half2)
    depth = along - half if along - half > 1e-9 else along + half
    return (float(depth), radius, float(half / radius)) if depth > 1e-9 else (np.inf, 0.0, 1.0)


def cast_lines(origin: Any, direction: Any, geometry: Any) -> tuple[float, float, float]:
    """Return the range to the lines of any other geometry."""
    start = np.asarray(origin).reshape(-1)[:2]
    best = np.inf
    for line in shapely.get_parts(shapely.get_parts(shapely.boundary(geometry) if geometry.area else geometry)):
        corners = shapely.get_coordinates(line) - start
        a, edge = corners[:-1], np.diff(corners, axis=0)
        across = direction[0] * edge[:, 1] - direction[1] * edge[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (a[:, 0] * edge[:, 1] - a[:, 1] * edge[:, 0]) / across
            where = (a[:, 0] * direction[1] - a[:, 1] * direction[0]) / across
        hit = depth[(np.abs(across) > 1e-15) & (where >= 0.0) & (where <= 1.0) & (depth > 1e-9)]
        best = min(best, float(hit.min(initial=np.inf)))
    return best, 0.0, 1.0
