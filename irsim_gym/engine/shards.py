"""Slices of worlds on threads: the only place where anything runs in parallel."""

from __future__ import annotations

import os
import threading
import time
import weakref
from collections.abc import Callable

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.world.group import Shard

Work = Callable[[Shard], None]

WORTH_S = 150e-6
"""A thread is worth while from this much work on [s]: waking it costs some 10 us, many times that on a busy machine."""
SETTLING_S = 1e-3
"""How often an interrupted run looks whether its threads have come to their ends [s]."""


class Shards:
    """Cuts worlds into shares and runs a function on each.

    Kernels release the GIL, so threads share the work. Into how many shares it is cut depends on how long it takes:
    the least time per world that the function has taken so far is kept. Results do not depend on the cut. The
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

    def cut(self, worlds: Ints, count: int) -> list[Shard]:
        """Return even shares of the given worlds, none of them empty."""
        bounds = [len(worlds) * k // count for k in range(count + 1)]
        return [Shard(worlds[bounds[k] : bounds[k + 1]], k) for k in range(count) if bounds[k] < bounds[k + 1]]

    def run(self, function: Work, worlds: Ints | None = None) -> None:
        """Call ``function`` for each share of the given worlds (all by default).

        An error is passed on when all shares have come to their end, that of the first share before others.
        """
        whole = self.all[0] if worlds is None else Shard(np.ascontiguousarray(worlds, np.int64))
        if self.n_slots > 1:
            self._run(function, whole.worlds)
        elif len(whole.worlds):
            function(whole)

    def _run(self, function: Work, worlds: Ints) -> None:
        """Cut the work, if it is worth that, and do it."""
        if not len(worlds):
            return
        name = getattr(function, "__qualname__", type(function).__qualname__)
        first, *others = self.cut(worlds, self._shares(name, len(worlds)))
        begin = time.perf_counter()
        lanes = self._threads(len(others)) if others else []
        try:
            for lane, shard in zip(lanes, others, strict=False):
                lane.give(function, shard)
            function(first)
            taken = time.perf_counter() - begin
            for lane in lanes[: len(others)]:
                lane.wait()
        except BaseException:
            _settle(lanes)
            raise
        finally:
            errors = [lane.take_error() for lane in lanes]
        for error in errors:
            if error is not None:
                raise error
        self._note(name, taken / len(first.worlds))

    def _shares(self, name: str, n_worlds: int) -> int:
        """Return into how many shares to cut: each is worth a thread."""
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
            self._lanes, self._owner = [], os.getpid()
        while len(self._lanes) < count:
            lane = _Lane()
            weakref.finalize(self, lane.dismiss).atexit = False
            self._lanes.append(lane)
        return self._lanes

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_lanes": [], "_owner": 0}


class _Lane:
    """A thread that sleeps until it is given a share."""

    def __init__(self) -> None:
        self.is_busy = False
        self._job: tuple[Work, Shard] | None = None
        self._error: BaseException | None = None
        self._given, self._done = threading.Lock(), threading.Lock()
        self._given.acquire()
        self._done.acquire()
        threading.Thread(target=self._serve, name="irsim_gym", daemon=True).start()

    def give(self, function: Work, shard: Shard) -> None:
        """Let the thread run the function; ``wait`` has to follow."""
        self._done.acquire(blocking=False)  # a wait that was interrupted has left it open
        self._job, self.is_busy = (function, shard), True
        self._given.release()

    def wait(self) -> None:
        """Return when the thread has run the function."""
        self._done.acquire()

    def take_error(self) -> BaseException | None:
        """Return what was raised, and forget it."""
        error, self._error = self._error, None
        return error

    def dismiss(self) -> None:
        """Let the thread come to its end; it sleeps."""
        self._given.release()

    def _serve(self) -> None:
        while True:
            self._given.acquire()
            if self._job is None:
                return
            (function, shard), self._job = self._job, None
            try:
                function(shard)
            except BaseException as error:
                self._error = error
            del function, shard  # else the simulation would live on here
            self.is_busy = False
            self._done.release()


def _settle(lanes: list[_Lane]) -> None:
    """Wait until no thread is at work, whatever else interrupts."""
    while any(lane.is_busy for lane in lanes):
        try:
            time.sleep(SETTLING_S)
        except KeyboardInterrupt:
            continue
