"""Divides worlds among threads. Nothing else runs in parallel."""

import os
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from itertools import pairwise

import numpy as np

from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.world.names import Ints, Shard

Work = Callable[[Shard], None]

WORTH_S = 150e-6
"""Least work for which a thread pays [s]. Waking it takes some 20 us, far longer on a busy machine."""
HEAD_START_S = 0.0
"""Time for which the caller waits for threads to begin before it works itself [s]; set by tests of threads."""


class Shards:
    """Divides worlds into shards, and runs a function on each.

    Kernels release the GIL, so threads share the work. The number of threads follows from the shortest time per world
    that the function has taken so far. Results do not depend on the division. Threads are created when they are first
    needed and sleep in between. A forked child creates its own.

    Attributes:
        n_slots: Maximum number of shards that run at the same time.
        all: A list with one shard of all worlds.
    """

    def __init__(self, n_worlds: int, num_threads: int) -> None:
        if num_threads < 1:
            raise ValueError(f"num_threads must be >= 1, got {num_threads}")
        self.n_slots = min(num_threads, n_worlds)
        self.all = [Shard(np.arange(n_worlds, dtype=np.int64))]
        # Least time per world of each function [s]; 0 after its first call, which compiles and does not count.
        self._least_s: dict[str, float] = {}
        self._threads: ThreadPoolExecutor | None = None
        self._owner = 0

    def run(self, function: Work, worlds: Ints | None = None) -> None:
        """Call ``function`` with shards of the given worlds (all by default).

        Errors are raised after all shards have ended; of several errors, that of the first shard.
        """
        # Recorded calls take the address of the worlds: they have to be contiguous.
        whole = self.all[0] if worlds is None else Shard(np.ascontiguousarray(worlds, np.int64))
        if not len(whole.worlds):
            return
        count = self._count(function, len(whole.worlds))
        if count == 1 and self.n_slots == 1:
            function(whole)
        else:
            self._share(function, [Shard(part, slot) for slot, part in enumerate(cut(whole.worlds, count))])

    def is_alone(self, function: Work, n_worlds: int) -> bool:
        """Return whether the caller may do this work on one thread, without ``run``."""
        is_timed = self._least_s.get(_name(function), 0.0) > 0.0
        return self.n_slots == 1 or (is_timed and self._count(function, n_worlds) == 1)

    def _count(self, function: Work, n_worlds: int) -> int:
        """Return the number of slots among which the work is divided: each gets at least ``WORTH_S`` of it."""
        most = min(self.n_slots, n_worlds)
        if WORTH_S <= 0.0:
            return most
        return max(1, min(most, int(self._least_s.get(_name(function), 0.0) * n_worlds / WORTH_S)))

    def _share(self, function: Work, parts: list[Shard]) -> None:
        """Run a function on all parts, the first in the caller.

        The caller takes over the parts that no thread has begun when it is done with its own.
        """
        if isinstance(function, Fused):
            for part in parts:  # recording compiles, and only the main thread receives interrupts
                function.prepare(part.slot)
        futures: list[Future[None]] = []
        try:
            futures += [self._ready_threads().submit(function, part) for part in parts[1:]]
            if futures and HEAD_START_S:
                time.sleep(HEAD_START_S)
            begin = time.perf_counter()
            errors = [_error_of(function, parts[0])]
            self._note(function, time.perf_counter() - begin, len(parts[0].worlds))
            for part, future in zip(parts[1:], futures, strict=True):
                # A future can be cancelled as long as no thread has begun it: then the caller does this part itself.
                errors.append(_error_of(function, part) if future.cancel() else future.exception())
        except BaseException:
            for future in futures:
                future.cancel()
            repeat_until(lambda: not wait(futures).not_done)
            raise
        for error in filter(None, errors):
            raise error

    def _note(self, function: Work, seconds: float, n_worlds: int) -> None:
        """Note how long some worlds took on one thread."""
        name, now = _name(function), seconds / n_worlds
        least = self._least_s.get(name)
        self._least_s[name] = 0.0 if least is None else min(least, now) if least else now

    def _ready_threads(self) -> ThreadPoolExecutor:
        # A job that threads find in shared memory, without Python, shares small batches better (the factors are in
        # benchmarks/choices.md), but takes some 500 lines more, without locks.
        if self._threads is None or self._owner != os.getpid():
            self._threads = ThreadPoolExecutor(self.n_slots - 1, thread_name_prefix="irsim_gym")
            self._owner = os.getpid()
        return self._threads

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_threads": None, "_owner": 0}


def cut(worlds: Ints, count: int) -> list[Ints]:
    """Return even parts of the given worlds, none of them empty."""
    bounds = [len(worlds) * k // count for k in range(count + 1)]
    return [worlds[a:b] for a, b in pairwise(bounds) if a < b]


def repeat_until(is_over: Callable[[], bool]) -> None:
    """Call a function until it returns True, also after interrupts."""
    while True:
        try:
            if is_over():
                return
        except KeyboardInterrupt:
            continue


def _name(function: Work) -> str:
    return getattr(function, "__qualname__", type(function).__qualname__)


def _error_of(function: Work, part: Shard) -> BaseException | None:
    try:
        function(part)
    except Exception as error:
        return error
    return None
