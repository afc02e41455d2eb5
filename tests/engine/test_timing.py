"""When work is shared: how much of it there is, and whether sharing paid so far."""

from __future__ import annotations

import pytest

from irsim_gym.engine import timing
from irsim_gym.engine.timing import JUDGED, Timing


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> Timing:
    """Return the timing of something that takes one thread 1 ms per world, and rests for 3 jobs, or 6 at most."""
    monkeypatch.setattr(timing, "REST", 3)
    monkeypatch.setattr(timing, "MOST_REST", 6)
    made = Timing()
    made.note(100.0, 1)
    made.note(0.010, 10)
    return made


def shared(made: Timing, seconds: float) -> None:
    for _ in range(JUDGED):
        made.note_shared(seconds, 10)


def rest(made: Timing) -> int:
    """Return how many jobs in a row may not be shared."""
    return next(k for k in range(1000) if made.is_worth_a_try())


def test_the_least_time_counts_but_not_the_first() -> None:
    made, seen = Timing(), []
    for seconds, n_worlds in ((0.001, 10), (0.004, 10), (0.001, 0), (0.005, 10), (0.006, 20)):
        made.note(seconds, n_worlds)
        seen.append(made.least_s)
    assert seen == pytest.approx([0.0, 0.0004, 0.0004, 0.0004, 0.0003])


@pytest.mark.parametrize(
    ("n_worlds", "most", "worth_s", "workers"),
    [(10, 4, 0.003, 3), (10, 2, 0.003, 2), (10, 4, 0.006, 1), (1, 4, 1.0, 1), (3, 8, 0.0, 3), (100, 4, 0.0, 4)],
)
def test_each_thread_has_enough_to_do(known: Timing, n_worlds: int, most: int, worth_s: float, workers: int) -> None:
    assert known.workers(n_worlds, most, worth_s) == workers


def test_what_has_not_been_timed_is_not_shared() -> None:
    assert Timing().workers(100, 4, 1e-9) == 1


def test_what_pays_goes_on(known: Timing) -> None:
    for _ in range(3):
        shared(known, 0.009)
        assert rest(known) == 0


def test_a_shared_job_may_take_a_little_longer(known: Timing) -> None:
    shared(known, 0.010 + 0.5 * timing.FIRST_S)
    assert rest(known) == 0
    shared(known, 0.010 + 1.5 * timing.FIRST_S)
    assert rest(known) == 3


def test_what_does_not_pay_rests_longer_each_time_until_it_pays(known: Timing) -> None:
    found = []
    for seconds in (0.011, 0.011, 0.011, 0.009, 0.011):
        shared(known, seconds)
        found.append(rest(known))
    assert found == [3, 6, 6, 0, 3]


def test_one_slow_job_among_fast_ones_is_forgiven(known: Timing) -> None:
    for k in range(JUDGED):
        known.note_shared(0.020 if k == 2 else 0.006, 10)
    assert rest(known) == 0
