"""Points that are in the way, against distances to all of them."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.paths.points import (
    PointMap,
    add_point,
    blocking_point,
    capsule_meets_points,
    forget_points,
    points_distance,
)


def drawn(seed: int) -> tuple[PointMap, np.ndarray]:
    """Return a map of 4 x 4 m and its points."""
    points = PointMap.over([0.0, 0.0, 4.0, 4.0], 0.1, ())
    for x, y in np.random.default_rng(seed).uniform(0.0, 4.0, (40, 2)).tolist():
        add_point(points, (x, y), (2.0, 2.0))
    return points, points.places[np.isfinite(points.places[..., 0])].astype(np.float64)


def test_a_cell_keeps_the_point_nearest_to_who_saw_it() -> None:
    points = PointMap.over([0.0, 0.0, 4.0, 4.0], 0.5, ())
    for x, y in ((1.05, 1.1), (1.0, 1.2), (1.2, 1.2), (9.0, 1.0)):  # the last one is outside
        add_point(points, (x, y), (2.0, 1.0))
    kept = points.places[np.isfinite(points.places[..., 0])]
    assert kept == pytest.approx(np.array([[1.2, 1.2]]))  # 0.8 m away


@pytest.mark.parametrize("seed", range(4))
def test_distances_are_those_of_all_points(seed: int) -> None:
    points, places = drawn(seed)
    ends = np.random.default_rng(seed + 100).uniform(-0.5, 4.5, (60, 4))
    ends[::6, 2:] = ends[::6, :2]  # points
    ends[1::6, 2] = ends[1::6, 0]  # upright
    for ax, ay, bx, by in ends.tolist():
        least = np.sqrt(min(point_segment_distance2(x, y, ax, ay, bx, by) for x, y in places.tolist()))
        for radius in (0.05, 0.3, least - 1e-6, least + 1e-6):
            radius = max(radius, 0.0)
            assert capsule_meets_points(points, ax, ay, bx, by, radius) == (least <= radius)
            x, y = blocking_point(points, ax, ay, bx, by, radius)
            if least <= radius:
                assert [x, y] in places.tolist()
                assert point_segment_distance2(x, y, ax, ay, bx, by) <= radius * radius
            else:
                assert np.isnan(x)
                assert np.isnan(y)
        alone = np.sqrt(((places - [ax, ay]) ** 2).sum(axis=1).min())
        assert points_distance(points, (ax, ay), 0.4) == pytest.approx(min(alone, 0.4))


def test_forgotten_points_are_in_nobodys_way_and_new_ones_are() -> None:
    maps = PointMap.over([0.0, 0.0, 4.0, 4.0], 0.1, (2, 3))
    points, other = (maps._replace(places=maps.places[w, 2], filled=maps.filled[w, 2]) for w in (1, 0))
    for one in (points, other):
        add_point(one, (1.0, 1.0), (2.0, 2.0))
        assert capsule_meets_points(one, 0.0, 0.0, 4.0, 4.0, 1.0)
    forget_points(maps, 1, 2)
    assert capsule_meets_points(other, 0.0, 0.0, 4.0, 4.0, 1.0)
    assert not capsule_meets_points(points, 0.0, 0.0, 4.0, 4.0, 1.0)
    add_point(points, (3.95, 3.95), (2.0, 2.0))  # in the last cells, which are fewer than a block
    assert points_distance(points, (3.0, 3.95), 2.0) == pytest.approx(0.95)
