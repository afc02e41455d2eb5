"""Slices of worlds on threads: the only place where anything runs in parallel."""

from __future__ import annotations

import os
import threading
import time
import weakref
from collections import deque
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine.crew import LOOKS, Desk
from irsim_gym.engine.fused import Crew, Fused
from irsim_gym.world.group import Shard

Work = Callable[[Shard], None]

WORTH_S = 150e-6
"""A thread is worth while from this much work on [s]: waking it costs some 10 us, many times that on a busy machine."""
CLOSE_S = 3e-4
"""A thread looks for its next job before it sleeps where the last two came closer to each other [s]."""
PIECES, PIECES_OF_RECORDED = 4, 8
"""Pieces for each thread; who is free takes the next one, so that nobody waits for a thread that gets no processor."""
NAP_S = 5e-5
"""How long one sleeps who has looked long enough whether others are still at recorded work [s]."""
LOOK_S = 1e-3
"""How often one who waits looks by itself whether others are still at work [s]."""
HEAD_START_S = 0.0
"""How long the caller lets the threads begin before it takes a piece itself [s]; for tests of what threads do."""


class Shards:
    """Cuts worlds into shares and runs a function on each.

    Kernels release the GIL, so threads share the work. How many work together depends on how long it takes: the
    least time per world that the function has taken so far is kept. Results do not depend on the cut. The
    threads are made when they are first needed, and sleep in between; a forked child makes its own.

    Attributes:
        n_slots: Most shares that run at the same time.
        all: The share of all worlds, alone in a list.
    """

    def __init__(self, n_worlds: int, num_threads: int) -> None:
        if num_threads < 1:
            raise ValueError(f"num_threads must be >= 1, got {num_threads}")
        self.n_slots = min(num_threads, n_worlds)
        self.all = [Shard(np.arange(n_worlds, dtype=np.int64))]
        self._seconds: dict[str, float] = {}
        self._lanes: list[_Lane] = []
        self._owner = 0
        self._desk: Desk | None = None
        self._ended = 0.0

    def run(self, function: Work, worlds: Ints | None = None) -> None:
        """Call ``function`` for shares of the given worlds (all by default).

        An error is passed on when all shares have come to their end, that of the first one before others.
        """
        # Recorded calls take the address of the worlds: they have to lie one after the other.
        whole = self.all[0] if worlds is None else Shard(np.ascontiguousarray(worlds, np.int64))
        if self.n_slots > 1:
            self._run(function, whole.worlds)
        elif len(whole.worlds):
            function(whole)

    def _run(self, function: Work, worlds: Ints) -> None:
        """Do the work together, if it is worth that."""
        if not len(worlds):
            return
        name = getattr(function, "__qualname__", type(function).__qualname__)
        count = self._workers(name, len(worlds))
        if count == 1:
            self._run_alone(name, function, worlds)
            return
        crew = function.crew(self.n_slots) if isinstance(function, Fused) else None
        if crew is not None:
            self._run_recorded(name, crew, worlds, count)
            return
        job = _Job(function, cut(worlds, count * PIECES))
        lanes = self._threads(count - 1)[: count - 1]
        try:
            for lane in lanes:
                lane.give(job)
            if lanes and HEAD_START_S:
                time.sleep(HEAD_START_S)
            begin = time.perf_counter()
            n_done = job.work(0)
            taken = time.perf_counter() - begin
            job.wait()
        except BaseException:
            job.cancel()
            raise
        finally:
            for lane in lanes:
                lane.forget()
        job.check()
        if n_done:
            self._note(name, taken / n_done)

    def _run_alone(self, name: str, function: Work, worlds: Ints) -> None:
        begin = time.perf_counter()
        function(Shard(worlds))
        self._note(name, (time.perf_counter() - begin) / len(worlds))

    def _run_recorded(self, name: str, crew: Crew, worlds: Ints, count: int) -> None:
        """Do recorded work together, without Python; see ``crew``."""
        lanes, desk = self._threads(count - 1), self._ready_desk()
        looks = LOOKS if time.perf_counter() - self._ended < CLOSE_S else 0
        try:
            asleep = desk.offer(crew, worlds, count * PIECES_OF_RECORDED, looks)
            for slot, lane in enumerate(lanes[: count - 1], start=1):
                if slot in asleep or lane.desk is not desk:
                    lane.attend(desk)
            if HEAD_START_S:
                time.sleep(HEAD_START_S)
            begin = time.perf_counter()
            n_done = desk.work()
            taken = time.perf_counter() - begin
            while not desk.wait():
                time.sleep(NAP_S)
        except BaseException:
            _insist(desk.give_up)
            for lane in lanes:
                lane.attend(desk)  # whoever was to be woken: the desk takes it to be awake
            raise
        crew.check(desk.failed)
        self._ended = time.perf_counter()
        if n_done:
            self._note(name, taken / n_done)

    def _ready_desk(self) -> Desk:
        if self._desk is None:
            self._desk = Desk(self.n_slots)
        return self._desk

    def _workers(self, name: str, n_worlds: int) -> int:
        """Return how many do the work: each share is worth a thread."""
        expected, count = self._seconds.get(name, 0.0) * n_worlds, min(self.n_slots, n_worlds)
        while count > 1 and expected < count * WORTH_S:
            count -= 1
        return count

    def _note(self, name: str, seconds: float) -> None:
        """Keep the least time per world; the first time is none, as functions are compiled in it."""
        known = self._seconds.get(name)
        self._seconds[name] = 0.0 if known is None else seconds if known == 0.0 else min(known, seconds)

    def _threads(self, count: int) -> list[_Lane]:
        if self._owner != os.getpid():
            self._lanes, self._desk, self._owner = [], None, os.getpid()
        while len(self._lanes) < count:
            lane = _Lane(len(self._lanes) + 1)
            weakref.finalize(self, lane.dismiss).atexit = False
            self._lanes.append(lane)
        return self._lanes

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_lanes": [], "_owner": 0, "_desk": None}


def cut(worlds: Ints, count: int) -> list[Ints]:
    """Return even pieces of the given worlds, none of them empty."""
    bounds = [len(worlds) * k // count for k in range(count + 1)]
    return [worlds[a:b] for a, b in pairwise(bounds) if a < b]


def _insist(is_over: Callable[[], bool]) -> None:
    """Return when something is over, however often this is interrupted."""
    while True:
        try:
            if is_over():
                return
        except KeyboardInterrupt:
            continue


class _Job:
    """A function and the pieces that are left; threads and the caller take one after another."""

    def __init__(self, function: Work, pieces: list[Ints]) -> None:
        self._function = function
        self._left = deque(enumerate(pieces))
        self._errors: list[tuple[int, BaseException]] = []
        self._at_work = 0
        self._lock = threading.Lock()
        self._done = threading.Lock()
        self._done.acquire()

    def work(self, slot: int) -> int:
        """Take pieces until none is left, and return how many worlds that were."""
        n_done = 0
        while self._left:
            try:
                number, worlds = self._left.popleft()
            except IndexError:  # another one was faster
                break
            try:
                self._function(Shard(worlds, slot))
            except BaseException as error:
                if slot == 0 and not isinstance(error, Exception):
                    raise  # an interrupt of the caller
                self._errors.append((number, error))
            n_done += len(worlds)
        return n_done

    def help(self, slot: int) -> None:
        """Do as ``work`` does, beside the caller, who waits for the end."""
        with self._lock:
            if not self._left:
                return
            self._at_work += 1
        try:
            self.work(slot)
        finally:
            with self._lock:
                self._at_work -= 1
                if self._done.locked():
                    self._done.release()

    def wait(self) -> None:
        """Return when nobody is at work; a condition of ``threading`` does not stand being interrupted."""
        while self._at_work:
            self._done.acquire(timeout=LOOK_S)

    def cancel(self) -> None:
        """Return when nobody is at work, however often this is interrupted; what nobody has taken is left undone."""
        self._left.clear()
        _insist(self._is_over)

    def _is_over(self) -> bool:
        self.wait()
        return True

    def check(self) -> None:
        """Raise the error of the first piece that failed."""
        if self._errors:
            raise min(self._errors, key=lambda one: one[0])[1]


class _Lane:
    """A thread that sleeps until it is given a job.

    Args:
        slot: Whose scratch memory it uses.
    """

    def __init__(self, slot: int) -> None:
        self.desk: Desk | None = None
        self._slot = slot
        self._job: _Job | None = None
        self._is_dismissed = False
        self._given = threading.Lock()
        self._given.acquire()
        threading.Thread(target=self._serve, name="irsim_gym", daemon=True).start()

    def give(self, job: _Job) -> None:
        """Let the thread help with a job, as soon as it gets a processor."""
        self._job = job
        self._wake()

    def attend(self, desk: Desk) -> None:
        """Let the thread do what lies on a desk, from now on; it sleeps, or does not know of the desk."""
        self.desk = desk
        self._wake()

    def forget(self) -> None:
        """Let go of a job that is done; a thread that has slept through it finds nothing."""
        self._job = None

    def dismiss(self) -> None:
        """Let the thread come to its end."""
        self._is_dismissed = True
        self._wake()

    def _wake(self) -> None:
        if self._given.locked():
            self._given.release()

    def _serve(self) -> None:
        while True:
            if self.desk is not None:
                self.desk.serve(self._slot)
            self._given.acquire()
            if self._is_dismissed:
                return
            job, self._job = self._job, None
            if job is not None:
                job.help(self._slot)
            del job  # else the simulation would live on here
