import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from irsim_gym.simulator.geometry.segments import (
    gap2,
    point_segment_distance2,
    segment_segment_distance2,
    segments_intersect,
)

N_CASES = 4000
small = st.integers(-4, 4).map(float)


def random_ends(seed: int) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    return np.random.default_rng(seed).uniform(-2.0, 2.0, (N_CASES, 8))


def lines(ends: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> object:
    return shapely.linestrings(ends.reshape(-1, 2, 2))


def test_point_segment_distance_against_shapely() -> None:
    ends = random_ends(1)
    expected = shapely.distance(shapely.points(ends[:, :2]), lines(ends[:, 2:6]))
    found = [np.sqrt(point_segment_distance2(*row[:6])) for row in ends]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)


def test_intersection_and_distance_against_shapely() -> None:
    ends = random_ends(2)
    first, second = lines(ends[:, :4]), lines(ends[:, 4:])
    assert [segments_intersect(*row) for row in ends] == shapely.intersects(first, second).tolist()
    found = [np.sqrt(segment_segment_distance2(*row)) for row in ends]
    np.testing.assert_allclose(found, shapely.distance(first, second), rtol=0.0, atol=1e-12)


def test_small_integers_against_shapely() -> None:
    """Touching, collinear and overlapping segments abound among small integers, where both sides are exact."""
    ends = np.random.default_rng(3).integers(-2, 3, (N_CASES, 8)).astype(np.float64)
    proper = (ends[:, 0:2] != ends[:, 2:4]).any(axis=1) & (ends[:, 4:6] != ends[:, 6:8]).any(axis=1)
    ends = ends[proper]
    expected = shapely.intersects(lines(ends[:, :4]), lines(ends[:, 4:]))
    assert [segments_intersect(*row) for row in ends] == expected.tolist()


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ((0, 0, 2, 0, 1, 0, 1, 1), True),  # T
        ((0, 0, 1, 0, 1, 0, 2, 5), True),  # shared end
        ((0, 0, 1, 0, 1, 0, 2, 0), True),  # collinear, end to end
        ((0, 0, 2, 0, 1, 0, 3, 0), True),  # collinear, overlapping
        ((0, 0, 1, 0, 2, 0, 3, 0), False),  # collinear, apart
        ((0, 0, 1, 0, 0, 1, 1, 1), False),  # parallel
        ((1, 1, 1, 1, 0, 0, 2, 2), True),  # a point on a segment
        ((1, 2, 1, 2, 0, 0, 2, 2), False),  # a point beside it
        ((1, 1, 1, 1, 1, 1, 1, 1), True),  # twice the same point
        ((1, 1, 1, 1, 1, 2, 1, 2), False),  # two points
    ],
)
def test_degenerate_segments(ends: tuple[int, ...], expected: bool) -> None:
    numbers = [float(value) for value in ends]
    assert segments_intersect(*numbers) is expected
    assert (segment_segment_distance2(*numbers) == 0.0) is expected


def test_distance_from_a_point_like_segment() -> None:
    assert point_segment_distance2(3.0, 4.0, 0.0, 0.0, 0.0, 0.0) == 25.0


@given(st.tuples(*[small] * 8))
def test_order_does_not_matter(ends: tuple[float, ...]) -> None:
    a, b, c, d = ends[0:2], ends[2:4], ends[4:6], ends[6:8]
    expected = segments_intersect(*ends)
    for other in ((*b, *a, *c, *d), (*a, *b, *d, *c), (*c, *d, *a, *b)):
        assert segments_intersect(*other) == expected
        assert segment_segment_distance2(*other) == pytest.approx(segment_segment_distance2(*ends), abs=1e-12)
    assert gap2(*ends) <= segment_segment_distance2(*ends) + 1e-12


@pytest.mark.parametrize("function", [point_segment_distance2, segments_intersect, segment_segment_distance2, gap2])
def test_compiled_agrees_with_plain_python(function: object) -> None:
    width = 6 if function is point_segment_distance2 else 8
    for row in random_ends(4)[:300]:
        assert function(*row[:width]) == pytest.approx(function.py_func(*row[:width]), abs=1e-12)  # type: ignore[operator, attr-defined]
