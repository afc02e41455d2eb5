"""Compounds against shapely and ir-sim: what they occupy, where their middle is, what a beam sees of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from irsim.lib.handler.geometry_handler import CompoundGeometry

import irsim_gym as ig
from irsim_gym.bodies.shapes.compound import Compound, CompoundPart
from irsim_gym.simulator.geometry.polygons import contains_point
from irsim_gym.simulator.levels.body_measures import measure

PARTS: list[dict[str, Any]] = [
    {"name": "rectangle", "length": 2.0, "width": 0.6, "pose": [0.4, 0.1, 0.3]},
    {"name": "polygon", "vertices": [[0, 0], [1.5, 0], [0, 1.2]], "pose": [-0.5, -0.2, -0.4]},
    {"name": "circle", "radius": 0.5, "center": [0.1, 0.0], "pose": [1.2, 0.5, 1.0]},
]
FRAME = [{"name": "rectangle", "length": 4, "width": 0.5, "pose": [0, y, 0]} for y in (-1.75, 1.75)] + [
    {"name": "rectangle", "length": 0.5, "width": 4, "pose": [x, 0, 0]} for x in (-1.75, 1.75)
]


def compound(parts: list[dict[str, Any]]) -> Compound:
    frozen = [{key: tuple(map(tuple, v)) if key == "vertices" else v for key, v in part.items()} for part in parts]
    return Compound(
        parts=tuple(
            CompoundPart(**{key: tuple(v) if isinstance(v, list) else v for key, v in part.items()}) for part in frozen
        )
    )


def theirs(parts: list[dict[str, Any]]) -> Any:
    return CompoundGeometry(parts=parts)._original_geometry


@pytest.mark.parametrize("parts", [PARTS, FRAME, PARTS[:2], PARTS[2:]])
def test_it_occupies_the_union_of_its_parts(parts: list[dict[str, Any]]) -> None:
    outline, area = compound(parts).outline(), theirs(parts)
    rows = outline.segments
    for x, y in np.random.default_rng(0).uniform(-2.5, 2.5, (400, 2)):
        point = shapely.Point(x, y)
        if area.boundary.distance(point) < 0.002:  # their circles have 64 corners
            continue
        inside = contains_point(rows, 0, len(rows), (x, y)) if len(rows) else False
        inside = inside or any(np.hypot(x - cx, y - cy) <= r for cx, cy, r in outline.discs)
        assert inside == area.contains(point)
    assert outline.centroid == pytest.approx((area.centroid.x, area.centroid.y), abs=1e-3)


def test_the_boundary_is_closed_and_has_the_area_to_its_left() -> None:
    for parts, rings in ((PARTS[:2], 1), (FRAME, 2)):
        rows = compound(parts).outline().segments
        ends = np.any(rows[:, 2:] != np.roll(rows[:, :2], -1, axis=0), axis=1)
        assert np.count_nonzero(ends) == (0 if rings == 1 else rings)
        area = 0.5 * np.sum(rows[:, 0] * rows[:, 3] - rows[:, 1] * rows[:, 2])
        assert area == pytest.approx(theirs(parts).area)
        middles, along = (rows[:, :2] + rows[:, 2:]) / 2, rows[:, 2:] - rows[:, :2]
        left = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
        assert all(contains_point(rows, 0, len(rows), tuple(point)) for point in middles + 1e-6 * left)
        assert not any(contains_point(rows, 0, len(rows), tuple(point)) for point in middles - 1e-6 * left)


def test_a_body_fits_into_a_hole_and_hits_the_frame() -> None:
    robot = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.3}, "state": [5, 5, 0]}
    sensor = [{"name": "lidar2d", "number": 4, "angle_range": "3*pi/2", "range_max": 8}]
    frame = {"shape": {"name": "compound", "parts": FRAME}, "state": [5, 5, 0]}
    sim = ig.compile(ig.load_scenario({"robot": {**robot, "sensors": sensor}, "obstacle": frame}), agents=(0,))
    sim.reset(seed=0)
    group, member = sim.scan(0) or (None, 0)
    assert group is not None
    assert group.arrays["ranges"][0, member] == pytest.approx([1.5 * np.sqrt(2)] * 4, abs=1e-6)
    for _ in range(12):
        sim.step([1.0, 0.0])
    assert not sim.state.collided.any()
    sim.step([1.0, 0.0])
    assert sim.state.collided[0].all()


def test_radius_for_those_who_see_it_as_a_disc() -> None:
    sim = ig.compile(ig.load_scenario({"obstacle": {"shape": {"name": "compound", "parts": PARTS}}}))
    measure(np.zeros(1, np.int64), np.zeros(1, np.int64), sim.model)
    assert sim.model.radius[0, 0] == pytest.approx(shapely.minimum_bounding_radius(theirs(PARTS)), abs=1e-3)
