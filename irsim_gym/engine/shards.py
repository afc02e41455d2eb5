"""Divides worlds among threads. Nothing else runs in parallel."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from itertools import pairwise

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine.fused import Fused, Programs
from irsim_gym.engine.shared_job import SharedJob, looks_in
from irsim_gym.engine.timing import Timing
from irsim_gym.world.group import Shard

Work = Callable[[Shard], None]

WORTH_S = 150e-6
"""Least work for which waking a thread pays [s]. Waking takes about 10 us, far longer on a busy machine."""
WORTH_AWAKE_S = 14e-6
"""Least recorded work for which sharing with a thread that is awake pays [s]."""
PIECE_S = 12e-6
"""Minimum duration of a piece of recorded work [s]. Its calls cost about 2 us."""
CLOSE_S, BRIEF_S = 3e-4, 5e-5
"""Time for which a thread polls for its next job before it sleeps [s]: after closely following jobs, and otherwise."""
IN_A_ROW = 8
"""Number of closely following jobs after which threads are woken for little work, because they will stay awake."""
NAP_S = 5e-5
"""Polling interval of the caller while threads finish their pieces, after the first millisecond [s]."""
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
        self._timings: dict[str, Timing] = {}
        self._threads: ThreadPoolExecutor | None = None
        self._job: SharedJob | None = None
        self._owner = 0
        self._ended, self._in_a_row = 0.0, 0

    def run(self, function: Work, worlds: Ints | None = None) -> None:
        """Call ``function`` with shards of the given worlds (all by default).

        Errors are raised after all shards have ended; of several errors, that of the first shard.
        """
        # Recorded calls take the address of the worlds: they have to be contiguous.
        whole = self.all[0] if worlds is None else Shard(np.ascontiguousarray(worlds, np.int64))
        if self.n_slots > 1:
            self._run(function, whole.worlds)
        elif len(whole.worlds):
            function(whole)

    def is_alone(self, function: Fused, n_worlds: int) -> bool:
        """Return whether the caller may do this work on one thread, without ``run``. Call it once per piece of work."""
        if self.n_slots == 1:
            return True
        timing = self._timings.get(function.__qualname__)
        if timing is None or not timing.least_s:  # not timed yet: ``run`` does that
            return False
        return timing.workers(n_worlds, self.n_slots, min(WORTH_AWAKE_S, WORTH_S)) == 1 or not timing.is_worth_a_try()

    def _run(self, function: Work, worlds: Ints) -> None:
        """Share the work among threads if this pays."""
        n_worlds = len(worlds)
        if not n_worlds:
            return
        name = getattr(function, "__qualname__", type(function).__qualname__)
        timing = self._timings.get(name) or self._timings.setdefault(name, Timing())
        self._in_a_row = self._in_a_row + 1 if time.perf_counter() - self._ended < CLOSE_S else 0
        few = timing.workers(n_worlds, self.n_slots, min(WORTH_AWAKE_S, WORTH_S))
        if few == 1 or not timing.is_worth_a_try() or not self._run_together(timing, function, worlds, few):
            _run_alone(timing, function, worlds)
        self._ended = time.perf_counter()

    def _run_together(self, timing: Timing, function: Work, worlds: Ints, few: int) -> bool:
        """Share the work among threads if this pays; return whether it is done.

        Args:
            timing: Durations of this work.
            function: What to run.
            worlds: The worlds.
            few: Number of slots that take part if their threads are awake.
        """
        many = timing.workers(len(worlds), self.n_slots, WORTH_S)
        # ``few`` holds for threads that are awake, ``many`` is worth the time to wake them.
        wanted = few if self._in_a_row >= IN_A_ROW else many
        if wanted < 2 and self._threads is None:
            return False
        programs = function.of_slots(self.n_slots) if isinstance(function, Fused) else None
        if programs is not None:
            return self._share_recorded(timing, programs, worlds, few, wanted)
        return many > 1 and self._share(timing, function, worlds, many)

    def _share(self, timing: Timing, function: Work, worlds: Ints, count: int) -> bool:
        """Share work that goes through Python, a part for each slot; return True.

        The caller takes over the parts that no thread has begun when it is done with its own.
        """
        begin = time.perf_counter()
        threads, parts = self._ready_threads(), [Shard(part, slot) for slot, part in enumerate(cut(worlds, count))]
        futures: list[Future[None]] = []
        try:
            futures += [threads.submit(function, part) for part in parts[1:]]
            if HEAD_START_S:
                time.sleep(HEAD_START_S)
            start = time.perf_counter()
            errors = [_error_of(function, parts[0])]
            taken = time.perf_counter() - start
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
        timing.note_shared(time.perf_counter() - begin, len(worlds))
        timing.note(taken, len(parts[0].worlds))
        return True

    def _share_recorded(self, timing: Timing, programs: Programs, worlds: Ints, few: int, wanted: int) -> bool:
        """Share recorded work, without Python, see ``shared_job``; return False where no other thread takes part.

        Args:
            timing: How long the work takes.
            programs: What each slot does.
            worlds: For which worlds.
            few: Among how many slots it is shared if their threads are awake.
            wanted: How many threads are worth waking, and the caller.
        """
        threads = self._ready_threads()
        job = self._job = self._job or SharedJob(self.n_slots)
        # As many worlds as take PIECE_S on one thread.
        least = int(PIECE_S / timing.least_s) if timing.least_s else 1
        looks = looks_in(CLOSE_S if self._in_a_row else BRIEF_S)
        begin = time.perf_counter()
        try:
            asleep = job.start(programs, worlds, few, wanted, least, looks)
            if asleep is None:
                return False
            for slot in asleep:
                threads.submit(job.serve, slot)
            if HEAD_START_S:
                time.sleep(HEAD_START_S)
            start = time.perf_counter()
            n_done = job.work()
            taken = time.perf_counter() - start
            while not job.wait():
                time.sleep(NAP_S)
        except BaseException:
            # An error or an interrupt must not end the call while threads still use the job's memory.
            repeat_until(job.cancel)
            self._threads = self._job = None  # the job counts threads as awake even if they have not been woken
            raise
        programs.check(job.failed)
        timing.note_shared(time.perf_counter() - begin, len(worlds))
        timing.note(taken, n_done)
        return True

    def _ready_threads(self) -> ThreadPoolExecutor:
        if self._threads is None or self._owner != os.getpid():
            self._threads = ThreadPoolExecutor(self.n_slots - 1, thread_name_prefix="irsim_gym")
            self._job, self._owner = None, os.getpid()
        return self._threads

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_threads": None, "_owner": 0, "_job": None}


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


def _error_of(function: Work, part: Shard) -> BaseException | None:
    try:
        function(part)
    except Exception as error:
        return error
    return None


def _run_alone(timing: Timing, function: Work, worlds: Ints) -> None:
    begin = time.perf_counter()
    function(Shard(worlds))
    timing.note(time.perf_counter() - begin, len(worlds))
