"""How a member of an ORCA group finds its nearest ones, and its half-planes side by side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from irsim_gym.base.kernels.structs import Struct
from irsim_gym.bodies.behaviors.orca.crowd import Crowd, find_nearest, lay_squares, sort_members
from irsim_gym.bodies.behaviors.orca.lines import DISC_LANES, LANES, Other, disc_plane, disc_planes
from irsim_gym.bodies.behaviors.shared.surroundings import Ego
from irsim_gym.simulator.geometry.linear_program import HALF_PLANE

BOUNDS = np.array([-5.0, 0.0, 25.0, 20.0])


@dataclass
class Bodies(Struct):
    """What ``sort_members`` reads of model and state, in one world."""

    present: Any
    radius: Any
    pose: Any
    plan: Any
    twist: Any
    watchers: Any
    seen_row: Any


def found_by(bodies: Any, crowd: Crowd, m: int, x: float, y: float, reach: float) -> list[int]:
    """Return the bodies that a member sees, nearest first."""
    squares = crowd.squares
    place = int(np.searchsorted(crowd.starts[1 : squares.columns * squares.rows + 1], m, side="right"))
    ego = Ego(x, y, 0.0, 0.0, 0.0)
    return list(crowd.body[crowd.nearest[: find_nearest(bodies, ego, m, place, reach, crowd)]])


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
    assert squares.columns * squares.rows >= n_squares
    crowd, moves = Crowd.reserve(members, squares, seen, seen, most), np.zeros((1, len(pose), 3))
    bodies: Any = Bodies(
        *(present[None], moves[..., 0].copy(), pose[None], moves[..., :2].copy(), moves),
        *(np.ones((1, len(pose)), np.bool_), np.zeros(len(pose), np.int64)),
    )
    sort_members(bodies, bodies, 0, crowd)
    n_present = int(present[members].sum())
    assert sorted(crowd.body[:n_present]) == members[present[members]].tolist()
    for m in range(n_present):
        b = crowd.body[m]
        if not seen[b]:
            assert np.isinf(crowd.x[m])
            continue
        gap2 = (pose[:, 0] - pose[b, 0]) ** 2 + (pose[:, 1] - pose[b, 1]) ** 2
        others = [(gap2[q], q) for q in members if q != b and seen[q] and present[q] and np.sqrt(gap2[q]) < reach]
        assert found_by(bodies, crowd, m, pose[b, 0], pose[b, 1], reach) == [q for _, q in sorted(others)[:most]]


def test_half_planes_side_by_side_are_those_one_by_one() -> None:
    rng, lanes, n_round = np.random.default_rng(2), np.zeros(1, DISC_LANES)[0], 0
    for _ in range(200):
        lanes.x, lanes.y = rng.uniform(-3.0, 3.0, (2, LANES))
        lanes.vx, lanes.vy = rng.uniform(-1.0, 1.0, (2, LANES))
        lanes.radius = rng.uniform(0.1, 1.0, LANES)
        ego = Ego(0.0, 0.0, rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), 0.0)
        disc_planes(ego, 0.1, 3.0, 0.5, lanes)
        one = np.zeros(1, HALF_PLANE)[0]
        for j in range(LANES):
            other = Other(*(float(lanes[name][j]) for name in Other._fields))
            overlap = other.x * other.x + other.y * other.y <= other.radius * other.radius
            disc_plane(ego, other, 0.1 if overlap else 3.0, 0.5, 1.0, one)
            assert (lanes.nx[j], lanes.ny[j], lanes.least[j]) == one.item()
            n_round += overlap
    assert n_round > 20


def test_the_centre_of_the_cut_off_disc_is_left_to_others() -> None:
    lanes = np.zeros(1, DISC_LANES)[0]
    for name in ("x", "y", "vx", "vy", "radius"):
        lanes[name] = 1.0
    lanes.x[0], lanes.y[0], lanes.vx[0], lanes.vy[0] = 0.0, 0.0, 0.5, 0.5
    disc_planes(Ego(0.0, 0.0, 0.5, 0.5, 0.0), 0.1, 3.0, 0.5, lanes)
    planes = np.array([lanes.nx, lanes.ny, lanes.least])
    assert np.isnan(planes[:, 0]).all()
    assert np.isfinite(planes[:, 1:]).all()
