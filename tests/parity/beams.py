"""Scans of both simulators, beam by beam, with an exact ray caster for those that are apart."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from exact import Body, body_of

EXACT = 1e-4
INSET = 0.0013
SWAY = 3e-5
TOUCH = 1e-6
SCANNERS = ("lidar2d", "fmcw_lidar2d")
MOTIONS = ("velocity", "radial_velocity")

Hit = tuple[float, float, float]


def compare_scans(pair: Any) -> None:
    """Compare all scans after a step; counts beams and grazing ones."""
    for b, theirs in enumerate(pair.reference.objects):
        sensors = [one for one in theirs.sensors if one.sensor_type in SCANNERS]
        scans = our_scans(pair.sim, b)
        assert len(sensors) == len(scans)
        for sensor, ours in zip(sensors, scans, strict=True):
            if not sensor.noise:
                compare_scan(pair, theirs, sensor, ours)


def our_scans(sim: Any, b: int) -> list[dict[str, Any]]:
    """Return the scans of a body's sensors in the order of the file."""
    found = {}
    for group in sim.sensors:
        for member in np.flatnonzero(group.members == b):
            option = group.options[member]
            place = next(k for k, one in enumerate(sim.scenario.bodies[b].sensors) if one is option and k not in found)
            found[place] = group.kind.report(group, int(member), 0)
    return [found[place] for place in sorted(found)]


def compare_scan(pair: Any, carrier: Any, sensor: Any, ours: dict[str, Any]) -> None:
    """Compare one scan key by key, the beams with an allowance at discs and edges."""
    theirs = sensor.get_scan()
    pair.report.beams += sensor.number
    assert ours.keys() == theirs.keys()
    for key in theirs.keys() - {"ranges", "valid", "intensities", *MOTIONS}:
        assert abs(ours[key] - theirs[key]) <= 1e-12, (key, ours[key], theirs[key])
    assert ours["intensities"] is None
    assert ours["ranges"].shape == theirs["ranges"].shape
    odd = np.abs(ours["ranges"] - theirs["ranges"]) > EXACT
    odd |= ours["valid"] != theirs["valid"]
    for key in MOTIONS:
        if key in theirs:
            assert ours[key].shape == theirs[key].shape
            odd |= np.any(np.abs(ours[key] - theirs[key]).reshape(-1, sensor.number) > EXACT, axis=0)
    for k in np.flatnonzero(odd):
        compare_beam(pair, carrier, sensor, int(k), ours)


def compare_beam(pair: Any, carrier: Any, sensor: Any, k: int, ours: dict[str, Any]) -> None:
    """A beam may be apart at discs, by the depth of the polygon along it, and where it grazes an edge."""
    objects = pair.reference.objects
    targets = [body_of(pair, b) for b, one in enumerate(objects) if one is not carrier and not one.unobstructed]
    origin, direction = np.asarray(sensor._beam_origin).reshape(-1)[:2], sensor._beam_directions[k]
    if in_a_compound(pair, origin):
        pair.report.decisions.add("compound_seams")
        return
    if touches_an_edge(objects, carrier, origin):
        pair.report.decisions.add("touching_sensor")
        return
    theirs = sensor.get_scan()
    found, expected = float(ours["ranges"][k]), float(theirs["ranges"][k])
    hits = cast_all(origin, direction, targets)
    exact = float(np.clip(min(hits)[0], sensor.range_min, sensor.range_max))
    alike = all(np.all(np.abs(ours[key][..., k] - theirs[key][..., k]) <= EXACT) for key in MOTIONS if key in theirs)
    same = alike and ours["valid"][k] == theirs["valid"][k]
    at_disc = any(abs(depth - expected) * cosine <= INSET * radius + EXACT for depth, radius, cosine in hits if radius)
    if same and at_disc and abs(found - exact) <= EXACT:
        pair.report.decisions.add("exact_disc")
        return
    sway = [cast_all(origin, turned(direction, angle), targets) for angle in (-SWAY, 0.0, SWAY)]
    ranges = np.clip([min(row)[0] for row in sway], sensor.range_min, sensor.range_max)
    near_edge = np.ptp(ranges) > EXACT or len({row.index(min(row)) for row in sway}) > 1 or at_band_edge(sensor, exact)
    at_rim = min(hits)[1] > 0.0 and abs(found - exact) <= EXACT
    assert at_rim or (near_edge and min(ranges) - EXACT <= found <= max(ranges) + EXACT), (
        f"beam {k} of {carrier.name} in step {pair.report.steps}: {found}, ir-sim {expected}, exact {exact}; "
        + "; ".join(
            f"{key} {ours[key][..., k]}, ir-sim {theirs[key][..., k]}" for key in theirs.keys() & {*MOTIONS, "valid"}
        )
    )
    pair.report.grazing_beams += 1


def at_band_edge(sensor: Any, exact: float) -> bool:
    """Return whether a range lies at the very end of the sensor's band."""
    return min(abs(exact - sensor.range_min), abs(exact - sensor.range_max)) <= EXACT


def turned(direction: Any, angle: float) -> Any:
    """Return the direction turned by a small angle."""
    x, y = direction
    return np.array([x - angle * y, y + angle * x])


def outline_of(geometry: Any) -> Any:
    """Return the lines of a geometry."""
    return shapely.boundary(geometry) if geometry.area else geometry


def touches_an_edge(objects: list[Any], carrier: Any, origin: Any) -> bool:
    """Return whether a sensor stands on the edge of another body (``touching_sensor``), which may be a disc's."""
    for one in objects:
        if one is not carrier and not one.unobstructed:
            room = INSET * one.gf.radius if one.shape == "circle" else 0.0
            if shapely.distance(outline_of(one._geometry), shapely.Point(origin)) <= TOUCH + room:
                return True
    return False


def in_a_compound(pair: Any, origin: Any) -> bool:
    """Return whether a sensor stands inside a compound, whose parts it sees one by one (``compound_seams``)."""
    compounds = [one for one in pair.reference.objects if one.shape == "compound"]
    return any(shapely.distance(one._geometry, shapely.Point(origin)) <= INSET for one in compounds)


def cast_all(origin: Any, direction: Any, targets: list[Body]) -> list[Hit]:
    """Return for each part of each target the exact range of a beam, the radius (0: no disc), and the cosine there."""
    found = [cast_disc(origin, direction, disc) for target in targets for disc in target.discs]
    found += [cast_lines(origin, direction, target.lines) for target in targets if target.lines is not None]
    return [*found, (np.inf, 0.0, 1.0)]


def cast_disc(origin: Any, direction: Any, disc: tuple[float, float, float]) -> Hit:
    """Return range, radius and the cosine between beam and normal."""
    to_centre, radius = np.array(disc[:2]) - origin, disc[2]
    along = float(to_centre @ direction)
    half2 = radius * radius - float(to_centre @ to_centre) + along * along
    if half2 < 0.0:
        return np.inf, 0.0, 1.0
    half = np.sqrt(half2)
    depth = along - half if along - half > 1e-9 else along + half
    return (float(depth), radius, float(half / radius)) if depth > 1e-9 else (np.inf, 0.0, 1.0)


def cast_lines(origin: Any, direction: Any, geometry: Any) -> Hit:
    """Return the range to the lines of any other geometry."""
    best = np.inf
    for line in shapely.get_parts(outline_of(geometry)):
        corners = shapely.get_coordinates(line) - origin
        a, edge = corners[:-1], np.diff(corners, axis=0)
        across = direction[0] * edge[:, 1] - direction[1] * edge[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (a[:, 0] * edge[:, 1] - a[:, 1] * edge[:, 0]) / across
            where = (a[:, 0] * direction[1] - a[:, 1] * direction[0]) / across
        hit = depth[(np.abs(across) > 1e-15) & (where >= 0.0) & (where <= 1.0) & (depth > 1e-9)]
        best = min(best, float(hit.min(initial=np.inf)))
    return best, 0.0, 1.0
