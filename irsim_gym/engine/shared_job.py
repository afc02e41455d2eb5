"""A recorded step that several threads share without the GIL.

The caller writes a job into memory: its calls, the worlds, the number of pieces. The threads and the caller take one
piece after another until none is left. A thread that fetched a piece through Python would wait for the GIL, and waking
one through the operating system takes longer than many pieces do. So all of this happens in kernels, and a thread
without work polls for the next job for a moment before it sleeps. While threads poll, even a few worlds are worth
sharing. Sleeping threads are woken only for larger jobs.

The processor that treated a world last holds its data in its cache. So each slot has worlds of its own, the same in
each step, and takes pieces of other slots when it has none left. Each piece has some overhead, and all wait for the
last one, so the first pieces of a slot are large and the last ones small.
"""

from __future__ import annotations

import time
from functools import cache
from typing import NamedTuple

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.atomics import add, load, relax, store, swap
from irsim_gym.engine.fused import Programs
from irsim_gym.jit import kernel
from irsim_gym.replay import BLOCK, call_all

LEFT, DONE = 0, 64
"""Offsets in the memory of a job [byte], in cache lines of their own: pieces that are left; pieces that are done."""
FAILED, WORLDS, BOUNDS, PIECES, CALLS, PATIENCE = (128 + 8 * k for k in range(6))
"""The call that failed, if any; addresses of the worlds and of the pieces' bounds; numbers of pieces, calls, looks."""
SLOTS, SLOT, LAST, SLEEPS, OWN = 192, 192, 8, 64, 128
"""Offset and size of the slots' memory. Within a slot: address of its calls, its last piece; in cache lines of their
own, whether its thread sleeps, and how many of its pieces are left."""
MOST_PIECES = 16
"""Maximum number of pieces for each slot."""
NOBODY = -1
"""No thread is awake or wanted."""

WAITING_S = 1e-3
"""Time for which the caller polls whether all pieces are done before it yields the processor [s]."""


class SharedJob:
    """Memory that the caller and some threads share, for one job at a time.

    Args:
        n_slots: The caller, who is slot 0, and the threads.
    """

    def __init__(self, n_slots: int) -> None:
        self._n_slots = n_slots
        # In words of 8 bytes; 8 more, so that the job can begin at a cache line.
        self._words = np.zeros((SLOTS + SLOT * n_slots) // 8 + 8, np.int64)
        self._bounds = np.zeros(MOST_PIECES * n_slots + 1, np.int64)
        start: int = self._words.ctypes.data
        self._at = start + -start % 64
        self._failed = (self._at - start + FAILED) // 8
        self._waiting = looks_in(WAITING_S)
        self.serve(0)  # compiled here instead of in the first thread, so that the main thread receives interrupts
        # All slots count as asleep until their threads are woken for the first time.
        self._words[(self._at - start + SLOTS + SLEEPS) // 8 :: SLOT // 8] = 1

    def start(
        self, programs: Programs, worlds: Ints, sharers: int, wanted: int, least: int, looks: int
    ) -> list[int] | None:
        """Begin a job, and return the slots whose threads have to be woken; None if no other thread takes part.

        Args:
            programs: What each slot does.
            worlds: For which worlds, shape ``(n,)``, contiguous; not read after the job is done. Where they are in
                order each slot gets about the same ones in every job.
            sharers: How many slots have worlds of their own.
            wanted: Slots below this are woken where they sleep; the others take part if they are awake.
            least: Worlds that a piece should have at least.
            looks: How often threads look for the next job before they sleep.
        """
        share = Share(sharers, wanted, least)
        given = programs.addresses, worlds, self._bounds, share, programs.n_calls, looks
        asleep = write_job(self._at, *given)
        if asleep == NOBODY:
            return None
        # 0: every wanted thread is awake and finds the job by itself.
        return [slot for slot in range(1, wanted) if asleep >> slot & 1] if asleep else []

    def work(self) -> int:
        """Take pieces until none is left, and return how many worlds that were."""
        return int(take_pieces(self._at, 0, self._n_slots, BLOCK))

    def wait(self) -> bool:
        """Wait a little for other threads, and return whether all is done."""
        return bool(await_others(self._at, self._waiting))

    def serve(self, slot: int) -> None:
        """Take part in jobs until none has come for a while; called by the thread of a slot."""
        serve(self._at, slot, self._n_slots, BLOCK)

    def cancel(self) -> bool:
        """Remove the pieces that no slot has taken, wait a little for the others, and return whether all is done."""
        remove_pieces(self._at)
        return self.wait()

    @property
    def failed(self) -> int:
        """The number of the call that failed, from 1; 0 if none did."""
        return int(self._words[self._failed])


def looks_in(seconds: float) -> int:
    """Return how often a thread can poll a word in a given time."""
    return int(seconds / _look_s())


@cache
def _look_s() -> float:
    """Return the time to poll a word once [s]. The pause instruction takes 40 or 140 cycles."""
    word, found = np.zeros(1, np.int64), []
    for _ in range(4):
        begin = time.perf_counter()
        look(word.ctypes.data, 1000)
        found.append((time.perf_counter() - begin) / 1000)
    return max(1e-9, min(found))


@kernel
def portion(first: int, last: int, least: int, most: int, pieces: int, bounds: Ints) -> int:
    """Cut worlds into pieces, each half of what is left, and return the new number of pieces.

    Args:
        first: Index of the first world in the list.
        last: Index after the last one.
        least: Minimum number of worlds in a piece; the last one may have fewer.
        most: Maximum number of pieces.
        pieces: Number of existing pieces.
        bounds: Written: the end of each piece, ``bounds[k + 1]``.
    """
    count = 0
    while first < last:
        # Half of what is left, rounded up; all of it where the half, or the number of pieces, would be too small.
        size = (last - first + 1) // 2
        if size < least or count == most - 1:
            size = last - first
        first += size
        count += 1
        bounds[pieces + count] = first
    return pieces + count


class Share(NamedTuple):
    """How a job is shared.

    Attributes:
        sharers: Number of slots among which the worlds are divided.
        wanted: Number of slots that should work.
        least: Minimum number of worlds in a piece.
    """

    sharers: int
    wanted: int
    least: int


@kernel
def write_job(job: int, addresses: Ints, worlds: Ints, bounds: Ints, share: Share, n_calls: int, looks: int) -> int:
    """Write a job, and return which of the wanted slots sleep, as bits. They count as awake from then on.

    The number of remaining pieces is written last: a thread that sees it sees everything else. If no slot is awake or
    wanted, nothing is written.
    """
    sharers, wanted, least = share
    # Nobody else takes part if no thread is to be woken and all of them sleep.
    is_alone = wanted < 2
    for s in range(1, addresses.shape[0]):
        is_alone = is_alone and load(job + SLOTS + SLOT * s + SLEEPS) == 1
    if is_alone:
        return NOBODY
    pieces, first = 0, 0
    bounds[0] = 0
    for s in range(addresses.shape[0]):
        # Slots beyond ``sharers`` get no worlds of their own, but take pieces of others.
        last, known = worlds.shape[0] * min(s + 1, sharers) // sharers, pieces
        pieces = portion(first, last, max(1, least), MOST_PIECES, pieces, bounds)
        first = last
        store(job + SLOTS + SLOT * s, addresses[s])
        store(job + SLOTS + SLOT * s + LAST, pieces)
        store(job + SLOTS + SLOT * s + OWN, pieces - known)
    store(job + FAILED, 0)
    store(job + WORLDS, worlds.ctypes.data)
    store(job + BOUNDS, bounds.ctypes.data)
    store(job + PIECES, pieces)
    store(job + CALLS, n_calls)
    store(job + PATIENCE, looks)
    store(job + DONE, 0)
    store(job + LEFT, pieces)
    asleep = 0
    for s in range(1, wanted):
        # The swap also tells a thread that is about to sleep that it has been woken, see ``serve``.
        if swap(job + SLOTS + SLOT * s + SLEEPS, 0) == 1:
            asleep |= 1 << s
    return asleep


@kernel
def take_pieces(job: int, slot: int, n_slots: int, block: int) -> int:
    """Take pieces until none is left, and return the number of treated worlds.

    Pieces are counted down, so a late thread gets none. A job stays in memory until its last piece is done.
    """
    n_done = 0
    # ``add`` returns the value before: a thread that reads a positive one has reserved a piece, whichever it will be.
    while add(job + LEFT, -1) > 0:
        # ``bounds[k]`` and ``bounds[k + 1]`` are the ends of piece k, as int64.
        bound = load(job + BOUNDS) + 8 * find_piece(job, slot, n_slots)
        first, last = load(bound), load(bound + 8)
        calls, worlds = load(job + SLOTS + SLOT * slot), load(job + WORLDS) + 8 * first
        failed = call_all(calls, load(job + CALLS), worlds, last - first, block)
        if failed:
            store(job + FAILED, failed)
        n_done += last - first
        add(job + DONE, 1)
    return n_done


@kernel
def find_piece(job: int, slot: int, n_slots: int) -> int:
    """Return the number of the next piece of a slot, or of the next slot that has any.

    Each caller has reserved one piece, and a slot that has none left gets no more, so one round is enough.
    """
    for k in range(n_slots):
        owner = job + SLOTS + SLOT * ((slot + k) % n_slots)
        if load(owner + OWN) > 0:
            # A slot's pieces end at ``LAST``: with ``left`` of them not taken, the next is that many before it. Another
            # thread may have taken the last one since the look above.
            left = add(owner + OWN, -1)
            if left > 0:
                return int(load(owner + LAST) - left)
    return 0


@kernel
def serve(job: int, slot: int, n_slots: int, block: int) -> None:
    """Take part in jobs until none has come for a while; then set the sleep flag, and look once more."""
    sleeps = job + SLOTS + SLOT * slot + SLEEPS
    store(sleeps, 0)
    while True:
        looks = 0
        while load(job + LEFT) <= 0:
            if looks >= load(job + PATIENCE):
                store(sleeps, 1)
                # A job may have been written between the last look and the flag. If its writer has cleared the flag, it
                # also wakes this thread anew, so this call ends; else the thread clears the flag itself and takes part.
                if load(job + LEFT) <= 0 or swap(sleeps, 0) == 0:
                    return
            looks += 1
            relax()
        take_pieces(job, slot, n_slots, block)


@kernel
def await_others(job: int, patience: int) -> bool:
    """Poll a number of times whether all pieces are done, and return whether they are."""
    for _ in range(patience):
        if load(job + DONE) >= load(job + PIECES):
            return True
        relax()
    return False


@kernel
def look(at: int, times: int) -> int:
    """Poll a word as a waiting thread does, and return its last value."""
    found = 0
    for _ in range(times):
        found = load(at)
        relax()
    return found


@kernel
def remove_pieces(job: int) -> None:
    """Count the pieces that no slot has taken as done."""
    # Threads that found no piece have counted below 0.
    left = swap(job + LEFT, 0)
    if left > 0:
        add(job + DONE, left)
