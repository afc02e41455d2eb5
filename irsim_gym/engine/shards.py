"""Slices of worlds on threads: the only place where anything runs in parallel."""

from __future__ import annotations

import os
import threading
import time
import weakref

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.engine.crew import Desk, looks_in
from irsim_gym.engine.fused import Crew, Fused
from irsim_gym.engine.job import Job, Work, cut, insist
from irsim_gym.engine.pace import Pace
from irsim_gym.world.group import Shard

WORTH_S = 150e-6
"""A thread is worth while from this much work on [s]: waking it costs some 10 us, many times that on a busy machine."""
WORTH_AWAKE_S = 14e-6
"""The same for recorded work where threads are awake and look for it [s]."""
PIECE_S = 12e-6
"""How long a piece of recorded work should take at least [s]; the calls in it cost some 2 us."""
CLOSE_S, BRIEF_S = 3e-4, 5e-5
"""How long a thread looks for its next job before it sleeps [s]: where jobs follow each other so closely, or not."""
IN_A_ROW = 8
"""After so many jobs that follow each other closely threads are woken for little work, as they will stay awake."""
PIECES = 4
"""Pieces for each thread; who is free takes the next one, so that nobody waits for a thread that gets no processor."""
NAP_S = 5e-5
"""How long one sleeps who has looked long enough whether others are still at recorded work [s]."""
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
        self._paces: dict[str, Pace] = {}
        self._lanes: list[_Lane] = []
        self._owner = 0
        self._desk: Desk | None = None
        self._ended, self._in_a_row = 0.0, 0

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

    def is_alone(self, function: Fused, n_worlds: int) -> bool:
        """Return whether work stays with the caller this time, who may then do it without ``run``; asked once each."""
        if self.n_slots == 1:
            return True
        pace = self._paces.get(function.__qualname__)
        if pace is None or not pace.least_s:  # it has to be timed
            return False
        return pace.workers(n_worlds, self.n_slots, min(WORTH_AWAKE_S, WORTH_S)) == 1 or not pace.is_worth_a_try()

    def _run(self, function: Work, worlds: Ints) -> None:
        """Do the work together, if it is worth that."""
        n_worlds = len(worlds)
        if not n_worlds:
            return
        name = getattr(function, "__qualname__", type(function).__qualname__)
        pace = self._paces.get(name) or self._paces.setdefault(name, Pace())
        self._in_a_row = self._in_a_row + 1 if time.perf_counter() - self._ended < CLOSE_S else 0
        few = pace.workers(n_worlds, self.n_slots, min(WORTH_AWAKE_S, WORTH_S))
        if few == 1 or not pace.is_worth_a_try() or not self._run_together(pace, function, worlds, few):
            _run_alone(pace, function, worlds)
        self._ended = time.perf_counter()

    def _run_together(self, pace: Pace, function: Work, worlds: Ints, few: int) -> bool:
        """Do the work together if it is worth that; return whether it is done.

        Args:
            pace: What is known about the work.
            function: What to run.
            worlds: For which worlds.
            few: How many may take part if they are awake.
        """
        many = pace.workers(len(worlds), self.n_slots, WORTH_S)
        wanted = few if self._in_a_row >= IN_A_ROW else many
        if wanted < 2 and not self._lanes:
            return False
        crew = function.crew(self.n_slots) if isinstance(function, Fused) else None
        if crew is not None:
            return self._share_recorded(pace, crew, worlds, few, wanted)
        return many > 1 and self._share(pace, function, worlds, many)

    def _share(self, pace: Pace, function: Work, worlds: Ints, count: int) -> bool:
        """Do work that goes through Python together; return True."""
        job, lanes = Job(function, cut(worlds, count * PIECES)), self._threads(count - 1)[: count - 1]
        begin = time.perf_counter()
        try:
            for lane in lanes:
                lane.give(job)
            if lanes and HEAD_START_S:
                time.sleep(HEAD_START_S)
            start = time.perf_counter()
            n_done = job.work(0)
            taken = time.perf_counter() - start
            job.wait()
        except BaseException:
            job.cancel()
            raise
        finally:
            for lane in lanes:
                lane.forget()
        job.check()
        pace.note_shared(time.perf_counter() - begin, len(worlds))
        pace.note(taken, n_done)
        return True

    def _share_recorded(self, pace: Pace, crew: Crew, worlds: Ints, few: int, wanted: int) -> bool:
        """Do recorded work together, without Python, see ``crew``; return False where nobody is there for it.

        Args:
            pace: What is known about the work.
            crew: What each slot does.
            worlds: For which worlds.
            few: Among how many it is shared if they are awake.
            wanted: How many are worth being woken.
        """
        lanes, desk = self._threads(wanted - 1), self._ready_desk()
        least = int(PIECE_S / pace.least_s) if pace.least_s else 1
        looks = looks_in(CLOSE_S if self._in_a_row else BRIEF_S)
        begin = time.perf_counter()
        try:
            asleep = desk.offer(crew, worlds, few, wanted, least, looks)
            if asleep is None:
                return False
            for slot in asleep:
                lanes[slot - 1].attend(desk)
            if HEAD_START_S:
                time.sleep(HEAD_START_S)
            start = time.perf_counter()
            n_done = desk.work()
            taken = time.perf_counter() - start
            while not desk.wait():
                time.sleep(NAP_S)
        except BaseException:
            insist(desk.give_up)
            for lane in lanes:
                lane.attend(desk)  # whoever was to be woken: the desk takes it to be awake
            raise
        crew.check(desk.failed)
        pace.note_shared(time.perf_counter() - begin, len(worlds))
        pace.note(taken, n_done)
        return True

    def _ready_desk(self) -> Desk:
        if self._desk is None:
            self._desk = Desk(self.n_slots)
        return self._desk

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


def _run_alone(pace: Pace, function: Work, worlds: Ints) -> None:
    begin = time.perf_counter()
    function(Shard(worlds))
    pace.note(time.perf_counter() - begin, len(worlds))


class _Lane:
    """A thread that sleeps until it is given a job.

    Args:
        slot: Whose scratch memory it uses.
    """

    def __init__(self, slot: int) -> None:
        self.desk: Desk | None = None
        self._slot = slot
        self._job: Job | None = None
        self._is_dismissed = False
        self._given = threading.Lock()
        self._given.acquire()
        threading.Thread(target=self._serve, name="irsim_gym", daemon=True).start()

    def give(self, job: Job) -> None:
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
