"""Success on the worst levels, worked by hand."""

from __future__ import annotations

import math

import pytest

from irsim_gym.evaluation.measures.worst_levels import worst_of_policies, worst_share, worst_shares


@pytest.mark.parametrize(
    ("rows", "share", "value"),
    [
        # The first row calls levels 0 and 1 the worst (second: 0 and 1), the second 0 and 2 (first: 0 and 1).
        ([[0, 0, 1, 1], [0, 1, 0, 1]], 0.5, 0.5),
        # Failures by chance are not the same ones again: choosing and scoring by one row would say 0.
        ([[0, 1, 1, 1], [1, 1, 1, 0]], 0.25, 1.0),
        ([[0, 1, 1, 1], [0, 1, 1, 1]], 0.01, 0.0),
        # Of three rows, the first and third choose what the second scores: level 3, which it solves.
        ([[1, 1, 1, 0], [0, 1, 1, 1], [1, 1, 1, 0]], 0.25, 1.0),
    ],
)
def test_worst_share_is_scored_by_the_other_half(rows: list[list[int]], share: float, value: float) -> None:
    assert worst_share(rows, share) == pytest.approx(value)


def test_a_lone_repetition_chooses_and_scores() -> None:
    # Two of 100 levels fail: they are two of the worst five, and the worst one.
    assert worst_shares([[True] * 40 + [False] * 2 + [True] * 58]) == {"5 %": pytest.approx(0.6), "1 %": 0.0}
    assert math.isnan(worst_share([[]], 0.5))


def test_policies_are_measured_alone_and_as_a_method() -> None:
    solved = {"a-1": [False, True, True, True], "a-2": [True, True, True, False], "b": [True] * 4}
    found = worst_of_policies(solved, {"a": ["a-1", "a-2"]})
    assert [(name, shares["5 %"]) for name, shares in found.items()] == [("a-1", 0), ("a-2", 0), ("b", 1), ("a", 1)]
