import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from irsim_gym.base.arraytypes import BodyOutline
from irsim_gym.simulator.geometry.overlap import (
    disc_meets_outline,
    disc_outline_distance,
    outline_distance,
    outlines_overlap,
    point_outline_distance,
)
from tests.simulator.geometry.shapes import (
    NO_DISCS,
    NO_SEGMENTS,
    Shape,
    closed,
    disc,
    linestring,
    polygon,
    radius_of,
    random_pairs,
    random_shape,
)

N_PAIRS = 4000
TOLERANCE = 1e-9
UNIT = [[0, 0], [1, 0], [1, 1], [0, 1]]
CUP = [[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]]


def overlap(a: Shape, b: Shape) -> bool:
    found = outlines_overlap(a.outline, b.outline)
    assert outlines_overlap(b.outline, a.outline) is found
    return bool(found)


def distance(a: Shape, b: Shape, limit: float = np.inf) -> float:
    return float(outline_distance(a.outline, b.outline, limit))


def test_pairs_against_shapely() -> None:
    first, second, expected = random_pairs(N_PAIRS, seed=11)
    assert 0.1 < np.mean(expected <= 0.0) < 0.9
    for a, b, true in zip(first, second, expected, strict=True):
        assert abs(true) < TOLERANCE or overlap(a, b) is bool(true <= 0.0)
        assert distance(a, b) == pytest.approx(max(true, 0.0), abs=TOLERANCE)
        assert distance(b, a) == pytest.approx(max(true, 0.0), abs=TOLERANCE)


def test_limit_only_cuts_off_what_is_farther() -> None:
    first, second, expected = random_pairs(1000, seed=12)
    for a, b, true in zip(first, second, expected, strict=True):
        found = distance(a, b, 0.5)
        if true < 0.5 - TOLERANCE:
            assert found == pytest.approx(max(true, 0.0), abs=TOLERANCE)
        else:
            assert found >= 0.5 - TOLERANCE


def test_compiled_agrees_with_plain_python() -> None:
    first, second, _ = random_pairs(150, seed=13)
    for a, b in zip(first, second, strict=True):
        assert overlap(a, b) == outlines_overlap.py_func(a.outline, b.outline)  # type: ignore[attr-defined]
        twin = outline_distance.py_func(a.outline, b.outline, np.inf)  # type: ignore[attr-defined]
        assert distance(a, b) == pytest.approx(twin, abs=1e-12)


def test_points_against_shapely() -> None:
    rng = np.random.default_rng(14)
    for _ in range(1500):
        shape, point = random_shape(rng), rng.uniform(-3.0, 3.0, 2)
        expected = max(shapely.distance(shape.geometry, shapely.Point(point)) - radius_of(shape), 0.0)
        assert point_outline_distance(tuple(point), shape.outline) == pytest.approx(expected, abs=TOLERANCE)


def test_a_single_disc_gets_the_same_answers_bit_for_bit() -> None:
    rng = np.random.default_rng(15)
    touching = 0
    for _ in range(2000):
        shape, (x, y), radius = random_shape(rng), rng.uniform(-3.0, 3.0, 2), rng.uniform(0.05, 1.0)
        limit = rng.choice([0.1, 0.7, np.inf])
        ring = disc(x, y, radius)
        assert disc_meets_outline((x, y), radius, shape.outline) is overlap(ring, shape)
        assert disc_outline_distance((x, y), radius, shape.outline, limit) == distance(ring, shape, limit)
        touching += overlap(ring, shape)
    assert 200 < touching < 1800


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (disc(0, 0, 1), disc(2, 0, 1), True),  # touch
        (disc(0, 0, 1), disc(2.0000001, 0, 1), False),
        (disc(0, 0, 1), disc(0.1, 0, 0.1), True),  # one within the other
        (disc(0, 0, 1), disc(0, 0, 1), True),
        (disc(2, 0.5, 1), polygon(UNIT), True),  # touches a side
        (disc(0.5, 0.5, 0.1), polygon(UNIT), True),  # wholly within
        (disc(0.5, 0.5, 5), polygon(UNIT), True),  # wholly around
        (polygon(UNIT), polygon([[1, 0], [2, 0], [2, 1], [1, 1]]), True),  # shared side
        (polygon(UNIT), polygon([[1, 1], [2, 1], [2, 2]]), True),  # shared corner
        (polygon(UNIT), polygon(UNIT), True),
        (polygon(UNIT), polygon([[0.2, 0.2], [0.4, 0.2], [0.3, 0.4]]), True),  # within
        (polygon(CUP), polygon([[1.2, 1.5], [1.8, 1.5], [1.8, 2.5]]), False),  # within the hull only
        (polygon(CUP), disc(1.5, 2, 0.49), False),
        (polygon(CUP), disc(1.5, 2, 0.5), True),
        (linestring(CUP), disc(1.5, 2, 0.49), False),
        (linestring([[-1, -1], [2, -1], [2, 2], [-1, 2], [-1, -1]]), polygon(UNIT), False),  # a fence around it
        (linestring([[0.2, 0.2], [0.8, 0.8]]), polygon(UNIT), True),  # a curve within an area
        (linestring([[0, 0], [1, 0]]), linestring([[0.5, 0], [0.5, 1]]), True),
        (linestring([[0, 0], [1, 0]]), linestring([[2, 0], [3, 0]]), False),
        (linestring([[0.5, 0.5], [0.5, 0.5]]), polygon(UNIT), True),  # a single point
    ],
)
def test_cases_worked_out_by_hand(a: Shape, b: Shape, expected: bool) -> None:
    assert overlap(a, b) is expected
    assert (distance(a, b) == 0.0) is expected


def test_distances_worked_out_by_hand() -> None:
    assert distance(disc(0, 0, 1), disc(3, 4, 2)) == 2.0
    assert distance(polygon(UNIT), disc(4, 5, 2)) == 3.0
    assert distance(polygon(UNIT), polygon([[4, 0], [5, 0], [5, 1]])) == 3.0
    assert distance(polygon(CUP), linestring([[1.5, 1.25], [1.5, 9]])) == 0.25
    assert distance(Shape(NO_SEGMENTS, NO_DISCS, True, None), disc(0, 0, 1)) == np.inf


def test_every_part_of_a_compound_counts() -> None:
    far, near = closed(np.array(UNIT) + 20.0), closed(0.25 * np.array(UNIT) + 0.4)
    parts = Shape(np.vstack([far, near]), np.array([[40.0, 0.0, 1.0], [60.0, 0.0, 1.0]]), True, None)
    assert overlap(parts, polygon(UNIT))
    assert overlap(parts, polygon(np.array(UNIT) * 4 - [-58, 2]))
    assert not overlap(parts, disc(10, 10, 1))
    assert distance(parts, disc(64, 0, 1)) == 2.0


def test_only_the_given_rows_are_read() -> None:
    table = np.vstack([closed(UNIT), closed(np.array(UNIT) + 5.0)])
    rings = np.array([[0.5, 0.5, 1.0], [9.0, 9.0, 1.0]])
    other = BodyOutline(table, 4, 4, rings, 1, 0, True)
    assert not outlines_overlap(BodyOutline(table, 0, 4, rings, 1, 1, True), other)
    assert outlines_overlap(BodyOutline(table, 0, 4, rings, 0, 0, True), other._replace(first_disc=0, n_discs=1))


@given(st.integers(0, 10_000), st.floats(-np.pi, np.pi), st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.booleans())
def test_moving_both_changes_nothing(seed: int, turn: float, x: float, y: float, mirrored: bool) -> None:
    rng = np.random.default_rng(seed)
    a, b = random_shape(rng), random_shape(rng)
    before = distance(a, b)
    after = distance(a.moved(turn, x, y, mirrored=mirrored), b.moved(turn, x, y, mirrored=mirrored))
    assert after == pytest.approx(before, abs=1e-9)
