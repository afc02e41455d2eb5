from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from irsim_gym.simulator.geometry.rays import inverse_depth_disc, inverse_depth_segment
from tests.simulator.geometry.ray_rooms import N_BEAMS, beams, random_room, steady, textbook
from tests.simulator.geometry.shapes import closed

FAR = 20.0


def cast(
    segments: Any, discs: Any, angles: NDArray[np.float64] | None = None, *, plain: bool = False
) -> NDArray[np.float64]:
    """Return ranges of a sensor at the origin, inf where nothing is met."""
    angles = beams() if angles is None else angles
    x, y = np.cos(angles).astype(np.float32), np.sin(angles).astype(np.float32)
    inverse = np.zeros(len(angles), np.float32)
    segment: Any = inverse_depth_segment.py_func if plain else inverse_depth_segment  # type: ignore[attr-defined]
    ring: Any = inverse_depth_disc.py_func if plain else inverse_depth_disc  # type: ignore[attr-defined]
    for row in np.asarray(segments, np.float32).reshape(-1, 4):
        segment(*row, x, y, inverse)
    for row in np.asarray(discs, np.float32).reshape(-1, 3):
        ring(*row, x, y, inverse)
    assert inverse.dtype == np.float32
    return np.divide(1.0, inverse, out=np.full(len(angles), np.inf), where=inverse > 0.0, dtype=np.float64)


def test_rooms_against_float64() -> None:
    rng = np.random.default_rng(21)
    total = grazing = 0
    for _ in range(150):
        segments, discs = random_room(rng)
        found, expected = cast(segments, discs), textbook(segments, discs, beams())
        calm = steady(segments, discs, beams())
        assert np.max(np.abs(found - expected)[calm]) < 2e-5
        total, grazing = total + N_BEAMS, grazing + int(np.sum(np.abs(found - expected) > 1e-4))
    assert grazing <= total * 1e-4


def test_segments_against_shapely() -> None:
    rng = np.random.default_rng(22)
    origin = shapely.Point(0.0, 0.0)
    for _ in range(20):
        segments = random_room(rng)[0].astype(np.float32).astype(np.float64)
        scene = shapely.union_all(shapely.linestrings(segments.reshape(-1, 2, 2)))
        ends = FAR * np.stack([np.cos(beams()), np.sin(beams())], axis=1)
        rays = shapely.linestrings(np.stack([np.zeros_like(ends), ends], axis=1))
        expected = shapely.distance(shapely.intersection(rays, scene), origin)
        wrong = np.abs(cast(segments, []) - expected) > 1e-4
        assert not np.any(wrong & steady(segments, [], beams()))


def test_compiled_agrees_with_plain_python() -> None:
    rng = np.random.default_rng(23)
    with np.errstate(all="ignore"):
        for _ in range(3):
            segments, discs = random_room(rng)
            calm = steady(segments, discs, beams(64))
            twin = cast(segments, discs, beams(64), plain=True)
            np.testing.assert_allclose(cast(segments, discs, beams(64))[calm], twin[calm], rtol=1e-5)


def test_no_beam_slips_through_a_shared_vertex() -> None:
    """Beams that point exactly at the vertices of a ring around the sensor all meet it."""
    rng = np.random.default_rng(24)
    for n in (3, 7, 16, 100):
        for _ in range(40):
            angles = np.sort(rng.uniform(-np.pi, np.pi, n)) if n > 3 else np.array([-2.0, 0.1, 2.2])
            if np.max(np.diff(np.append(angles, angles[0] + 2.0 * np.pi))) >= 3.0:
                continue
            radii = rng.uniform(0.1, 30.0, n)
            ring = closed(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)).astype(np.float32)
            aims = np.arctan2(ring[:, 1].astype(np.float64), ring[:, 0].astype(np.float64))
            found = cast(ring, [], np.resize(aims, -(-n // 16) * 16))[:n]
            assert np.all(np.isfinite(found))
            assert np.all(found <= np.max(radii) * 1.0001)


@pytest.mark.parametrize("flip", [False, True])
def test_by_hand(flip: bool) -> None:
    wall = np.array([[2.0, -1.0, 2.0, 1.0]])
    wall = wall[:, [2, 3, 0, 1]] if flip else wall
    angles = np.resize([0.0, np.arctan(0.5), -np.arctan(0.5), np.arctan(0.51), np.pi, 0.5 * np.pi], 16)
    found = cast(wall, [], angles)[:6]
    np.testing.assert_allclose(found[:3], [2.0, np.sqrt(5.0), np.sqrt(5.0)], rtol=1e-6)
    assert np.isinf(found[3:]).all()


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.7, -2.9])
@pytest.mark.parametrize("ends", [(1.0, 3.0), (3.0, 1.0), (2.0, 2.0)])
def test_edge_on_segment_is_met_at_its_nearer_end(turn: float, ends: tuple[float, float]) -> None:
    cosine, sine = np.cos(turn), np.sin(turn)
    row = [ends[0] * cosine, ends[0] * sine, ends[1] * cosine, ends[1] * sine]
    angles = np.resize([turn, turn + 1e-4, turn - 1e-4, turn + np.pi, turn + 1.0], 16)
    found = cast([row], [], angles)[:5]
    assert found[0] == pytest.approx(min(ends), rel=1e-6)
    assert np.isinf(found[1:]).all()


@pytest.mark.parametrize("row", [(-1.0, 0.0, 2.0, 0.0), (0.0, 0.0, 2.0, 1.0), (1.0, 1.0, 0.0, 0.0), (0.0,) * 4])
def test_sensor_on_a_segment_is_at_distance_zero(row: tuple[float, ...]) -> None:
    assert (cast([row], []) < 1e-20).all()


def test_disc_by_hand() -> None:
    angles = np.resize([0.0, np.pi, 0.5 * np.pi, np.arcsin(0.2) - 1e-4, np.arcsin(0.2) + 1e-4], 16)
    found = cast([], [[5.0, 0.0, 1.0]], angles)[:5]
    assert found[0] == pytest.approx(4.0, rel=1e-6)
    assert found[3] == pytest.approx(np.sqrt(24.0) - np.sqrt(1e-4 * 2.0 * np.sqrt(24.0)), abs=1e-3)
    assert np.isinf(found[[1, 2, 4]]).all()


def test_sensor_in_a_disc_sees_the_exit() -> None:
    angles = np.resize([0.0, np.pi, 0.5 * np.pi], 16)
    np.testing.assert_allclose(cast([], [[0.5, 0.0, 1.0]], angles)[:3], [1.5, 0.5, np.sqrt(0.75)], rtol=1e-6)
    np.testing.assert_allclose(cast([], [[0.0, 0.0, 2.0]]), 2.0, rtol=1e-6)


def test_sensor_on_the_rim_of_a_disc() -> None:
    angles = np.resize([0.0, 0.7, np.pi, 2.0], 16)
    found = cast([], [[1.0, 0.0, 1.0]], angles)[:4]
    assert (found[:2] < 1e-6).all()
    assert np.isinf(found[2:]).all()


def test_the_nearest_hit_stays() -> None:
    far_first = cast([[4.0, -9.0, 4.0, 9.0], [2.0, -9.0, 2.0, 9.0]], [], np.zeros(16))
    near_first = cast([[2.0, -9.0, 2.0, 9.0], [4.0, -9.0, 4.0, 9.0]], [[8.0, 0.0, 1.0]], np.zeros(16))
    assert far_first[0] == near_first[0] == pytest.approx(2.0)


@given(st.integers(0, 5000), st.floats(-3.0, 3.0))
def test_turning_everything_changes_nothing(seed: int, turn: float) -> None:
    segments, discs = random_room(np.random.default_rng(seed))
    calm = steady(segments, discs, beams())
    cosine, sine = np.cos(turn), np.sin(turn)
    matrix = np.array([[cosine, sine], [-sine, cosine]])
    turned = (segments.reshape(-1, 2) @ matrix).reshape(-1, 4)
    moved = np.hstack([discs[:, :2] @ matrix, discs[:, 2:]])
    np.testing.assert_allclose(cast(segments, discs)[calm], cast(turned, moved, beams() + turn)[calm], atol=1e-4)
