"""When work is shared: how much of it there is, and whether sharing paid so far."""

from __future__ import annotations

import pytest

from irsim_gym.engine import pace
from irsim_gym.engine.pace import SPELL, Pace


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> Pace:
    """Return the pace of something that takes one thread 1 ms per world, and rests for 3 jobs, or 6 at most."""
    monkeypatch.setattr(pace, "REST", 3)
    monkeypatch.setattr(pace, "MOST_REST", 6)
    made = Pace()
    made.note(100.0, 1)
    made.note(0.010, 10)
    return made


def shared(made: Pace, seconds: float) -> None:
    for _ in range(SPELL):
        made.note_shared(seconds, 10)


def rest(made: Pace) -> int:
    """Return how many jobs in a row may not be shared."""
    return next(k for k in range(1000) if made.is_worth_a_try())


def test_the_least_time_counts_but_not_the_first() -> None:
    made, seen = Pace(), []
    for seconds, n_worlds in ((0.001, 10), (0.004, 10), (0.001, 0), (0.005, 10), (0.006, 20)):
        made.note(seconds, n_worlds)
        seen.append(made.least_s)
    assert seen == pytest.approx([0.0, 0.0004, 0.0004, 0.0004, 0.0003])


@pytest.mark.parametrize(
    ("n_worlds", "most", "worth_s", "workers"),
    [(10, 4, 0.003, 3), (10, 2, 0.003, 2), (10, 4, 0.006, 1), (1, 4, 1.0, 1), (3, 8, 0.0, 3), (100, 4, 0.0, 4)],
)
def test_each_has_enough_for_its_trouble(known: Pace, n_worlds: int, most: int, worth_s: float, workers: int) -> None:
    assert known.workers(n_worlds, most, worth_s) == workers


def test_nobody_shares_what_has_not_been_timed() -> None:
    assert Pace().workers(100, 4, 1e-9) == 1


def test_what_pays_goes_on(known: Pace) -> None:
    for _ in range(3):
        shared(known, 0.009)
        assert rest(known) == 0


def test_who_begins_a_shared_job_is_given_a_moment(known: Pace) -> None:
    shared(known, 0.010 + 0.5 * pace.FIRST_S)
    assert rest(known) == 0
    shared(known, 0.010 + 1.5 * pace.FIRST_S)
    assert rest(known) == 3


def test_what_does_not_pay_rests_longer_each_time_until_it_pays(known: Pace) -> None:
    found = []
    for seconds in (0.011, 0.011, 0.011, 0.009, 0.011):
        shared(known, seconds)
        found.append(rest(known))
    assert found == [3, 6, 6, 0, 3]


def test_one_slow_job_among_fast_ones_is_forgiven(known: Pace) -> None:
    for k in range(SPELL):
        known.note_shared(0.020 if k == 2 else 0.006, 10)
    assert rest(known) == 0
