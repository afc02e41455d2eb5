"""Least circles and centres of area, against shapely."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.simulator.geometry.measures import centre_of_mass, corner_points, least_circle
from irsim_gym.simulator.levels.body_measures import measure
from irsim_gym.simulator.world.outline import chain

NOTHING = np.zeros((0, 3))


@pytest.mark.parametrize("n_points", [1, 2, 3, 5, 30])
def test_least_circle(n_points: int) -> None:
    random = np.random.default_rng(n_points)
    for _ in range(20):
        points = random.normal(0, [3, 1], (n_points, 2))
        x, y, radius = least_circle(points, n_points)
        assert radius == pytest.approx(shapely.minimum_bounding_radius(shapely.MultiPoint(points)), abs=1e-9)
        assert np.hypot(points[:, 0] - x, points[:, 1] - y).max() <= radius * (1 + 1e-9)


def test_least_circle_of_odd_points() -> None:
    line = np.array([[0.0, 0.0], [1.0, 1.0], [3.0, 3.0], [2.0, 2.0], [0.0, 0.0]])
    assert least_circle(line, 5) == pytest.approx((1.5, 1.5, 1.5 * np.sqrt(2)))
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    assert least_circle(square, 4) == pytest.approx((0.5, 0.5, np.sqrt(0.5)))
    assert least_circle(square, 0) == (0, 0, 0)


def test_centre_of_an_area() -> None:
    corners = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 4], [0, 4]], float)
    expected = shapely.Polygon(corners).centroid
    assert centre_of_mass(chain(corners, closed=True), NOTHING, True) == pytest.approx((expected.x, expected.y))


def test_centre_of_a_curve() -> None:
    points = np.array([[0, 0], [3, 0], [3, 1]], float)
    expected = shapely.LineString(points).centroid
    assert centre_of_mass(chain(points, closed=False), NOTHING, False) == pytest.approx((expected.x, expected.y))


def test_centre_of_areas_beside_each_other() -> None:
    square = chain(np.array([[0, 0], [2, 0], [2, 2], [0, 2]], float), closed=True)
    disc = np.array([[5.0, 1.0, 1.0]])
    assert centre_of_mass(square, disc, True) == pytest.approx(((4 * 1 + np.pi * 5) / (4 + np.pi), 1.0))
    assert centre_of_mass(np.zeros((0, 4)), NOTHING, True) == (0, 0)


def test_corners_of_discs_and_segments() -> None:
    points = np.zeros((66, 2))
    count = corner_points(np.array([[1.0, 2.0, 3.0, 4.0]]), np.array([[5.0, 6.0, 0.5]]), points)
    assert count == 66
    assert points[:2].tolist() == [[1, 2], [3, 4]]
    assert np.hypot(points[2:, 0] - 5, points[2:, 1] - 6) == pytest.approx(np.full(64, 0.5))


SHAPES: dict[str, dict[str, Any]] = {
    "circle": {"name": "circle", "radius": 0.4, "center": [0.3, -0.2]},
    "car": {"name": "rectangle", "length": 4.6, "width": 1.6, "wheelbase": 3},
    "polygon": {"name": "polygon", "vertices": [[0, 0], [0, 4], [1, 4], [1, 1], [3, 1], [3, 0]]},
    "linestring": {"name": "linestring", "vertices": [[0, 0], [3, 0], [3, 1]]},
    "random circle": {"name": "circle", "random_shape": True},
    "random rectangle": {"name": "rectangle", "random_shape": True},
    "random polygon": {"name": "polygon", "random_shape": True, "center_range": [-1, -1, 1, 1]},
    "random hull": {"name": "polygon", "random_shape": True, "is_convex": True},
    "random linestring": {"name": "linestring", "random_shape": True},
}


@pytest.mark.parametrize("name", SHAPES)
def test_radius_and_centre_of_footprints(name: str) -> None:
    n_worlds = 5
    sim = ig.compile(ig.load_scenario({"obstacle": {"shape": SHAPES[name]}}), n_worlds)
    sim.reset(seed=0)
    measure(np.arange(n_worlds), np.zeros(1, np.int64), sim.model)
    for w in range(n_worlds):
        row = w % len(sim.model.radius)
        rows = sim.model.local_segments[row, : sim.model.segment_count[row, 0]]
        if "circle" in name:
            x, y, radius = sim.model.local_discs[row, 0]
        else:
            pieces = list(rows.reshape(-1, 2, 2))
            area = shapely.Polygon(rows[:, :2]) if sim.model.solid[0] else shapely.MultiLineString(pieces)
            x, y, radius = area.centroid.x, area.centroid.y, shapely.minimum_bounding_radius(area)
        assert sim.model.radius[row, 0] == pytest.approx(radius)
        assert sim.model.centroid[row, 0] == pytest.approx([x, y])
