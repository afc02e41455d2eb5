"""A recorded step, shared among threads that do not need Python for it.

The caller lays a job on a *desk*: whose calls, which worlds, how many pieces. Threads and caller take one piece after
another until none is left. Whoever goes through Python for a piece waits for the GIL, and one who sleeps is woken by
the operating system, which takes longer than many pieces do. So all this happens in kernels, and a thread that has
nothing to do looks at the desk for a moment before it goes to sleep. As long as it looks even a few worlds are worth
sharing; those who sleep are woken for larger jobs.

What a world needs lies in the cache of the processor that treated it last. So every thread has worlds of its own, the
same in each step, and helps others when it is through with them. Each block of worlds costs some overhead, and
everybody waits for who comes last: the first pieces of a thread's worlds are large and the last ones small.
"""

from __future__ import annotations

import time
from functools import cache

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.atomics import add, load, relax, store, swap
from irsim_gym.engine.fused import Crew
from irsim_gym.jit import kernel
from irsim_gym.replay import BLOCK, call_all

LEFT, DONE = 0, 64
"""Places on the desk [byte], in cache lines of their own: pieces that nobody has taken; pieces that are done."""
FAILED, WORLDS, BOUNDS, PIECES, CALLS, PATIENCE = (128 + 8 * k for k in range(6))
"""The call that failed, if any; where the worlds lie, and the bounds of the pieces; pieces; calls; looks."""
SLOTS, SLOT, LAST, SLEEPS, OWN = 192, 192, 8, 64, 128
"""Where the places of the slots begin, and how far they are apart: recorded calls, the last one of its pieces; further
on, in cache lines of their own, whether it sleeps, and how many of its pieces nobody has taken."""
MOST_PIECES = 16
"""Most pieces for each slot."""
NOBODY = -1
"""Nobody is there to share the job with."""

WAITING_S = 1e-3
"""How long the caller looks whether others are done before it lets go of the processor [s]."""


class Desk:
    """Where the jobs of a few threads lie, one at a time.

    Args:
        n_slots: The caller, who is slot 0, and the threads.
    """

    def __init__(self, n_slots: int) -> None:
        self._n_slots = n_slots
        self._words = np.zeros((SLOTS + SLOT * n_slots) // 8 + 8, np.int64)
        self._bounds = np.zeros(MOST_PIECES * n_slots + 1, np.int64)
        start: int = self._words.ctypes.data
        self._at = start + -start % 64
        self._failed = (self._at - start + FAILED) // 8
        self._waiting = looks_in(WAITING_S)
        self.serve(0)  # compiled here, not by the first thread: an interrupt should find that in the main one
        self._words[(self._at - start + SLOTS + SLEEPS) // 8 :: SLOT // 8] = 1

    def offer(self, crew: Crew, worlds: Ints, sharers: int, wanted: int, least: int, looks: int) -> list[int] | None:
        """Lay down a job, and return the threads that are to be woken; None if nobody is there to share it with.

        Args:
            crew: What each slot does.
            worlds: For which worlds, shape ``(n,)``, contiguous; they are not looked at after the job is done. Where
                they are in order each slot gets about the same ones in every job.
            sharers: How many slots have worlds of their own.
            wanted: Slots below this are woken where they sleep; the others take part if they are awake.
            least: Worlds that a piece should have at least.
            looks: How often threads look for the next job before they sleep.
        """
        given = crew.addresses, worlds, self._bounds, sharers, wanted, least, crew.n_calls, looks
        asleep = lay_down(self._at, *given)
        if asleep == NOBODY:
            return None
        return [slot for slot in range(1, wanted) if asleep >> slot & 1] if asleep else []

    def work(self) -> int:
        """Take pieces until none is left, and return how many worlds that were."""
        return int(take_pieces(self._at, 0, self._n_slots, BLOCK))

    def wait(self) -> bool:
        """Wait a little for others, and return whether all is done."""
        return bool(await_others(self._at, self._waiting))

    def serve(self, slot: int) -> None:
        """Do what is laid down, until nothing has come for a while; called by the thread of a slot."""
        serve(self._at, slot, self._n_slots, BLOCK)

    def give_up(self) -> bool:
        """Take away what nobody has begun, wait a little for the rest, and return whether all is done."""
        take_away(self._at)
        return self.wait()

    @property
    def failed(self) -> int:
        """The number of the call that failed, from 1; 0 if none did."""
        return int(self._words[self._failed])


def looks_in(seconds: float) -> int:
    """Return how often one looks at a desk in some time."""
    return int(seconds / _look_s())


@cache
def _look_s() -> float:
    """Return how long it takes to look at a word [s]: the pause in between is some 40 cycles, or 140."""
    word, found = np.zeros(1, np.int64), []
    for _ in range(4):
        begin = time.perf_counter()
        look(word.ctypes.data, 1000)
        found.append((time.perf_counter() - begin) / 1000)
    return max(1e-9, min(found))


@kernel
def portion(first: int, last: int, least: int, most: int, pieces: int, bounds: Ints) -> int:
    """Cut worlds into pieces, each half of what is left, and return how many pieces there are now.

    Args:
        first: Where the worlds begin, among those that are listed.
        last: Where they end.
        least: How many a piece should have at least; the last one may have fewer.
        most: Most pieces.
        pieces: How many pieces there are already.
        bounds: Written: where each piece ends, ``bounds[k + 1]``.
    """
    count = 0
    while first < last:
        size = (last - first + 1) // 2
        if size < least or count == most - 1:
            size = last - first
        first += size
        count += 1
        bounds[pieces + count] = first
    return pieces + count


@kernel
def lay_down(
    desk: int,
    addresses: Ints,
    worlds: Ints,
    bounds: Ints,
    sharers: int,
    wanted: int,
    least: int,
    n_calls: int,
    looks: int,
) -> int:
    """Write a job on the desk, and return which of the wanted slots sleep, as bits; they are taken to be awake then.

    The number of pieces that are left is written last: as soon as it is seen, all else is right. Where no slot is
    awake or wanted, nothing is written.
    """
    is_alone = wanted < 2
    for s in range(1, addresses.shape[0]):
        is_alone = is_alone and load(desk + SLOTS + SLOT * s + SLEEPS) == 1
    if is_alone:
        return NOBODY
    pieces, first = 0, 0
    bounds[0] = 0
    for s in range(addresses.shape[0]):
        last, known = worlds.shape[0] * min(s + 1, sharers) // sharers, pieces
        pieces = portion(first, last, max(1, least), MOST_PIECES, pieces, bounds)
        first = last
        store(desk + SLOTS + SLOT * s, addresses[s])
        store(desk + SLOTS + SLOT * s + LAST, pieces)
        store(desk + SLOTS + SLOT * s + OWN, pieces - known)
    store(desk + FAILED, 0)
    store(desk + WORLDS, worlds.ctypes.data)
    store(desk + BOUNDS, bounds.ctypes.data)
    store(desk + PIECES, pieces)
    store(desk + CALLS, n_calls)
    store(desk + PATIENCE, looks)
    store(desk + DONE, 0)
    store(desk + LEFT, pieces)
    asleep = 0
    for s in range(1, wanted):
        if swap(desk + SLOTS + SLOT * s + SLEEPS, 0) == 1:
            asleep |= 1 << s
    return asleep


@kernel
def take_pieces(desk: int, slot: int, n_slots: int, block: int) -> int:
    """Take pieces until none is left, and return how many worlds that were.

    Pieces are counted down, so that one who comes late gets nothing: below 1 there is none, and the job that has a
    piece left is the one that is written on the desk until that piece is done.
    """
    n_done = 0
    while add(desk + LEFT, -1) > 0:
        bound = load(desk + BOUNDS) + 8 * find_piece(desk, slot, n_slots)
        first, last = load(bound), load(bound + 8)
        calls, worlds = load(desk + SLOTS + SLOT * slot), load(desk + WORLDS) + 8 * first
        failed = call_all(calls, load(desk + CALLS), worlds, last - first, block)
        if failed:
            store(desk + FAILED, failed)
        n_done += last - first
        add(desk + DONE, 1)
    return n_done


@kernel
def find_piece(desk: int, slot: int, n_slots: int) -> int:
    """Return the number of the next piece of a slot, or of the next slot that has any.

    One is left for everybody who comes here, and a slot that has none left gets no more: one round is enough.
    """
    for k in range(n_slots):
        owner = desk + SLOTS + SLOT * ((slot + k) % n_slots)
        if load(owner + OWN) > 0:
            left = add(owner + OWN, -1)
            if left > 0:
                return int(load(owner + LAST) - left)
    return 0


@kernel
def serve(desk: int, slot: int, n_slots: int, block: int) -> None:
    """Do jobs until none has come for a while; then say so, and look once more."""
    sleeps = desk + SLOTS + SLOT * slot + SLEEPS
    store(sleeps, 0)
    while True:
        looks = 0
        while load(desk + LEFT) <= 0:
            if looks >= load(desk + PATIENCE):
                store(sleeps, 1)
                if load(desk + LEFT) <= 0 or swap(sleeps, 0) == 0:
                    return
            looks += 1
            relax()
        take_pieces(desk, slot, n_slots, block)


@kernel
def await_others(desk: int, patience: int) -> bool:
    """Look so many times whether all pieces are done, and return whether they are."""
    for _ in range(patience):
        if load(desk + DONE) >= load(desk + PIECES):
            return True
        relax()
    return False


@kernel
def look(at: int, times: int) -> int:
    """Look at a word as one who waits does, and return what stood there last."""
    found = 0
    for _ in range(times):
        found = load(at)
        relax()
    return found


@kernel
def take_away(desk: int) -> None:
    """Count the pieces that nobody has taken as done."""
    left = swap(desk + LEFT, 0)
    if left > 0:
        add(desk + DONE, left)
