"""Slices of worlds on threads: the only place where anything runs in parallel."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait

import numpy as np

from irsim_gym.arraytypes import Ints
from irsim_gym.world.group import Shard


class Shards:
    """Cuts worlds into shares and runs a function on each.

    Kernels release the GIL, so threads share the work. The pool is made when it is first needed; a forked
    child makes its own.

    Attributes:
        n_slots: Most shares that run at the same time.
        all: The shares of all worlds.
    """

    def __init__(self, n_worlds: int, num_threads: int) -> None:
        if num_threads < 1:
            raise ValueError(f"num_threads must be >= 1, got {num_threads}")
        self.n_slots = min(num_threads, n_worlds)
        self.all = self.cut(np.arange(n_worlds, dtype=np.int64))
        self._pool: ThreadPoolExecutor | None = None
        self._owner = 0

    def cut(self, worlds: Ints) -> list[Shard]:
        """Return even shares of the given worlds, none of them empty."""
        if self.n_slots == 1 or len(worlds) <= 1:
            return [Shard(worlds)] if len(worlds) else []
        pieces = np.array_split(worlds, min(self.n_slots, len(worlds)))
        return [Shard(piece, slot) for slot, piece in enumerate(pieces)]

    def run(self, function: Callable[[Shard], None], worlds: Ints | None = None) -> None:
        """Call ``function`` for each share of the given worlds (all by default).

        An error is passed on when all shares have come to their end.
        """
        shards = self.all if worlds is None else self.cut(worlds)
        if len(shards) == 1:
            function(shards[0])
            return
        running = [self._threads().submit(function, shard) for shard in shards]
        wait(running)
        for future in running:
            future.result()

    def _threads(self) -> ThreadPoolExecutor:
        if self._pool is None or self._owner != os.getpid():
            self._pool = ThreadPoolExecutor(self.n_slots, thread_name_prefix="irsim_gym")
            self._owner = os.getpid()
        return self._pool

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_pool": None, "_owner": 0}
