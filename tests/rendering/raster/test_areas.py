"""Painted areas cover each pixel as much as shapely says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

from irsim_gym.base.arraytypes import Bytes, Floats
from irsim_gym.rendering.raster.areas import (
    add_disc,
    add_line,
    add_polygon,
    paint_disc,
    paint_line,
    paint_polygon,
    paint_ring,
)
from irsim_gym.rendering.raster.records import RasterCanvas
from irsim_gym.rendering.raster.sheets import add_edge, new_sheet, paint

SIDE = 32
BOX = np.array([0, 0, SIDE, SIDE])
CORNERS = np.arange(SIDE)
PIXELS: Any = shapely.box(*(edge.T for edge in np.meshgrid(CORNERS, CORNERS) + np.meshgrid(CORNERS + 1, CORNERS + 1)))
WHITE = np.array([255.0, 1.0])
SQUARE = np.array([[4.0, 5.0], [20.0, 5.0], [20.0, 25.0], [4.0, 25.0]])


class Drawing:
    """A black picture of one channel, and the sheet for it."""

    def __init__(self, channels: int = 1) -> None:
        self.picture = np.zeros((SIDE, SIDE, channels), np.uint8)
        self.sheet = new_sheet(SIDE, SIDE)

    def draws(self, kernel: Any, *arguments: Any) -> Bytes:
        """Draw white on black; the sheet has to be empty again."""
        self.picture[:] = 0
        kernel(RasterCanvas(self.picture, self.sheet, BOX), *arguments)
        assert not self.sheet.any()
        return self.picture[:, :, 0]


def levels(shape: Any) -> Floats:
    """Return how much of each pixel a shape covers, 255 for all of it, shape ``(SIDE, SIDE)``."""
    shapely.prepare(shape)
    areas: Floats = np.asarray(shapely.area(shapely.intersection(PIXELS, shape)))
    return 255.0 * areas.T


def difference(drawn: Bytes, shape: Any) -> Floats:
    return np.abs(drawn.astype(float) - levels(shape))


def test_discs_and_rings_cover_what_shapely_says() -> None:
    drawing, rng = Drawing(), np.random.default_rng(1)
    for radius in (0.3, 0.8, 1.7, 4.0, 11.3, 40.0):
        x, y = rng.uniform(0.0, SIDE, 2)
        disc = shapely.Point(x, y).buffer(radius, quad_segs=128)
        assert difference(drawing.draws(paint_disc, (x, y), radius, WHITE), disc).max() < 3.0
        hole = shapely.Point(x, y).buffer(max(radius - 1.5, 0.0), quad_segs=128)
        ring = shapely.Point(x, y).buffer(radius + 1.5, quad_segs=128).difference(hole)
        assert difference(drawing.draws(paint_ring, x, y, radius, 3.0, WHITE), ring).max() < 4.0


def test_polygons_cover_what_shapely_says_wherever_they_reach() -> None:
    drawing, rng = Drawing(), np.random.default_rng(2)
    for _ in range(40):
        count = int(rng.integers(3, 9))
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
        reach = rng.uniform(2.0, 40.0, count)[:, None]
        corners = rng.uniform(-5.0, SIDE + 5.0, 2) + reach * np.column_stack([np.cos(angles), np.sin(angles)])
        shape = shapely.Polygon(corners)
        if not shape.is_valid:
            continue
        corners = corners[:: int(rng.choice([-1, 1]))].copy()
        for even_odd in (False, True):
            drawn = drawing.draws(paint_polygon, corners, 0, count, even_odd, WHITE)
            assert difference(drawn, shape).max() < 2.0


def test_the_rules_differ_where_a_boundary_winds_twice() -> None:
    angles = 0.8 * np.pi * np.arange(5)
    star = 16.0 + 15.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    drawing = Drawing()
    assert drawing.draws(paint_polygon, star, 0, 5, False, WHITE)[16, 16] == 255
    hollow = drawing.draws(paint_polygon, star, 0, 5, True, WHITE)
    assert hollow[16, 16] == 0
    assert hollow[16, 27] == 255  # in an arm


@pytest.mark.parametrize("round_ends", [False, True])
@pytest.mark.parametrize("closed", [False, True])
def test_lines_are_as_wide_as_shapely_makes_them(closed: bool, round_ends: bool) -> None:
    drawing = Drawing()
    for corners in (
        [[3.3, 4.1], [27.0, 9.5], [27.0, 30.0]],
        [[2.0, 28.0], [9.7, 6.2], [22.4, 10.1], [28.8, 27.3]],
        [[5.0, 5.0], [5.0, 5.0], [25.0, 6.0], [25.0, 6.0], [-12.0, 24.0]],
    ):
        points = np.array(corners)
        for width in (1.0, 2.6, 5.0):
            ways = shapely.LinearRing(np.vstack([points, points[:1]])) if closed else shapely.LineString(points)
            shape = ways.buffer(0.5 * width, quad_segs=32, cap_style="round" if round_ends else "flat")
            off = difference(drawing.draws(paint_line, points, 0, len(points), width, closed, round_ends, WHITE), shape)
            assert off.max() < 80.0, (corners, width)  # at an inner corner, where both parts cover a share of a pixel
            assert np.sort(off.ravel())[-8] < 4.0, (corners, width)


def test_a_line_of_many_short_parts_is_no_darker_at_its_joins() -> None:
    angles = np.linspace(0.3, 2.8, 90)
    points = np.array([16.0, 4.0]) + 20.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    drawn = Drawing().draws(paint_line, points, 0, len(points), 2.5, False, False, WHITE)
    assert difference(drawn, shapely.LineString(points).buffer(1.25, cap_style="flat")).max() < 4.0


def test_parts_of_one_area_do_not_add_up() -> None:
    drawing = Drawing()
    for k in range(3):
        add_line(drawing.sheet, BOX, np.array([[16.0, 16.0], [30.0, 8.0 + 8.0 * k]]), 0, 2, 6.0, False, True)
    add_disc(drawing.sheet, BOX, 16.0, 16.0, 8.0, 1.0)
    add_disc(drawing.sheet, BOX, 14.0, 16.0, 2.0, -1.0)
    paint(drawing.picture, drawing.sheet, BOX, np.array([200.0, 0.5]), False)
    assert drawing.picture[16, 20, 0] == 100
    assert drawing.picture[16, 10, 0] == 100
    assert drawing.picture.max() == 100


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_colours_are_blended_in_each_channel(channels: int) -> None:
    drawing = Drawing(channels)
    drawing.picture[:] = 100
    colour = np.array([*(50.0 * np.arange(channels)), 0.25])
    paint_polygon(RasterCanvas(drawing.picture, drawing.sheet, BOX), SQUARE, 0, 4, False, colour)
    expected = [int(0.75 * 100 + 0.25 * 50 * channel + 0.5) for channel in range(channels)]
    assert drawing.picture[10, 10].tolist() == expected
    assert (drawing.picture[4] == 100).all()
    inside = (drawing.picture != 100).any(axis=2)
    assert inside.sum() == 16 * 20
    paint_polygon(RasterCanvas(drawing.picture, drawing.sheet, BOX), SQUARE, 0, 4, False, np.array([*colour[:-1], 7.0]))
    assert drawing.picture[10, 10].tolist() == colour[:-1].tolist()  # an opacity above one is one


def test_nothing_is_painted_outside_the_box() -> None:
    drawing, box = Drawing(), np.array([6, 3, 19, 14])
    for paint_one in (
        lambda: paint_disc(RasterCanvas(drawing.picture, drawing.sheet, box), (12.0, 9.0), 30.0, WHITE),
        lambda: paint_polygon(
            RasterCanvas(drawing.picture, drawing.sheet, box), 2.0 * SQUARE - 15.0, 0, 4, False, WHITE
        ),
    ):
        drawing.picture[:] = 0
        paint_one()
        assert (drawing.picture[3:14, 6:19] == 255).all()
        assert drawing.picture.sum() == 255 * 11 * 13
        assert not drawing.sheet.any()


def test_whatever_comes_the_sheet_is_left_empty() -> None:
    drawing, rng = Drawing(), np.random.default_rng(3)
    box = np.array([3, 2, 29, 31])
    odd = np.array([np.nan, np.inf, -np.inf, 1e300, -1e9, 0.0, 32.0, 31.9999999999])
    for k in range(300):
        points = rng.uniform(-60.0, 90.0, (6, 2)) if k % 2 else rng.integers(-3, 36, (6, 2)).astype(float)
        if k % 3 == 0:
            points[rng.integers(6), rng.integers(2)] = rng.choice(odd)
        add_polygon(drawing.sheet, box, points, 0, 6)
        add_line(drawing.sheet, box, points, 0, 6, float(rng.uniform(0.0, 5.0)), bool(k % 5), bool(k % 7))
        add_disc(drawing.sheet, box, *points[0], float(rng.choice([*odd, 5.0, 200.0])), 1.0)
        paint(drawing.picture, drawing.sheet, box, WHITE, bool(k % 2))
        assert not drawing.sheet.any()
    assert drawing.picture[2:31, 3:29].any()
    drawing.picture[2:31, 3:29] = 0
    assert not drawing.picture.any()


def test_what_is_no_number_or_far_away_is_not_drawn() -> None:
    drawing = Drawing()
    for place in (np.nan, np.inf, 1e12):
        assert not drawing.draws(paint_disc, (place, 5.0), 20.0, WHITE).any()
        corners = np.vstack([SQUARE, [[place, 5.0]]])
        assert not drawing.draws(paint_polygon, corners, 0, 5, False, WHITE).any()
        assert not drawing.draws(paint_line, corners, 0, 5, 3.0, False, True, WHITE).any()
    assert not drawing.draws(paint_disc, (5.0, 5.0), -1.0, WHITE).any()
    assert not drawing.draws(paint_line, SQUARE, 0, 1, 3.0, False, False, WHITE).any()
    dot = difference(drawing.draws(paint_line, SQUARE, 0, 1, 3.0, False, True, WHITE), shapely.Point(4, 5).buffer(1.5))
    assert dot.max() < 3.0


def test_plain_python_draws_the_same_pixels() -> None:
    plain, compiled = Drawing(3), Drawing(3)
    colour = np.array([10.0, 130.0, 250.0, 0.7])
    ways = np.vstack([SQUARE, SQUARE[:1]]) * 0.9 + 0.3
    for drawing, add, fill in ((plain, add_edge.py_func, paint.py_func), (compiled, add_edge, paint)):  # type: ignore[attr-defined]
        with np.errstate(all="ignore"):
            for (ax, ay), (bx, by) in zip(ways[:-1], ways[1:] + np.array([0.0, 1.5]), strict=True):
                add(drawing.sheet, BOX, ax, ay, bx, by)
                add(drawing.sheet, BOX, bx, by, ax, ay - 4.0)
                add(drawing.sheet, BOX, ax, ay - 4.0, ax, ay)
            fill(drawing.picture, drawing.sheet, BOX, colour, False)
    assert plain.picture.any()
    np.testing.assert_array_equal(plain.picture, compiled.picture)
