"""Outlines: given shapes exactly, random ones within their bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.bodies.shapes.circle import Circle
from irsim_gym.bodies.shapes.linestring import Linestring
from irsim_gym.bodies.shapes.polygon import Polygon
from irsim_gym.bodies.shapes.rectangle import Rectangle

N_WORLDS = 200


def drawn(shape: dict[str, Any]) -> Any:
    obstacle = {"shape": {**shape, "random_shape": True}, "state": [5, 5, 0.7]}
    sim = ig.compile(ig.load_scenario({"obstacle": obstacle}), N_WORLDS)
    sim.reset()
    return sim


def rings(sim: Any) -> list[np.ndarray]:
    counts = sim.model.segment_count[:, 0]
    return [sim.model.local_segments[w, : counts[w]] for w in range(N_WORLDS)]


def test_circle_with_centre_and_wheelbase() -> None:
    np.testing.assert_allclose(Circle(radius=0.5, center=(0.1, 0.2), wheelbase=1.0).outline().discs, [[0.6, 0.2, 0.5]])


def test_rectangle_stands_on_its_rear_axle() -> None:
    corners = Rectangle(length=4.0, width=2.0, wheelbase=3.0).outline().segments[:, :2]
    assert corners.tolist() == [[-0.5, -1.0], [3.5, -1.0], [3.5, 1.0], [-0.5, 1.0]]


@pytest.mark.parametrize("reverse", [False, True])
def test_polygons_run_counter_clockwise_and_close(reverse: bool) -> None:
    corners = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    rows = Polygon(vertices=corners[::-1] if reverse else corners).outline().segments
    assert shapely.LinearRing(rows[:, :2]).is_ccw
    np.testing.assert_array_equal(rows[:, 2:], np.roll(rows[:, :2], -1, axis=0))


def test_linestring_is_an_open_curve() -> None:
    outline = Linestring(vertices=((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))).outline()
    assert outline.segments.tolist() == [[0, 0, 2, 0], [2, 0, 2, 1]]
    assert not outline.solid


def test_random_circles_use_their_range() -> None:
    radii = drawn({"name": "circle", "radius_range": [0.3, 0.8]}).state.discs[:, 0, 2]
    assert 0.3 <= radii.min() < 0.35
    assert 0.75 < radii.max() <= 0.8


def test_random_rectangles_use_their_ranges() -> None:
    sim = drawn({"name": "rectangle", "length_range": [1, 2], "width_range": [0.2, 0.4]})
    sides = np.linalg.norm(sim.state.segments[:, :4, 2:] - sim.state.segments[:, :4, :2], axis=2)
    assert np.all((sides[:, 0::2] >= 1 - 1e-12) & (sides[:, 0::2] <= 2))
    assert np.all((sides[:, 1::2] >= 0.2 - 1e-12) & (sides[:, 1::2] <= 0.4))
    np.testing.assert_allclose(sim.model.reach[:, 0], np.hypot(sides[:, 0], sides[:, 1]) / 2)


@pytest.mark.parametrize("convex", [False, True])
def test_random_polygons_are_valid_and_keep_their_ranges(convex: bool) -> None:
    ranges = {"avg_radius_range": [0.3, 0.8], "spikeyness_range": [0, 0.6], "num_vertices_range": [4, 9]}
    sim = drawn({"name": "polygon", "is_convex": convex, **ranges})
    sizes, solidity = set(), []
    for w, rows in enumerate(rings(sim)):
        polygon = shapely.Polygon(rows[:, :2])
        np.testing.assert_array_equal(rows[:, 2:], np.roll(rows[:, :2], -1, axis=0))
        assert polygon.is_valid
        assert polygon.exterior.is_ccw
        distances = np.linalg.norm(rows[:, :2], axis=1)
        assert distances.max() <= 2 * 0.8
        assert sim.model.reach[w, 0] == pytest.approx(distances.max())
        sizes.add(len(rows))
        solidity.append(polygon.area / polygon.convex_hull.area)
    assert sizes <= set(range(3 if convex else 4, 9))
    assert len(sizes) >= 5
    assert (min(solidity) > 1 - 1e-9) == convex


def test_spikeyness_is_the_relative_deviation_of_the_distances() -> None:
    shape = {
        "name": "polygon",
        "avg_radius_range": [1, 1],
        "irregularity_range": [0, 0],
        "spikeyness_range": [0.2, 0.2],
    }
    distances = np.concatenate([np.linalg.norm(rows[:, :2], axis=1) for rows in rings(drawn(shape))])
    assert distances.mean() == pytest.approx(1.0, abs=0.03)
    assert distances.std() == pytest.approx(0.2, abs=0.02)


def test_random_linestrings_leave_their_last_side_out() -> None:
    sim = drawn({"name": "linestring", "num_vertices_range": [5, 6]})
    for rows in rings(sim):
        assert len(rows) == 4
        assert not np.array_equal(rows[-1, 2:], rows[0, :2])


@pytest.mark.parametrize("name", ["polygon", "linestring"])
def test_random_outlines_are_about_their_centres(name: str) -> None:
    ranges = {"center_range": [2, -1, 4, 1], "avg_radius_range": [0.1, 0.1], "irregularity_range": [0, 0], "number": 1}
    sim = drawn({"name": name, "spikeyness_range": [0, 0], **ranges})
    middles = np.array([rows[:, :2].sum(axis=0) + (rows[-1, 2:] if name == "linestring" else 0) for rows in rings(sim)])
    counts = np.array([len(rows) + (name == "linestring") for rows in rings(sim)])
    middles /= counts[:, None]
    assert np.all((middles >= [2, -1]) & (middles <= [4, 1]))
    assert np.all(middles.max(axis=0) - middles.min(axis=0) > 1.8)


def test_vertices_of_a_convex_linestring_are_those_of_a_convex_polygon() -> None:
    for rows in rings(drawn({"name": "linestring", "is_convex": True})):
        points = np.vstack([rows[:, :2], rows[-1:, 2:]])
        assert shapely.Polygon(points).area == pytest.approx(shapely.MultiPoint(points).convex_hull.area)


def test_shapes_are_redrawn_at_each_reset() -> None:
    sim = drawn({"name": "circle"})
    before = sim.state.discs[:, 0, 2].copy()
    sim.reset(seed=N_WORLDS)
    assert not np.any(before == sim.state.discs[:, 0, 2])
    sim.reset(seed=0)
    np.testing.assert_array_equal(before, sim.state.discs[:, 0, 2])


@pytest.mark.parametrize("name", ["polygon", "linestring"])
def test_no_random_outline_reaches_farther_than_its_largest(name: str) -> None:
    shape = {"name": name, "center_range": [-3, 0, 1, 2], "avg_radius_range": [0.5, 1], "spikeyness_range": [0.9, 1]}
    obstacle = {"shape": {**shape, "random_shape": True}, "state": [5, 5, 0.7]}
    sim = ig.compile(ig.load_scenario({"obstacle": obstacle}), N_WORLDS)
    largest = sim.model.reach.max()
    assert largest == pytest.approx(2 + np.hypot(3, 2))
    sim.reset()
    assert 0.7 * largest < sim.model.reach.max() <= largest
