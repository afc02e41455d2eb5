"""Work that goes through Python, shared among threads: pieces that one after another of them takes."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from itertools import pairwise

from irsim_gym.arraytypes import Ints
from irsim_gym.world.group import Shard

Work = Callable[[Shard], None]

LOOK_S = 1e-3
"""How often one who waits looks by itself whether others are still at work [s]."""


def cut(worlds: Ints, count: int) -> list[Ints]:
    """Return even pieces of the given worlds, none of them empty."""
    bounds = [len(worlds) * k // count for k in range(count + 1)]
    return [worlds[a:b] for a, b in pairwise(bounds) if a < b]


def insist(is_over: Callable[[], bool]) -> None:
    """Return when something is over, however often this is interrupted."""
    while True:
        try:
            if is_over():
                return
        except KeyboardInterrupt:
            continue


class Job:
    """A function and the pieces that are left; threads and the caller take one after another.

    Args:
        function: What to run.
        pieces: The worlds of each piece.
    """

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
        insist(self._is_over)

    def _is_over(self) -> bool:
        self.wait()
        return True

    def check(self) -> None:
        """Raise the error of the first piece that failed."""
        if self._errors:
            raise min(self._errors, key=lambda one: one[0])[1]
