"""Recorded work on threads: every world once, in each of many jobs that follow each other."""

from __future__ import annotations

import ctypes
import gc
import os
import pickle
import signal
import threading
import time
from types import FrameType
from typing import Any

import numpy as np
import pytest

from irsim_gym import replay
from irsim_gym.arraytypes import Ints
from irsim_gym.engine import shards, shared_job
from irsim_gym.engine.fused import Fused
from irsim_gym.engine.shards import Shards
from irsim_gym.engine.shared_job import SharedJob
from irsim_gym.jit import kernel
from irsim_gym.world.group import Shard

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
    made, one, other, jobs = Shards(N, num_threads), Visits(), Visits(effort=300), 3000
    some = np.array([3, 4, 20])
    for k in range(jobs):
        made.run(one.fused)
        made.run(other.fused, some)
        if k % 500 == 0:
            time.sleep(0.002)  # the threads go to sleep
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
    """It comes after the job was laid down, before the caller has begun."""
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


def test_threads_take_part_again_after_an_interrupt_before_they_were_woken(monkeypatch: pytest.MonkeyPatch) -> None:
    made, visits = Shards(N, 2), Visits()
    monkeypatch.setattr(shards, "HEAD_START_S", 0.05)  # the thread does the job, and sleeps again
    made.run(visits.fused)
    made.run(visits.fused)
    start, calls = SharedJob.start, list[int]()

    def interrupted(*arguments: Any) -> list[int]:
        calls.extend(start(*arguments))
        raise KeyboardInterrupt

    monkeypatch.setattr(SharedJob, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        made.run(visits.fused)
    monkeypatch.setattr(SharedJob, "start", start)
    assert calls == [1]  # it was to be woken
    visits.slots[:] = 0
    made.run(visits.fused)
    assert visits.slots[1].sum() > 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_child_has_a_job_of_its_own() -> None:
    made, visits = Shards(N, 3), Visits()
    made.run(visits.fused)
    child = os.fork()
    if child == 0:
        made.run(visits.fused)
        os._exit(0 if visits.seen.tolist() == [2] * N else 1)
    assert os.waitpid(child, 0)[1] == 0
    made.run(visits.fused)
    assert visits.seen.tolist() == [2] * N


def test_copies_have_jobs_of_their_own() -> None:
    made, visits = Shards(N, 3), Visits()
    made.run(visits.fused)
    twin = pickle.loads(pickle.dumps(made))
    twin.run(visits.fused)
    assert visits.seen.tolist() == [2] * N
    assert twin._job is not made._job


def test_threads_end_with_their_owner() -> None:
    before, made = set(threading.enumerate()), Shards(N, 3)
    made.run(Visits().fused)
    mine = [thread for thread in threading.enumerate() if thread not in before and thread.name.startswith("irsim_gym")]
    assert mine
    del made
    gc.collect()
    for thread in mine:
        thread.join(5.0)
    assert not any(thread.is_alive() for thread in mine)


def test_a_thread_looks_for_work_only_where_jobs_follow_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between steps of a learner that thinks for long, its processors are its own."""
    looks: list[int] = []
    made, visits, write_job = Shards(N, 2), Visits(), shared_job.write_job
    monkeypatch.setattr(shared_job, "write_job", lambda *given: (looks.append(given[-1]), write_job(*given))[1])
    monkeypatch.setattr(shards, "CLOSE_S", 0.1)
    for pause in (0.0, 0.0, 0.15, 0.0):
        time.sleep(pause)
        made.run(visits.fused)
    often, seldom = shared_job.looks_in(0.1), shared_job.looks_in(shards.BRIEF_S)
    assert looks == [seldom, often, seldom, often]
    assert often > 100 * seldom


@pytest.mark.parametrize(
    ("n", "least", "most", "bounds"),
    [(100, 8, 16, [0, 50, 75, 88, 100]), (100, 8, 2, [0, 50, 100]), (5, 8, 16, [0, 5]), (4, 1, 16, [0, 2, 3, 4])],
)
def test_pieces_get_smaller(n: int, least: int, most: int, bounds: list[int]) -> None:
    written = np.zeros(20, np.int64)
    assert shared_job.portion(0, n, least, most, 0, written) == len(bounds) - 1
    assert written[: len(bounds)].tolist() == bounds
    assert shared_job.portion(n, n, least, most, 3, written) == 3


def test_every_slot_begins_with_worlds_of_its_own() -> None:
    """Of eleven worlds three slots have three, four and four, in pieces of 2 and 1, or 2, 1 and 1."""
    visits, job = Visits(n_slots=3), SharedJob(3)
    programs = visits.fused.of_slots(3)
    assert programs is not None
    assert job.start(programs, np.arange(11), 3, 3, 1, 0) == [1, 2]
    assert [shared_job.find_piece(job._at, slot, 3) for slot in (2, 1, 1, 1, 1, 1, 1, 1)] == [5, 2, 3, 4, 6, 7, 0, 1]
    assert job._bounds[:9].tolist() == [0, 2, 3, 5, 6, 7, 9, 10, 11]


def wait_until_asleep(made: Shards, slot: int) -> None:
    """Wait for the thread of a slot to have looked often enough for the next job; a busy machine takes its time."""
    assert made._job is not None
    flag = ctypes.c_int64.from_address(made._job._at + shared_job.SLOTS + shared_job.SLOT * slot + shared_job.SLEEPS)
    for _ in range(6000):
        if flag.value == 1:
            return
        time.sleep(0.01)
    pytest.fail("the thread stays awake")


def test_little_work_is_shared_with_threads_that_are_awake(monkeypatch: pytest.MonkeyPatch) -> None:
    made, visits = Shards(N, 2), Visits()
    monkeypatch.setattr(shards, "HEAD_START_S", 0.02)
    monkeypatch.setattr(shards, "CLOSE_S", 0.2)
    monkeypatch.setattr(shards, "IN_A_ROW", 10**9)

    def by_the_thread(worth_s: float) -> bool:
        monkeypatch.setattr(shards, "WORTH_S", worth_s)
        monkeypatch.setattr(shards, "WORTH_AWAKE_S", 0.0)
        visits.slots[:] = 0
        made.run(visits.fused)
        return bool(visits.slots[1].any())

    assert [by_the_thread(worth_s) for worth_s in (10.0, 10.0, 0.0, 10.0)] == [False, False, True, True]
    wait_until_asleep(made, slot=1)
    assert [by_the_thread(10.0), by_the_thread(10.0)] == [False, False]
    monkeypatch.setattr(shards, "IN_A_ROW", 0)
    assert by_the_thread(10.0), "jobs follow each other: it will stay awake"
    assert visits.seen.tolist() == [7] * N


def test_worlds_in_any_order_are_treated_once() -> None:
    made, visits, numbers = Shards(N, 3), Visits(), np.random.default_rng(0)
    for _ in range(200):
        made.run(visits.fused, numbers.permutation(N))
    assert visits.seen.tolist() == [200] * N
