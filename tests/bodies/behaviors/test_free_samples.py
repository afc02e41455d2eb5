"""The nearest free sample, rows side by side, is that of a look at every sample and every cone."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.bodies.behaviors.rvo.free_samples import ROWS, SPAN, RvoTables, nearest_free, rough_cones
from irsim_gym.bodies.behaviors.rvo.velocity_obstacles import (
    CONE,
    HRVO,
    RVO,
    VO,
    Axis,
    disc_cones,
    lay_samples,
    side_cones,
)
from irsim_gym.bodies.behaviors.shared.surroundings import DISC, Ego, Surroundings

Rows = np.ndarray


def every_sample(cones: Rows, along_x: Axis, along_y: Axis) -> int:
    """Return the nearest sample outside of all cones; edges belong to them, and ties go to the lower number."""
    xs, ys = (along.first + np.arange(along.n) * along.step for along in (along_x, along_y))
    wx, wy = xs[:, None, None] - cones["apex_x"], ys[None, :, None] - cones["apex_y"]
    inside = cones["left_x"] * wy - wx * cones["left_y"] <= 0.0
    inside &= cones["right_x"] * wy - wx * cones["right_y"] >= 0.0
    gaps = np.hypot(*np.broadcast_arrays(xs[:, None] - along_x.wanted, ys[None, :] - along_y.wanted))
    gaps[inside.any(axis=2)] = np.inf
    return int(np.argmin(gaps)) if np.isfinite(gaps).any() else -1


def both(
    mode: int, body: Rows, rounds: Rows, sides: Rows, wanted: Rows, change: float, limit: float
) -> tuple[int, int]:
    """Return what ``nearest_free`` finds, and what a look at everything does."""
    ego, n_rounds, discs = Ego(*body.tolist()), len(rounds), np.zeros(len(rounds), DISC)
    for name, values in zip(DISC.names or (), rounds.T, strict=False):
        discs[name] = values
    exact = np.zeros(n_rounds + len(sides), CONE)
    along_x = lay_samples(ego.vx, change, limit, float(wanted[0]))
    along_y = lay_samples(ego.vy, change, limit, float(wanted[1]))
    disc_cones(mode, ego, discs, exact)
    n_cones = side_cones(ego, sides, exact, n_rounds)
    expected = every_sample(exact[:n_cones], along_x, along_y)
    no_ints = np.zeros(0, np.int64)
    seen, cones = Surroundings(no_ints, no_ints, discs, sides, np.zeros((0, 3))), np.zeros_like(exact)
    tables = RvoTables(seen, cones, np.zeros(len(cones), SPAN), np.zeros(1, ROWS), np.zeros((2, 0)), no_ints[None])
    side_cones(ego, sides, cones, n_rounds)
    rough_cones(mode, ego, discs, cones)
    return nearest_free(mode, ego, n_cones, along_x, along_y, tables), expected


@pytest.mark.parametrize("mode", [RVO, HRVO, VO])
@pytest.mark.parametrize(("n_rounds", "n_sides"), [(0, 0), (1, 0), (4, 1), (8, 0), (25, 3)])
def test_the_nearest_free_sample_is_that_of_all(mode: int, n_rounds: int, n_sides: int) -> None:
    rng, found = np.random.default_rng(10 * mode + n_rounds), set()
    for k in range(80):
        rounds = rng.uniform([-3, -3, -1, -1, 0.1], [3, 3, 1, 1, 0.6], (n_rounds, 5))
        sides = rng.uniform(-3.0, 3.0, (n_sides, 4))
        body, wanted = rng.uniform([-1, -1, -1, -1, 0.1], [1, 1, 1, 1, 0.5]), rng.uniform(-1.5, 1.5, 2)
        if k % 2:  # everything on the grid of the samples: edges run through samples, and distances tie
            rounds, sides, wanted = np.round(rounds * 2) / 2, np.round(sides * 2) / 2, np.round(wanted * 10) / 10
            body = np.array([0.0, 0.0, *np.round(body[2:4] * 10) / 10, 0.25])
        one, other = both(mode, body, rounds, sides, wanted, rng.choice([0.01, 0.3, 1.0, 2.0]), rng.choice([0.7, 1.5]))
        assert one == other
        found.add(one)
    assert len(found) > 10 or n_rounds == 25


@pytest.mark.parametrize("mode", [RVO, VO])
def test_samples_on_an_edge_belong_to_the_cone(mode: int) -> None:
    # Both at rest, so the apex is the sample 0; by hand: the edges run at +-30 degrees, or +-90 where discs touch.
    still = np.array([0.0, 0.0, 0.0, 0.0, 0.5])
    nothing = np.zeros((0, 4))
    for gap in (2.0, 1.0, 0.5, 0.0):
        rounds = np.array([[gap, 0.0, 0.0, 0.0, 0.5]])
        one, other = both(mode, still, rounds, nothing, np.array([0.0, 0.0]), 1.0, 1.5)
        assert one == other
        one, other = both(mode, still, rounds, nothing, np.array([0.5, 0.0]), 1.0, 1.5)
        assert one == other


def test_where_everything_is_forbidden_there_is_none() -> None:
    around = np.array([[x, y, 0.0, 0.0, 0.5] for x in (-0.4, 0.4) for y in (-0.4, 0.4)])
    assert both(RVO, np.array([0, 0, 0.1, 0, 0.5]), around, np.zeros((0, 4)), np.array([1.0, 0.0]), 1.0, 1.5) == (
        -1,
        -1,
    )
