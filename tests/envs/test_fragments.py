"""What a sampler hands to a learner, against sums written out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from irsim_gym.envs.rllib.fragments import Fragment, FragmentWriter, advantages, joined

GAMMA, LAMBDA = 0.9, 0.8
LENGTHS, CUT = (3, 1, 4, 2), (False, True, True, False)
"""Pieces of the fragment, and which of them are cut."""


def fragment() -> Fragment:
    rng = np.random.default_rng(0)
    n, last = sum(LENGTHS), np.cumsum(LENGTHS) - 1
    terminated, cut = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    terminated[last[~np.array(CUT)]] = True
    cut[last[np.array(CUT)]] = True
    numbers = rng.normal(size=(n, 4)).astype(np.float32)
    following = rng.normal(size=(2, 3)).astype(np.float32)
    return Fragment(
        numbers[:, :3], numbers[:, :2], numbers[:, 0], numbers, numbers[:, 3], terminated, cut, following, n
    )


def by_hand(one: Fragment, values: np.ndarray, after: np.ndarray) -> list[float]:
    found, start, cuts = [], 0, iter(after.tolist())
    for length, is_cut in zip(LENGTHS, CUT, strict=True):
        rows = range(start, start + length)
        following = [*values[start + 1 : start + length].tolist(), next(cuts) if is_cut else 0.0]
        errors = [one.reward[t] + GAMMA * v - values[t] for t, v in zip(rows, following, strict=True)]
        found += [sum((GAMMA * LAMBDA) ** k * e for k, e in enumerate(errors[i:])) for i in range(length)]
        start += length
    return found


def test_advantages_are_sums_to_the_end_of_each_piece() -> None:
    one, rng = fragment(), np.random.default_rng(1)
    values, after = rng.normal(size=len(one)).astype(np.float32), rng.normal(size=2).astype(np.float32)
    found = advantages(one, values, after, gamma=GAMMA, lambda_=LAMBDA)
    np.testing.assert_allclose(found, by_hand(one, values, after), rtol=1e-5)


@pytest.mark.parametrize("place", range(1, sum(LENGTHS)))
def test_a_divided_fragment_is_cut_where_a_piece_goes_on(place: int) -> None:
    one = fragment()
    first, second = one[:place], one.slice(slice(place, None), len_lookback_buffer=1)
    assert len(first) + len(second) == len(one)
    goes_on = not (one.terminated | one.cut)[place - 1]
    assert first.cut[-1] == (goes_on or one.cut[place - 1])
    expected = one.observation[place] if goes_on else one.following[int(one.cut[:place].sum()) - 1]
    if first.cut[-1]:
        np.testing.assert_array_equal(first.following[-1], expected)
    whole = joined([first, second])
    np.testing.assert_array_equal(whole.reward, one.reward)
    assert whole.cut.sum() == one.cut.sum() + goes_on
    assert len(whole.following) == whole.cut.sum()


def test_rows_are_put_one_after_the_other_without_those_that_wait() -> None:
    """Row 0 is cut at step 1 and acts on; row 1 ends at step 0 and waits."""
    writer = FragmentWriter(2, 3)
    acted = np.array([[True, True], [True, False], [True, False]])
    terminated = np.array([[False, True], [False, False], [False, False]])
    cuts = ([], [0], [0])
    for t in range(3):
        seen = np.array([[10.0 + t], [20.0 + t]], np.float32)
        one = np.full(2, float(t), np.float32)
        columns = {"action": one, "log_probability": one, "distribution": seen, "reward": one}
        writer.note(seen, {**columns, "terminated": terminated[t], "acted": acted[t]})
        writer.note_cuts(np.array(cuts[t], np.int64), seen + 0.5)
    found = writer.fragment()
    assert found.observation[:, 0].tolist() == [10.0, 11.0, 12.0, 20.0]
    assert found.terminated.tolist() == [False, False, False, True]
    assert found.cut.tolist() == [False, True, True, False]
    assert found.following[:, 0].tolist() == [11.5, 12.5]
    assert found.steps == 6


def test_dicts_are_kept_as_dicts() -> None:
    one = fragment()
    parts = replace(one, observation={"a": one.observation}, following={"a": one.following})
    whole = joined([parts[:4], parts[4:]])
    assert isinstance(whole.observation, dict)
    np.testing.assert_array_equal(whole.observation["a"], one.observation)
