"""A step as one compiled call, chosen where all that it does is to call kernels.

The plain path says what a step is, in Python: phase after phase calls its kernels. Here it is run once while
``jit.record`` notes these calls instead of making them; ``replay.Program`` then makes them all at once, for any
worlds. Nothing is written twice, and the results are the same to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from irsim_gym.jit import record
from irsim_gym.replay import NotRecordableError, Program, is_possible
from irsim_gym.world.group import Shard


def only_kernels(kinds: Iterable[Any]) -> bool:
    """Return whether all kinds say that their methods do nothing but call kernels, with arrays that stay.

    A kind says so by itself, with ``only_kernels = True`` in its own body: what is derived from it may do other things.
    """
    return all(vars(kind).get("only_kernels", False) for kind in kinds)


class Crew:
    """What each of several threads does with worlds: programs that differ in their scratch memory.

    Attributes:
        addresses: Where each slot's calls stand.
        n_calls: How many these are.
        n_slots: How many slots there are.
    """

    def __init__(self, programs: Sequence[Program]) -> None:
        self._programs = programs
        self.addresses = np.array([program.address for program in programs], np.int64)
        self.n_calls, self.n_slots = programs[0].n_calls, len(programs)

    def check(self, failed: int) -> None:
        """Raise an error if a call has failed; calls are counted from 1."""
        if failed:
            self._programs[0].check(failed)


class Fused:
    """A function of a shard that is recorded once for each slot, and replayed.

    Where it cannot be recorded it is run as it is.

    Args:
        function: What to run. While it is recorded its kernels do nothing.
        is_fusable: False to run it as it is in any case.
    """

    def __init__(self, function: Callable[[Shard], None], is_fusable: bool = True) -> None:
        self.function = function
        self.__qualname__ = getattr(function, "__qualname__", type(self).__qualname__)
        self.is_fusable = is_fusable and is_possible()
        self._programs: dict[int, Program | None] = {}
        self._crew: Crew | None = None

    def __call__(self, shard: Shard) -> None:
        """Run the function for the shard's worlds."""
        if shard.slot not in self._programs:
            self.prepare(shard.slot)
        program = self._programs.get(shard.slot) if self.is_fusable else None
        if program is None:
            self.function(shard)
        else:
            program.run(shard.worlds)

    def prepare(self, slot: int) -> None:
        """Record the function for a slot, unless that was done before.

        Whoever hands it to threads does so beforehand: recording compiles, and is best interrupted in the main thread.
        """
        if self.is_fusable and slot not in self._programs:
            self._programs[slot] = self._record(slot)

    def crew(self, n_slots: int) -> Crew | None:
        """Return the programs of all slots, recorded now if need be; None where it runs as it is."""
        if not self.is_fusable:
            return None
        if self._crew is None or self._crew.n_slots != n_slots:
            for slot in range(n_slots):
                self.prepare(slot)
            found = [self._programs.get(slot) for slot in range(n_slots)]
            programs = [program for program in found if program is not None]
            self._crew = Crew(programs) if len(programs) == n_slots else None
        return self._crew

    def forget(self) -> None:
        """Record anew the next time: an array or a number has been replaced by another one."""
        self._programs.clear()
        self._crew = None

    def _record(self, slot: int) -> Program | None:
        """Return the program for a slot; None where recording twice does not give the same one.

        An array made during the recording is held by the first program, so the second one has another.
        """
        try:
            first, second = (self._look(slot) for _ in range(2))
        except NotRecordableError:
            return None
        return first if first.equals(second) else None

    def _look(self, slot: int) -> Program:
        worlds = np.zeros(1, np.int64)
        return Program(record(self.function, Shard(worlds, slot)), worlds)

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, "_programs": {}, "_crew": None}
