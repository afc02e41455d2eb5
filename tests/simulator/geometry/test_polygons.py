import numpy as np
import pytest
import shapely

from irsim_gym.simulator.geometry.polygons import contains_point, is_convex, reach, signed_area
from tests.simulator.geometry.shapes import NO_DISCS, NO_SEGMENTS, closed, star

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
PENTAGRAM = np.array([[np.cos(angle), np.sin(angle)] for angle in 0.8 * np.pi * np.arange(5)])


def test_contains_point_against_shapely() -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        vertices = star(rng, 0.0, 0.0, 1.5)
        shape = shapely.Polygon(vertices)
        if not shape.is_valid:
            continue
        points = rng.uniform(-1.6, 1.6, (60, 2))
        rows = rng.permutation(closed(vertices))
        flipped = rng.random(len(rows)) < 0.5
        rows[flipped] = rows[flipped][:, [2, 3, 0, 1]]
        found = [contains_point(rows, 0, len(rows), (x, y)) for x, y in points]
        assert found == shapely.contains_xy(shape, points).tolist()
        assert found[:9] == [contains_point.py_func(rows, 0, len(rows), (x, y)) for x, y in points[:9]]  # type: ignore[attr-defined]


def test_contains_point_at_the_height_of_vertices() -> None:
    diamond = closed([[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    assert contains_point(diamond, 0, 4, (0.0, 0.0))
    assert not contains_point(diamond, 0, 4, (-2.0, 0.0))
    assert not contains_point(diamond, 0, 4, (-2.0, 1.0))
    assert not contains_point(diamond, 0, 4, (2.0, 0.0))


def test_contains_point_reads_only_its_rows_and_knows_holes() -> None:
    hole = 0.25 + 0.5 * SQUARE
    rows = np.vstack([closed(SQUARE + 5.0), closed(SQUARE), closed(hole)])
    assert not contains_point(rows, 4, 4, (5.5, 5.5))
    assert contains_point(rows, 4, 8, (0.1, 0.5))
    assert not contains_point(rows, 4, 8, (0.5, 0.5))


def test_signed_area() -> None:
    assert signed_area(SQUARE) == 1.0
    assert signed_area(SQUARE[::-1].copy()) == -1.0
    assert signed_area(SQUARE[:2].copy()) == 0.0
    rng = np.random.default_rng(6)
    for _ in range(50):
        vertices = star(rng, 3.0, -2.0, 1.0)
        shape = shapely.Polygon(vertices)
        if shape.is_valid:
            assert abs(signed_area(vertices)) == pytest.approx(shape.area, abs=1e-12)


@pytest.mark.parametrize(
    ("vertices", "expected"),
    [
        (SQUARE, True),
        (SQUARE[::-1], True),
        ([[0, 0], [1, 0], [2, 0], [2, 2], [0, 2]], True),  # a straight angle
        ([[0, 0], [0, 0], [1, 0], [1, 1], [1, 1]], True),  # repeated vertices
        ([[0, 0], [2, 0], [1, 0.5], [0, 2]], False),  # dented
        (PENTAGRAM, False),  # winds twice
        ([[0, 0], [1, 0], [2, 0]], False),  # without area
        ([[0, 0], [1, 1], [1, 0], [0, 1]], False),  # crosses itself
    ],
)
def test_is_convex(vertices: object, expected: bool) -> None:
    rows = np.ascontiguousarray(vertices, np.float64)
    assert is_convex(rows) is expected
    assert is_convex.py_func(rows) == expected  # type: ignore[attr-defined]


def test_is_convex_against_the_hull() -> None:
    rng = np.random.default_rng(7)
    seen = set()
    for _ in range(300):
        vertices = star(rng, 0.0, 0.0, 1.0)[:5]
        shape = shapely.Polygon(vertices)
        if shape.is_valid:
            expected = bool(abs(shape.convex_hull.area - shape.area) < 1e-12)
            assert is_convex(vertices.copy()) is expected
            seen.add(expected)
    assert seen == {True, False}


def test_reach() -> None:
    segments = np.array([[9.0, 9.0, 9.0, 9.0], [0.0, 0.0, 3.0, 4.0], [-1.0, 0.0, 0.0, 1.0]])
    discs = np.array([[3.0, 0.0, 3.0], [9.0, 0.0, 1.0]])
    assert reach(segments, 1, 2, discs, 0, 0) == 5.0
    assert reach(segments, 1, 2, discs, 0, 1) == 6.0
    assert reach(NO_SEGMENTS, 0, 0, NO_DISCS, 0, 0) == 0.0
