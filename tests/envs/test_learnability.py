"""Which levels are played again: estimates against integrals, choices against what was counted."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from scipy import integrate, stats

from irsim_gym.envs.sb3_learning.learnability import PRIOR, LearnableLevels, expected_learnability


def played(known: LearnableLevels, results: dict[int, list[float]]) -> LearnableLevels:
    """Let world 0 play levels one after another, with the success of each episode, and update once."""
    for level, successes in results.items():
        for success in successes:
            known.count(0, level, success)
            known.follow(np.array([0]))
    known.update()
    return known


@pytest.mark.parametrize(("wins", "plays", "success"), [(0, 0, 0.3), (0, 1, 0.9), (1, 1, 0.9), (2.5, 4, 0.6)])
def test_learnability_is_an_expectation(wins: float, plays: float, success: float) -> None:
    belief = stats.beta(PRIOR * success + wins, PRIOR * (1 - success) + plays - wins)
    # By parts over the distribution function, which is bounded where the density is not.
    expected, _ = integrate.quad(lambda p: (2 * p - 1) * belief.cdf(p), 0.0, 1.0, epsabs=1e-10)
    found = expected_learnability(np.array([wins]), np.array([plays]), success)
    assert found == pytest.approx([expected], abs=1e-8)


def test_the_most_learnable_levels_are_kept() -> None:
    drawn = {level: [1.0] for level in range(20)}
    known = played(LearnableLevels(1, size=2, share=0.0), {**drawn, 40: [0.0], 41: [1.0, 0.0], 42: [0.0, 0.0, 0.0]})
    assert known.levels.tolist() == [41, 40]
    assert known.plays.tolist() == [2.0, 1.0]
    assert known.wins.tolist() == [1.0, 0.0]
    assert known.success == pytest.approx((21 + 1) / (26 + 2))


def test_levels_that_are_solved_at_first_are_the_learnable_ones() -> None:
    known = played(LearnableLevels(1, size=1, share=0.0), {**{k: [0.0] for k in range(9)}, 9: [1.0]})
    assert known.levels.tolist() == [9]


def test_evidence_fades() -> None:
    known = played(LearnableLevels(1, size=3, share=0.0), {7: [0.0]})
    for _ in range(2):  # six levels are twice the size: evidence then counts half
        played(known, {8: [1.0], 9: [1.0], 10: [1.0]})
    rows = dict(zip(known.levels.tolist(), known.plays.tolist(), strict=True))
    assert rows[7] == pytest.approx(0.5)
    assert rows[8] == pytest.approx(1.0 + 0.5**0.5)


def test_levels_are_chosen_in_proportion_to_their_learnability() -> None:
    known = played(LearnableLevels(1, share=0.75, seed=3), {5: [1.0, 0.0], 6: [0.0], 7: [1.0]})
    worlds = np.zeros(1, np.int64)
    chosen = np.array([known.follow(worlds)[0] for _ in range(8000)])
    assert set(chosen.tolist()) == {-1, 5, 6, 7}
    shares = np.array([(chosen == level).mean() for level in known.levels])
    expected = 0.75 * known.learnability / known.learnability.sum()
    assert np.abs(shares - expected).max() < 5 * np.sqrt(0.25 / 8000)
    assert (chosen == -1).mean() == pytest.approx(0.25, abs=5 * np.sqrt(0.25 / 8000))


def test_chosen_levels_are_not_counted_as_drawn_ones() -> None:
    known = played(LearnableLevels(2, share=1.0), {5: [1.0]})
    assert known.success == pytest.approx((1 + 1) / (1 + 2))
    assert known.follow(np.array([1])).tolist() == [5]
    known.follow(np.array([1]))  # now it plays the chosen one
    known.count(1, 5, 0.0)
    known.follow(np.array([1]))
    known.update()
    assert known.success == pytest.approx((0.5 ** (1 / 2000) + 1) / (0.5 ** (1 / 2000) + 2))
    assert known.plays == pytest.approx([1 + 0.5 ** (1 / 2000)])


def test_the_success_of_a_team_is_the_mean_of_its_episodes() -> None:
    known = LearnableLevels(2, share=0.0)
    for world, success in ((0, 1.0), (1, 0.0), (0, 0.0), (0, 1.0), (0, 1.0)):
        known.count(world, 30 + world, success)
    known.follow(np.array([0, 1]))
    known.follow(np.array([0, 1]))  # without an episode there is nothing to note
    known.update()
    rows = zip(known.levels.tolist(), known.wins.tolist(), known.plays.tolist(), strict=True)
    assert sorted(rows) == [(30, 0.75, 1.0), (31, 0.0, 1.0)]


def test_a_copy_goes_on_as_the_original() -> None:
    def go_on(known: LearnableLevels) -> list[Any]:
        worlds = np.array([0, 1])
        known.count(0, 4, 1.0)
        return [known.follow(worlds).tolist(), known.update(), *(known.follow(worlds).tolist() for _ in range(20))]

    known = played(LearnableLevels(2, seed=1), {4: [1.0, 0.0], 5: [0.0]})
    known.count(1, 6, 1.0)
    assert go_on(pickle.loads(pickle.dumps(known))) == go_on(known)


@pytest.mark.parametrize(
    ("wrong", "told"), [({"share": 1.5}, "share must be from 0 to 1"), ({"size": 0}, "at least 1")]
)
def test_what_cannot_be(wrong: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        LearnableLevels(1, **wrong)
