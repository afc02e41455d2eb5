"""Linear programs in the plane against brute force."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.simulator.geometry.linear_program import HALF_PLANE, choose

LIMIT = 1.3


def half_planes(rng: np.random.Generator, count: int, low: float, high: float) -> np.ndarray:
    """Rows (normal x, normal y, least)."""
    angles = rng.uniform(-np.pi, np.pi, count)
    return np.stack([np.cos(angles), np.sin(angles), rng.uniform(low, high, count)], axis=1)


def chosen(planes: np.ndarray, n_hard: int, wanted: np.ndarray) -> np.ndarray:
    rows = np.ascontiguousarray(planes).view(HALF_PLANE)[:, 0]
    return np.array(choose(rows, n_hard, len(rows), LIMIT, wanted[0], wanted[1], np.zeros_like(rows)))


def disc_points(n_rings: int = 150, n_angles: int = 400) -> np.ndarray:
    radii = LIMIT * np.linspace(0.0, 1.0, n_rings)
    angles = 2.0 * np.pi * np.arange(n_angles) / n_angles
    return (radii[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)).reshape(-1, 2)


POINTS = disc_points()


def violation(planes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Worst violation at each point."""
    return (planes[:, 2] - points @ planes[:, :2].T).max(axis=-1, initial=-np.inf)


def test_without_half_planes_the_wanted_vector_is_shortened() -> None:
    planes = np.zeros((0, 3))
    assert chosen(planes, 0, np.array([0.3, -0.4])).tolist() == [0.3, -0.4]
    assert chosen(planes, 0, np.array([3.0, 4.0])) == pytest.approx([0.6 * LIMIT, 0.8 * LIMIT])
    assert chosen(planes, 0, np.zeros(2)).tolist() == [0.0, 0.0]


def test_by_hand() -> None:
    # x <= 0.5, then y <= 0.25 as well: the corner.
    planes = np.array([[-1.0, 0.0, -0.5], [0.0, -1.0, -0.25]])
    assert chosen(planes[:1], 0, np.array([1.0, 0.5])) == pytest.approx([0.5, 0.5])
    assert chosen(planes, 0, np.array([1.0, 0.5])) == pytest.approx([0.5, 0.25])
    # x >= 0.6 and x <= 0.2: both are missed by 0.2, unless one is hard.
    planes = np.array([[1.0, 0.0, 0.6], [-1.0, 0.0, -0.2]])
    assert chosen(planes, 0, np.zeros(2))[0] == pytest.approx(0.4)
    assert chosen(planes, 1, np.zeros(2))[0] == pytest.approx(0.6)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_permitted_vector_is_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_met = 0
    for _ in range(60):
        planes = half_planes(rng, int(rng.integers(1, 9)), -1.0, 0.25)
        permitted = POINTS[violation(planes, POINTS) <= 0.0]
        if not len(permitted):
            continue
        wanted = rng.uniform(-1.5, 1.5, 2)
        found = chosen(planes, 0, wanted)
        assert violation(planes, found) <= 1e-9
        assert np.hypot(*found) <= LIMIT + 1e-9
        best = np.hypot(*(permitted - wanted).T).min()
        gap = np.hypot(*(found - wanted))
        assert gap <= best + 1e-9
        n_met += 1
    assert n_met > 40


@pytest.mark.parametrize("seed", range(4))
def test_where_nothing_is_permitted_the_worst_violation_is_least(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    n_met = 0
    for _ in range(60):
        planes = half_planes(rng, int(rng.integers(3, 9)), 0.0, 1.0)
        worst = violation(planes, POINTS)
        if worst.min() <= 0.02:
            continue
        found = chosen(planes, 0, rng.uniform(-1.0, 1.0, 2))
        assert np.hypot(*found) <= LIMIT + 1e-9
        assert 0.0 < violation(planes, found) <= worst.min() + 1e-9
        n_met += 1
    assert n_met > 25


@pytest.mark.parametrize("seed", range(4))
def test_hard_half_planes_hold_while_the_others_are_violated_least(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    n_met = 0
    for _ in range(60):
        n_hard = int(rng.integers(1, 4))
        hard = half_planes(rng, n_hard, -0.8, 0.1)
        soft = half_planes(rng, int(rng.integers(2, 6)), 0.0, 0.9)
        allowed = POINTS[violation(hard, POINTS) <= 0.0]
        if not len(allowed) or violation(soft, allowed).min() <= 0.02:
            continue
        found = chosen(np.concatenate([hard, soft]), n_hard, rng.uniform(-1.0, 1.0, 2))
        assert violation(hard, found) <= 1e-9
        assert violation(soft, found) <= violation(soft, allowed).min() + 1e-9
        n_met += 1
    assert n_met > 25


def test_repeated_and_opposite_half_planes() -> None:
    plane = np.array([0.6, 0.8, 0.3])
    assert chosen(np.stack([plane] * 4), 0, np.zeros(2)) == pytest.approx([0.18, 0.24])
    between = np.stack([plane, plane, -plane])
    assert chosen(between, 0, np.array([0.8, -0.6])) == pytest.approx([0.98, -0.36])
    assert chosen(np.array([[1.0, 0.0, 2.0]]), 0, np.zeros(2))[0] == pytest.approx(LIMIT)
