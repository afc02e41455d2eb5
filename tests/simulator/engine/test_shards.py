"""Shares of worlds on threads: who does what, errors, interrupts, forks, the end of the threads."""

from __future__ import annotations

import gc
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from types import FrameType
from typing import Any

import numpy as np
import pytest

from irsim_gym.simulator.running import shards
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.running.shards import Shards
from irsim_gym.simulator.world.group import Shard

N = 7


class Visits:
    """Counts how often each world is treated, and by which threads."""

    def __init__(self, pause: float = 0.0) -> None:
        self.pause = pause
        self.seen = np.zeros(N, np.int64)
        self.slots: set[int] = set()
        self.threads: set[int] = set()

    def __call__(self, shard: Shard) -> None:
        time.sleep(self.pause * len(shard.worlds))
        self.seen[shard.worlds] += 1
        self.slots.add(shard.slot)
        self.threads.add(threading.get_ident())


@pytest.mark.parametrize("num_threads", [1, 2, 3, 7, 20])
def test_every_world_is_treated_once(num_threads: int) -> None:
    made, visits = Shards(N, num_threads), Visits()
    for _ in range(50):
        made.run(visits)
    made.run(visits, np.array([1, 4]))
    made.run(visits, np.array([], np.int64))
    assert visits.seen.tolist() == [50, 51, 50, 50, 51, 50, 50]
    assert visits.slots <= set(range(min(num_threads, N)))
    assert len(visits.threads) > 1 or num_threads == 1


def test_little_work_stays_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "WORTH_S", 1.0)
    made, visits = Shards(N, 3), Visits()
    for _ in range(20):
        made.run(visits)
    assert visits.threads == {threading.get_ident()}
    assert made._threads is None


@pytest.mark.parametrize(("worth", "workers"), [(0.004, 3), (0.01, 2), (0.02, 1)])
def test_the_least_time_so_far_says_how_many_work(worth: float, workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "WORTH_S", worth)
    made = Shards(N, 3)
    made._least_s["Work"] = 0.003  # 0.021 s for all worlds
    work = type("Work", (Visits,), {})()
    made.run(work)
    assert work.slots <= set(range(workers))
    assert (made._threads is None) == (workers == 1)


def test_the_caller_is_told_what_stays_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not timed yet has to be run; 7 us for all worlds are too little for a thread, 0.7 ms are not."""
    made, work = Shards(N, 3), Fused(lambda shard: None)
    assert Shards(N, 1).is_alone(work, N)
    monkeypatch.setattr(shards, "WORTH_S", 1e-4)
    assert not made.is_alone(work, N)
    alone = []
    for least_s in (0.0, 1e-6, 1e-4):
        made._least_s[work.__qualname__] = least_s
        alone.append(made.is_alone(work, N))
    assert alone == [False, True, False]


def test_the_first_time_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shards, "WORTH_S", 1e-3)
    made, visits, numbers = Shards(N, 2), Visits(0.001), []
    for _ in range(3):
        made.run(visits)
        numbers.append(made._threads is None)
    assert numbers == [True, True, False]


def test_nobody_waits_for_a_thread_that_gets_no_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    """The caller does everything where the thread does not come."""
    made, visits = Shards(N, 2), Visits()
    made.run(visits)
    monkeypatch.setattr(made._threads, "submit", lambda *work: Future())
    visits.threads.clear()
    made.run(visits)
    assert visits.threads == {threading.get_ident()}
    assert visits.slots == {0, 1}
    assert visits.seen.tolist() == [2] * N


@pytest.mark.parametrize("failing", [0, 3])
def test_errors_are_passed_on_when_all_have_ended(failing: int) -> None:
    """Of seven worlds three slots have two, two and three."""
    made, visits = Shards(N, 3), Visits(0.002)

    def work(shard: Shard) -> None:
        if failing in shard.worlds or 6 in shard.worlds:
            raise ZeroDivisionError(f"slot {shard.slot}")
        visits(shard)

    made.run(visits)
    with pytest.raises(ZeroDivisionError, match=f"slot {failing // 2}"):
        made.run(work)
    others = [0, 1] if failing == 3 else [2, 3]
    assert visits.seen.tolist() == [1 + (w in others) for w in range(N)]
    made.run(visits)
    assert visits.seen.max() == 3


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs the timers of POSIX")
@pytest.mark.parametrize("waits", [False, True])
def test_an_interrupt_leaves_no_share_under_way(waits: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes while the caller works, or while it waits for the thread."""
    monkeypatch.setattr(shards, "HEAD_START_S", 0.1)
    made, ended = Shards(2, 2), []

    def work(shard: Shard) -> None:
        time.sleep(0.0 if waits and shard.slot == 0 else 0.4)
        ended.append(shard.slot)

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):  # noqa: PT012 - on a busy machine it comes at once
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            made.run(work)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert ended == ([0, 1] if waits else [1])
    monkeypatch.setattr(shards, "HEAD_START_S", 0.0)
    visits = Visits()
    for _ in range(20):
        made.run(visits)
    assert visits.seen[:2].tolist() == [20, 20]


def test_threads_end_with_their_owner() -> None:
    before = set(threading.enumerate())
    made = Shards(N, 3)
    made.run(Visits())
    mine = [thread for thread in threading.enumerate() if thread not in before and thread.name.startswith("irsim_gym")]
    assert mine
    del made
    gc.collect()
    for thread in mine:
        thread.join(5.0)
    assert not any(thread.is_alive() for thread in mine)


def test_threads_forget_what_they_did() -> None:
    made = Shards(N, 3)

    class Work:
        def __call__(self, shard: Shard) -> None:
            pass

    work = Work()
    made.run(work)
    made.run(lambda shard: None)
    assert len(gc.get_referrers(work)) <= 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_child_makes_its_own_threads() -> None:
    made, visits = Shards(N, 3), Visits()
    made.run(visits)
    child = os.fork()
    if child == 0:
        made.run(visits)
        os._exit(0 if visits.seen.tolist() == [2] * N else 1)
    assert os.waitpid(child, 0)[1] == 0
    made.run(visits)
    assert visits.seen.tolist() == [2] * N


def test_copies_have_no_threads() -> None:
    made = Shards(N, 3)
    made.run(Visits())
    twin: Any = pickle.loads(pickle.dumps(made))
    assert twin._threads is None
    visits = Visits()
    twin.run(visits)
    assert visits.seen.tolist() == [1] * N


@pytest.mark.parametrize("last", ["pass", "raise SystemExit(0)"])
def test_sleeping_threads_do_not_keep_the_process(last: str) -> None:
    program = f"""
from irsim_gym.simulator.running import shards
shards.WORTH_S = 0.0
made = shards.Shards(4, 3)
made.run(lambda shard: None)
assert made._threads is not None
{last}
"""
    assert subprocess.run([sys.executable, "-c", program], timeout=60, check=False).returncode == 0
