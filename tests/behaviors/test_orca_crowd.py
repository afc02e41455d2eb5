"""How a member of an ORCA group finds its nearest ones, and its half-planes side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.behaviors.orca_crowd import Crowd, gather, keep_nearest, lay_squares, reserve, sort_members
from irsim_gym.behaviors.orca_lines import LANE_ROWS, LANES, disc_plane, disc_planes

BOUNDS = np.array([-5.0, 0.0, 25.0, 20.0])


def found_by(crowd: Crowd, m: int, squares: np.ndarray, reach: float) -> list[int]:
    """Search as ``plan_velocities`` does; return bodies, nearest first."""
    columns, rows = int(squares[3]), int(squares[4])
    place = int(np.searchsorted(crowd.starts[1 : columns * rows + 1], m, side="right"))
    x, y, ring = *crowd.places[:, m], 1
    while True:
        within = reach if ring >= max(columns, rows) else min(reach, ring * squares[5])
        n_found = gather(
            m, x, y, within, ring, place % columns, place // columns, columns, rows,
            crowd.starts, crowd.places, crowd.gap2, crowd.found,
        )  # fmt: skip
        if n_found >= len(crowd.nearest) or within >= reach:
            break
        ring *= 2
    count = keep_nearest(n_found, crowd.gap2, crowd.found, crowd.body, crowd.nearest_gap, crowd.nearest)
    return list(crowd.body[crowd.nearest[:count]])


@pytest.mark.parametrize(
    ("n_bodies", "reach", "most", "n_squares"),
    [(12, 5.0, 4, 1), (150, 3.0, 8, 2), (150, 40.0, 5, 2), (150, 1e200, 200, 1), (150, 2.0, 0, 1), (150, 0.8, 3, 99)],
)
@pytest.mark.parametrize("spread", [0.0, 30.0])
def test_the_nearest_are_those_of_all_pairs(
    n_bodies: int, reach: float, most: int, n_squares: int, spread: float
) -> None:
    rng = np.random.default_rng(n_bodies + most)
    members = np.sort(rng.choice(n_bodies + 20, n_bodies, replace=False))
    pose = np.zeros((n_bodies + 20, 3))
    pose[:, :2] = rng.uniform(BOUNDS[:2], BOUNDS[2:], (len(pose), 2)) + rng.normal(0.0, spread, (len(pose), 2))
    pose[members[: n_bodies // 3], :2] = np.round(pose[members[: n_bodies // 3], :2])  # many at the same distance
    seen, present = rng.random(len(pose)) < 0.9, rng.random(len(pose)) < 0.9
    squares = lay_squares(BOUNDS, n_bodies, reach, most)
    assert squares[3] * squares[4] >= n_squares
    crowd = Crowd(*(rows[0] for rows in reserve(1, n_bodies, most, int(squares[3] * squares[4])).values()))
    moves: Any = np.zeros((len(pose), 3))
    sort_members(members, squares, seen, seen, present, np.zeros(len(pose)), pose, moves[:, :2].copy(), moves, crowd)
    n_present = int(present[members].sum())
    assert sorted(crowd.body[:n_present]) == members[present[members]].tolist()
    for m in range(n_present):
        b = crowd.body[m]
        if not seen[b]:
            assert np.isinf(crowd.places[0, m])
            continue
        gap2 = (pose[:, 0] - pose[b, 0]) ** 2 + (pose[:, 1] - pose[b, 1]) ** 2
        others = [(gap2[q], q) for q in members if q != b and seen[q] and present[q] and np.sqrt(gap2[q]) < reach]
        assert found_by(crowd, m, squares, reach) == [q for _, q in sorted(others)[:most]]


def test_half_planes_side_by_side_are_those_one_by_one() -> None:
    rng, lanes, n_round = np.random.default_rng(2), np.zeros((LANE_ROWS, LANES)), 0
    for _ in range(200):
        lanes[:2] = rng.uniform(-3.0, 3.0, (2, LANES))
        lanes[2:4] = rng.uniform(-1.0, 1.0, (2, LANES))
        lanes[4] = rng.uniform(0.1, 1.0, LANES)
        vx, vy, flat = *rng.uniform(-1.0, 1.0, 2), lanes.ravel()
        disc_planes(vx, vy, 0.1, 3.0, 0.5, flat)
        one = np.zeros(3)
        for x, y, ux, uy, radius, *written in lanes.T:
            time = 0.1 if x * x + y * y <= radius * radius else 3.0
            disc_plane(x, y, vx, vy, ux, uy, radius, time, 0.5, 1.0, one)
            assert written == one.tolist()
            n_round += x * x + y * y <= radius * radius
    assert n_round > 20


def test_the_centre_of_the_cut_off_disc_is_left_to_others() -> None:
    lanes = np.ones((LANE_ROWS, LANES))
    lanes[:, 0] = [0.0, 0.0, 0.5, 0.5, 1.0, 7.0, 7.0, 7.0]
    disc_planes(0.5, 0.5, 0.1, 3.0, 0.5, lanes.ravel())
    assert np.isnan(lanes[5:, 0]).all()
    assert np.isfinite(lanes[5:, 1:]).all()
