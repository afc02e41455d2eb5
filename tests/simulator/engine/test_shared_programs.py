"""Recorded work on threads: every world once, in each of many jobs that follow each other."""

from __future__ import annotations

import signal
import time
from types import FrameType

import numpy as np
import pytest

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.kernels import kernel, replay
from irsim_gym.simulator.running import shards
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.running.shards import Shards
from irsim_gym.simulator.world.group import Shard

pytestmark = pytest.mark.skipif(not replay.is_possible(), reason="nothing is recorded where nothing is compiled")
N = 37


@kernel
def count_visits(worlds: Ints, slot: int, effort: int, seen: Ints, slots: Ints) -> None:
    """Count each world's visits, and those of each slot, after some work."""
    for i in range(worlds.shape[0]):
        total = 0
        for k in range(effort):
            total += (k ^ worlds[i]) % 7
        seen[worlds[i]] += 1 if total >= 0 else 0
        slots[slot, worlds[i]] += 1


@kernel
def fail_at(worlds: Ints, bad: int) -> None:
    """Fail if one of the worlds is the bad one."""
    for i in range(worlds.shape[0]):
        if worlds[i] == bad:
            raise ValueError("bad world")


class Visits:
    """Visits worlds by a recorded kernel."""

    def __init__(self, effort: int = 10, n_slots: int = 4) -> None:
        self.seen, self.slots = np.zeros(N, np.int64), np.zeros((n_slots, N), np.int64)
        self.effort = effort
        self.fused = Fused(self._visit)

    def _visit(self, shard: Shard) -> None:
        count_visits(shard.worlds, shard.slot, self.effort, self.seen, self.slots)


@pytest.mark.parametrize("num_threads", [2, 4])
def test_every_world_is_treated_once_in_each_of_many_jobs(num_threads: int) -> None:
    made, one, other, jobs = Shards(N, num_threads), Visits(), Visits(effort=300), 500
    some = np.array([3, 4, 20])
    for _ in range(jobs):
        made.run(one.fused)
        made.run(other.fused, some)
    assert one.seen.tolist() == [jobs] * N
    assert other.seen.tolist() == [jobs * int(w in some) for w in range(N)]
    assert (one.slots.sum(axis=0) == jobs).all()


def test_threads_take_part(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "HEAD_START_S", 0.01)
    made, visits = Shards(N, 4), Visits()
    for _ in range(5):
        made.run(visits.fused)
    assert visits.slots[1:].sum() > 0
    assert visits.seen.tolist() == [5] * N


def test_recorded_and_other_work_follow_each_other() -> None:
    made, visits, plain = Shards(N, 3), Visits(), np.zeros(N, np.int64)

    def work(shard: Shard) -> None:
        plain[shard.worlds] += 1

    for _ in range(300):
        made.run(visits.fused)
        made.run(work)
    assert visits.seen.tolist() == plain.tolist() == [300] * N


def test_a_failing_call_is_told_when_all_have_ended() -> None:
    made, visits = Shards(N, 3), Visits()
    bad = Fused(lambda shard: fail_at(shard.worlds, 5))
    made.run(visits.fused)
    with pytest.raises(RuntimeError, match="fail_at failed"):
        made.run(bad)
    made.run(visits.fused)
    assert visits.seen.tolist() == [2] * N


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs the timers of POSIX")
def test_an_interrupt_leaves_nothing_under_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes while the caller waits for the thread to begin."""
    made, visits = Shards(N, 2), Visits(effort=300_000)
    made.run(visits.fused)
    visits.seen[:] = 0
    monkeypatch.setattr(shards, "HEAD_START_S", 0.2)

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):  # noqa: PT012 - on a busy machine it comes at once
            signal.setitimer(signal.ITIMER_REAL, 0.002)
            made.run(visits.fused)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    seen = visits.seen.copy()
    time.sleep(0.02)
    assert visits.seen.tolist() == seen.tolist()
    assert seen.max() <= 1
    monkeypatch.setattr(shards, "HEAD_START_S", 0.0)
    quick = Visits()
    for _ in range(20):
        made.run(quick.fused)
    assert quick.seen.tolist() == [20] * N


def test_worlds_in_any_order_are_treated_once() -> None:
    made, visits, numbers = Shards(N, 3), Visits(), np.random.default_rng(0)
    for _ in range(200):
        made.run(visits.fused, numbers.permutation(N))
    assert visits.seen.tolist() == [200] * N
