"""A recorded step, shared among threads that do not need Python for it.

The caller lays a job on a *desk*: whose calls, which worlds, how many pieces. Threads and caller take one piece after
another until none is left. Whoever goes through Python for a piece waits for the GIL, and one who sleeps is woken by
the operating system, which takes longer than many pieces do. So all this happens in kernels, and a thread that has
nothing to do looks at the desk for a moment before it goes to sleep, if jobs have been following each other.
"""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.atomics import add, load, relax, store, swap
from irsim_gym.engine.fused import Crew
from irsim_gym.jit import kernel
from irsim_gym.replay import BLOCK, call_all

LEFT, DONE = 0, 64
"""Places on the desk [byte], in cache lines of their own: pieces that nobody has taken; pieces that are done."""
FAILED, WORLDS, TOTAL, PIECES, CALLS, PATIENCE = (128 + 8 * k for k in range(6))
"""The call that failed, if any; where the worlds lie and how many they are; pieces; calls; looks before sleep."""
SLOTS, SLOT, SLEEPS = 192, 128, 64
"""Where the places of the slots begin, and how far they are apart: recorded calls; further on, whether it sleeps."""

LOOKS = 5000
"""How often a thread looks for a job before it sleeps; some 0.2 ms where a pause takes 140 cycles, as with Intel."""
WAITING = 20_000
"""How often the caller looks whether others are done before it lets go of the processor."""


class Desk:
    """Where the jobs of a few threads lie, one at a time.

    Args:
        n_slots: The caller, who is slot 0, and the threads.
    """

    def __init__(self, n_slots: int) -> None:
        self._words = np.zeros((SLOTS + SLOT * n_slots) // 8 + 8, np.int64)
        start: int = self._words.ctypes.data
        self._at = start + -start % 64
        self._failed = (self._at - start + FAILED) // 8
        self.serve(0)  # compiled here, not by the first thread: an interrupt should find that in the main one

    def offer(self, crew: Crew, worlds: Ints, pieces: int, looks: int) -> list[int]:
        """Lay down a job, and return the threads that sleep.

        Args:
            crew: What each slot does.
            worlds: For which worlds, shape ``(n,)``, contiguous; they are not looked at after the job is done.
            pieces: Into how many pieces they are cut.
            looks: How often threads look for the next job before they sleep.
        """
        asleep = lay_down(self._at, crew.addresses, worlds, min(pieces, len(worlds)), crew.n_calls, looks)
        return [slot for slot in range(1, crew.n_slots) if asleep >> slot & 1] if asleep else []

    def work(self) -> int:
        """Take pieces until none is left, and return how many worlds that were."""
        return int(take_pieces(self._at, 0, BLOCK))

    def wait(self) -> bool:
        """Wait a little for others, and return whether all is done."""
        return bool(await_others(self._at, WAITING))

    def serve(self, slot: int) -> None:
        """Do what is laid down, until nothing has come for a while; called by the thread of a slot."""
        serve(self._at, slot, BLOCK)

    def give_up(self) -> bool:
        """Take away what nobody has begun, wait a little for the rest, and return whether all is done."""
        take_away(self._at)
        return self.wait()

    @property
    def failed(self) -> int:
        """The number of the call that failed, from 1; 0 if none did."""
        return int(self._words[self._failed])


@kernel
def lay_down(desk: int, addresses: Ints, worlds: Ints, pieces: int, n_calls: int, looks: int) -> int:
    """Write a job on the desk, and return which slots sleep, as bits.

    The number of pieces that are left is written last: as soon as it is seen, all else is right.
    """
    store(desk + FAILED, 0)
    store(desk + WORLDS, worlds.ctypes.data)
    store(desk + TOTAL, worlds.shape[0])
    store(desk + PIECES, pieces)
    store(desk + CALLS, n_calls)
    store(desk + PATIENCE, looks)
    store(desk + DONE, 0)
    for s in range(addresses.shape[0]):
        store(desk + SLOTS + SLOT * s, addresses[s])
    store(desk + LEFT, pieces)
    asleep = 0
    for s in range(1, addresses.shape[0]):
        if swap(desk + SLOTS + SLOT * s + SLEEPS, 0) == 1:
            asleep |= 1 << s
    return asleep


@kernel
def take_pieces(desk: int, slot: int, block: int) -> int:
    """Take pieces until none is left, and return how many worlds that were.

    Pieces are counted down, so that one who comes late gets nothing: below 1 there is none, and the job that has a
    piece left is the one that is written on the desk until that piece is done.
    """
    n_done = 0
    while True:
        left = add(desk + LEFT, -1)
        if left <= 0:
            return n_done
        total, pieces = load(desk + TOTAL), load(desk + PIECES)
        k = pieces - left
        first, last = total * k // pieces, total * (k + 1) // pieces
        calls, worlds = load(desk + SLOTS + SLOT * slot), load(desk + WORLDS) + 8 * first
        failed = call_all(calls, load(desk + CALLS), worlds, last - first, block)
        if failed:
            store(desk + FAILED, failed)
        n_done += last - first
        add(desk + DONE, 1)


@kernel
def serve(desk: int, slot: int, block: int) -> None:
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
        take_pieces(desk, slot, block)


@kernel
def await_others(desk: int, patience: int) -> bool:
    """Look so many times whether all pieces are done, and return whether they are."""
    for _ in range(patience):
        if load(desk + DONE) >= load(desk + PIECES):
            return True
        relax()
    return False


@kernel
def take_away(desk: int) -> None:
    """Count the pieces that nobody has taken as done."""
    left = swap(desk + LEFT, 0)
    if left > 0:
        add(desk + DONE, left)
