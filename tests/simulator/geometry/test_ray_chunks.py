"""Chunks of primitives against a textbook in float64, and what is left out against what is not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

import irsim_gym as ig
from irsim_gym.bodies.sensors.casting import cast_chunk
from irsim_gym.simulator.geometry.ray_chunks import (
    BLOCK,
    CHUNK,
    SIDES,
    Eye,
    Fan,
    clear_depths,
    lay_beams,
    prepare_segments,
    rough_angle,
    span,
)
from irsim_gym.simulator.world.group import Group
from tests.simulator.geometry.ray_rooms import N_BEAMS, beams, random_room, steady, textbook
from tests.simulator.geometry.shapes import closed

FAR = 30.0
NUMBERS = [name for name in SIDES.names or () if SIDES[name].base == np.float32]


def scanner() -> Group:
    """Return a scanner with tables of its own."""
    robot = {"kinematics": {"name": "diff"}, "sensors": [{"name": "lidar2d", "number": 4}]}
    return ig.compile(ig.load_scenario({"robot": robot})).sensors[0]


def cast(
    segments: Any,
    discs: Any,
    angles: NDArray[np.float64],
    *,
    narrow: bool = True,
    heading: float = 0.0,
    far: float = FAR,
    plain: bool = False,
) -> NDArray[np.float64]:
    """Return ranges of a sensor at the origin, inf where nothing is met; both sides of segments are seen."""
    laid = np.concatenate([angles, np.zeros(-len(angles) % BLOCK)])
    x, y = np.cos(laid).astype(np.float32), np.sin(laid).astype(np.float32)
    density = (len(angles) - 1) / (angles[-1] - angles[0]) if narrow else 0.0
    kernels: Any = (cast_chunk, lay_beams, clear_depths)
    chunk, lay, clear = (kernel.py_func if plain else kernel for kernel in kernels)
    tables = scanner().tables
    tables.first, tables.density, tables.beams_x, tables.beams_y = float(angles[0]), float(density), x[None], y[None]
    tables.rays, tables.inverse = (np.full((1, n * len(laid)), np.nan, np.float32) for n in (3, 1))
    rays, table = tables.rays[0], np.asarray(segments, np.float64).reshape(-1, 4)
    lay(x, y, rays)
    clear(rays)
    rounds = np.asarray(discs, np.float64).reshape(-1, 3)
    for name, values in zip(("x", "y", "radius"), rounds.T, strict=True):
        tables.discs[name][0, : len(rounds)] = values
    tables.limits[:] = np.inf
    eye = Eye(0.0, 0.0, float(np.cos(heading)), float(np.sin(heading)))
    for k, rows in enumerate(np.array_split(table, max(-(-len(table) // CHUNK), 1))):
        assert chunk(len(rows), len(rounds) if k == 0 else 0, rows.ravel(), eye, far, 0, 0, tables) == 0
    found = rays.reshape(-1, 3, BLOCK)[:, 0].ravel()[: len(angles)]
    return np.divide(1.0, found, out=np.full(len(angles), np.inf), where=found > 0.0, dtype=np.float64)


def test_rooms_against_a_textbook() -> None:
    rng = np.random.default_rng(31)
    total = grazing = 0
    for _ in range(150):
        segments, discs = random_room(rng)
        found, expected = cast(segments, discs, beams()), textbook(segments, discs, beams())
        calm = steady(segments, discs, beams())
        assert np.max(np.abs(found - expected)[calm]) < 2e-5
        total, grazing = total + N_BEAMS, grazing + int(np.sum(np.abs(found - expected) > 1e-4))
    assert grazing <= total * 1e-4


@pytest.mark.parametrize("span", [0.02, 1.0, np.pi, 6.0, 2.0 * np.pi])
def test_beams_that_are_left_out_would_have_met_nothing(span: float) -> None:
    rng = np.random.default_rng(32)
    angles = np.linspace(-0.5 * span, 0.5 * span, 224)
    fewer = 0
    for _ in range(60):
        segments, discs = random_room(rng)
        found = cast(segments, discs, angles)
        np.testing.assert_array_equal(found, cast(segments, discs, angles, narrow=False))
        fewer += int(np.isinf(found).any())
    assert fewer < 60


def test_a_turned_sensor_sees_the_turned_room() -> None:
    rng = np.random.default_rng(33)
    for heading in (-3.0, -0.7, 1.9):
        segments, discs = random_room(rng)
        calm = steady(segments, discs, beams() + heading)
        expected = textbook(segments, discs, beams() + heading)
        np.testing.assert_allclose(cast(segments, discs, beams(), heading=heading)[calm], expected[calm], atol=2e-5)


def test_compiled_chunks_agree_with_plain_python() -> None:
    rng = np.random.default_rng(34)
    with np.errstate(all="ignore"):
        for _ in range(2):
            segments, discs = random_room(rng)
            calm = steady(segments, discs, beams(64))
            twin = cast(segments, discs, beams(64), plain=True)
            np.testing.assert_allclose(cast(segments, discs, beams(64))[calm], twin[calm], rtol=1e-5)


def test_no_beam_slips_between_two_segments() -> None:
    """Beams that point exactly at the vertices of a ring around the sensor all meet it."""
    rng = np.random.default_rng(35)
    for n in (7, 16, 100):
        for _ in range(40):
            angles = np.sort(rng.uniform(-np.pi, np.pi, n))
            if np.max(np.diff(np.append(angles, angles[0] + 2.0 * np.pi))) >= 3.0:
                continue
            radii = rng.uniform(0.1, 30.0, n)
            ring = closed(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1))
            found = cast(ring, [], np.resize(angles, -(-n // 32) * 32), narrow=False, far=100.0)[:n]
            assert np.all(np.isfinite(found))
            assert np.all(found <= np.max(radii) * 1.0001)


@pytest.mark.parametrize("row", [(-1.0, 0.0, 2.0, 0.0), (0.0, 0.0, 2.0, 1.0), (1.0, 1.0, 0.0, 0.0), (0.0,) * 4])
def test_a_sensor_on_a_segment_of_a_chunk(row: tuple[float, ...]) -> None:
    assert (cast([row, (9.0, -1.0, 9.0, 1.0)], [], beams()) < 1e-20).all()


def test_a_segment_seen_edge_on_and_a_disc_around_the_sensor() -> None:
    angles = np.linspace(-1.0, 1.0, 33)[:32]
    found = cast([(1.0, 0.0, 3.0, 0.0)], [(0.5, 0.0, 4.0)], angles)
    assert found[16] == pytest.approx(1.0, rel=1e-6)
    np.testing.assert_allclose(np.delete(found, 16), textbook([], [(0.5, 0.0, 4.0)], np.delete(angles, 16)), rtol=1e-6)


def test_what_is_out_of_range_or_shows_its_back_is_left_out() -> None:
    rows = [
        (2.0, -1.0, 2.0, 1.0),
        (2.0, 1.0, 2.0, -1.0),
        (7.0, -1.0, 7.0, 1.0),
        (9.0, 1.0, 5.0, 4.0),
        (-1.0, 3.0, 1.0, 3.0),
    ]
    sides, eye = np.zeros(1, SIDES)[0], Eye(0.0, 0.0, 1.0, 0.0)
    table, limits = np.array(rows).ravel(), np.zeros(CHUNK)  # the body lies to the left of the way from a to b
    assert prepare_segments(len(rows), eye, 6.5, table, limits, sides) == 0
    assert sides.mark[: len(rows)].tolist() == [0, 1, 0, 0, 1]
    limits[:] = np.inf
    assert prepare_segments(len(rows), eye, 6.5, table, limits, sides) == 0
    assert sides.mark[: len(rows)].tolist() == [1, 1, 0, 1, 1]


@pytest.mark.parametrize("count", [1, 7, 8, 9, 15, 16, 24, 64])
def test_any_number_of_segments_is_prepared(count: int) -> None:
    rng = np.random.default_rng(count)
    rows = rng.uniform(-5.0, 5.0, (CHUNK, 4))
    rows[count:] = np.nan
    sides, eye = np.zeros(1, SIDES)[0], Eye(1.0, 0.5, float(np.cos(0.3)), float(np.sin(0.3)))
    for name in NUMBERS:
        sides[name][:] = np.nan
    sides.mark[:] = 9
    assert prepare_segments(count, eye, 4.0, rows.ravel(), np.full(CHUNK, np.inf), sides) == 0
    away = shapely.distance(shapely.linestrings(rows[:count].reshape(-1, 2, 2)), shapely.Point(1.0, 0.5))
    assert sides.mark[:count].tolist() == (away <= 4.0).astype(int).tolist()
    assert all(np.isfinite(sides[name][:count]).all() for name in NUMBERS)
    assert (sides.mark[count:] == 9).all()


def test_rough_angles_are_near_enough() -> None:
    for angle in np.linspace(-np.pi, np.pi, 721)[1:-1]:
        found = rough_angle(np.float32(3.0 * np.cos(angle)), np.float32(3.0 * np.sin(angle)))
        assert found == pytest.approx(angle, abs=0.0065)


@pytest.mark.parametrize("sweep", [0.5, 2.0, 2.0 * np.pi])
def test_a_span_holds_the_beams_between_two_directions_and_few_more(sweep: float) -> None:
    """Also across the direction behind, where the beams of a full turn are at both ends of the fan."""
    n, rng = 2 * BLOCK, np.random.default_rng(36)
    angles = np.linspace(-0.5 * sweep, 0.5 * sweep, n)
    fan = n, np.float32(angles[0]), np.float32((n - 1) / sweep)
    n_across = 0
    for _ in range(300):
        low, width = rng.uniform(-np.pi, np.pi), rng.uniform(0.0, 3.0)
        high = low + width if low + width < np.pi else low + width - 2.0 * np.pi
        begin, runs = span(np.float32(low), np.float32(high), Fan(*fan))
        cast_to = (begin + np.arange(16 * runs)) % n
        between = np.flatnonzero((angles - low) % (2.0 * np.pi) <= width)
        assert begin % 16 == 0
        assert runs <= n // 16
        assert np.isin(between, cast_to).all()
        n_across += high < low and runs < n // 16
        assert 16 * runs <= len(between) + 36
    assert n_across > 20
