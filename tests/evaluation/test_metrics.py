import math

import pytest

from irsim_gym.evaluation.measures.metrics import EpisodeRow, mean, rate, summarize, wilson


def row(outcome: str = "success", **values: object) -> EpisodeRow:
    given = {"level": 0, "hit": "", "steps": 10, "time": 1.0, "path_length": 5.0, "optimum": 4.0, "min_clearance": 0.5}
    return EpisodeRow(outcome=outcome, **{**given, **values})  # type: ignore[arg-type]


def test_wilson_interval_worked_by_hand() -> None:
    # 8 of 10, z = 1.959964: z2 = 3.841459; centre (0.8 + 0.192073) / 1.3841459 = 0.716742;
    # spread 1.959964 * sqrt(0.016 + 0.00960365) / 1.3841459 = 0.226575
    low, high = wilson(8, 10)
    assert low == pytest.approx(0.490167, abs=2e-5)
    assert high == pytest.approx(0.943317, abs=2e-5)


def test_wilson_interval_at_the_ends() -> None:
    # n = 1000, none: high = z2 / (n + z2) = 3.841459 / 1003.841459
    assert wilson(0, 1000) == (0.0, pytest.approx(0.0038268, abs=1e-6))
    assert wilson(1000, 1000) == (pytest.approx(1.0 - 0.0038268, abs=1e-6), 1.0)
    assert wilson(0, 0) == (0.0, 1.0)
    assert rate(0, 0).value == 0.0


def test_spl_term_and_path_ratio() -> None:
    assert row().spl == pytest.approx(4.0 / 5.0)
    assert row().path_ratio == pytest.approx(1.25)
    shorter_by_the_tolerance = row(path_length=3.8)
    assert shorter_by_the_tolerance.spl == 1.0
    assert shorter_by_the_tolerance.path_ratio == pytest.approx(0.95)


@pytest.mark.parametrize("outcome", ["collision", "timeout", "left_world"])
def test_failures_have_no_spl(outcome: str) -> None:
    assert row(outcome).spl == 0.0
    assert math.isnan(row(outcome).path_ratio)


def test_optimum_that_was_not_found_or_is_zero() -> None:
    assert row(optimum=math.inf).spl == 1.0
    assert math.isnan(row(optimum=math.inf).path_ratio)
    assert row(optimum=0.0, path_length=0.0).spl == 1.0


def test_summary_of_a_handful() -> None:
    rows = [
        row(time=2.0),
        row(time=4.0, path_length=8.0, optimum=8.0),
        row("collision", hit="moving obstacle", time=9.0),
        row("collision", hit="obstacle", min_clearance=0.0),
        row("timeout"),
    ]
    summary = summarize("some", rows)
    assert summary.episodes == 5
    assert (summary.success.count, summary.success.value) == (2, 0.4)
    assert (summary.collision.count, summary.goals_per_collision) == (2, 1.0)
    assert {hit: share.count for hit, share in summary.collision_with.items()} == {
        "obstacle": 1,
        "moving obstacle": 1,
        "robot": 0,
    }
    assert (summary.timeout.count, summary.left_world.count) == (1, 0)
    assert summary.spl == pytest.approx((0.8 + 1.0) / 5)
    assert summary.time == pytest.approx(3.0)
    assert summary.path_length == pytest.approx(6.5)
    assert summary.path_ratio == pytest.approx((1.25 + 1.0) / 2)
    assert summary.min_clearance == pytest.approx(4 * 0.5 / 5)


def test_outcomes_must_be_exhaustive() -> None:
    with pytest.raises(AssertionError, match="must equal the number of episodes"):
        summarize("some", [row("running")])
    with pytest.raises(AssertionError, match="must have a kind"):
        summarize("some", [row("collision", hit="")])


def test_summary_without_successes() -> None:
    summary = summarize("some", [row("timeout")])
    assert summary.spl == 0.0
    assert math.isnan(summary.time)
    assert math.isnan(mean([]))
