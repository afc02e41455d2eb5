"""Replays a step that only calls kernels as one compiled call.

The plain path defines a step in Python: each phase calls its kernels. It runs once while ``kernels.record`` notes these
calls instead of making them. ``replay.Program`` then makes all of them at once, for any worlds. No code is written
twice, and results are equal bit for bit. A recorded function may call other such functions, which become part of it,
and may repeat one of them for the worlds in which it failed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from contextvars import ContextVar
from typing import Any

import numpy as np

from irsim_gym.base.contract import is_foreign, place_of
from irsim_gym.base.kernels import Calls, is_recording, kernel, record
from irsim_gym.base.kernels.replay import BLOCK, NotRecordableError, Packer, Program, call_all, is_possible
from irsim_gym.base.kernels.workers import Job, compile_together
from irsim_gym.simulator.running.promise import place_of_write
from irsim_gym.simulator.world.names import Ints, Shard

TRIALS = 20
"""Number of calls in which a function of kinds from outside the package is recorded again, and compared.

What first changes after them goes unnoticed. To compare results with those of the plain path would not find more: a
cost that is always the same compares equal, and all state would have to be copied.
"""
CURE = "steps take the plain path; write it as a kernel, or leave only_kernels out"

_lists_jobs: ContextVar[bool] = ContextVar("lists_jobs", default=False)


def only_kernels(kinds: Iterable[object]) -> bool:
    """Return whether the methods of all kinds only call kernels, with arrays that are never replaced.

    Kinds of the package do. Those from outside declare it with ``only_kernels = True`` in their own body: a class
    derived from another may do other things.
    """
    return all(vars(kind).get("only_kernels", not is_foreign(kind)) for kind in kinds)


class Recordings:
    """The functions of a simulation that are recorded.

    Attributes:
        all: The functions.
        kinds: The kinds from outside the package that promise ``only_kernels``. Those of the package are not checked.
        is_broken: Whether one of them was found to do more than calling kernels.
        is_checking: Whether arrays are read-only now, so that nothing may be packed for later.
    """

    def __init__(self) -> None:
        self.all: list[Fused] = []
        self.kinds: list[type[Any]] = []
        self.is_broken = self.is_checking = False
        self._is_compiled = False

    def add(self, function: Callable[[Shard], None], kinds: Sequence[Any], is_fusable: bool) -> Fused:
        """Return a function that calls some kinds as one that is recorded where it may be."""
        foreign = [kind for kind in kinds if is_fusable and is_foreign(kind)]
        self.kinds += [kind for kind in dict.fromkeys(foreign) if kind not in self.kinds]
        self.all.append(Fused(function, is_fusable, not foreign, self))
        return self.all[-1]

    def forget(self) -> None:
        """Discard everything that was recorded."""
        for function in self.all:
            function.forget()

    def break_off(self, why: str) -> None:
        """Note that the promise is broken, and warn once."""
        if not self.is_broken:
            self.is_broken = True
            kinds = ", ".join(f"{kind.__qualname__}{place_of(kind)}" for kind in self.kinds)
            warnings.warn(f"only_kernels is promised by {kinds}, but {why}; {CURE}", RuntimeWarning, stacklevel=2)
        self.forget()

    def compile_ahead(self) -> None:
        """Compile what all functions will call, in several processes; only once, because the rest is little."""
        if not self._is_compiled:
            self._is_compiled = True
            compile_together([job for function in self.all for job in function.jobs()])


class Fused:
    """A function of a shard that is recorded once for each slot and then replayed.

    If it cannot be recorded, it runs as plain Python.

    Args:
        function: The function. While it is recorded, its kernels are not executed.
        is_fusable: Whether it may be recorded.
        is_trusted: Whether all its kinds are of the package. Otherwise ``only_kernels`` is checked, and nothing is
            replayed while that lasts.
        recordings: The functions of the same simulation: where kernels are missing, those of all are compiled.

    Attributes:
        programs: What was recorded, by slot; None where it cannot be.
    """

    def __init__(
        self,
        function: Callable[[Shard], None],
        is_fusable: bool = True,
        is_trusted: bool = True,
        recordings: Recordings | None = None,
    ) -> None:
        self.function = function
        self.__qualname__ = getattr(function, "__qualname__", type(self).__qualname__)
        self.is_fusable = is_fusable and is_possible()
        self.programs: dict[int, Program | None] = {}
        self._is_trusted = is_trusted
        self._recordings = recordings or Recordings()
        self._on_trial: dict[int, Program] = {}
        self._trials = 0 if is_trusted else TRIALS
        self._left: dict[int, Ints] = {}

    def __call__(self, shard: Shard) -> None:
        """Run the function for the shard's worlds."""
        # While another function records, this one runs as Python, so that its kernels become part of the recording.
        program = None if is_recording() else self._program(shard.slot)
        if program is None:
            if shard.slot in self._on_trial and not is_recording():
                self._try_again(shard.slot)
            self.function(shard)
        else:
            program.run(shard.worlds)

    def repeat(self, shard: Shard, failed: Ints, tries: int) -> None:
        """Run the function, and again for those of the shard's worlds where it failed.

        Args:
            shard: The worlds.
            failed: Above 0 where the function failed, which writes it, shape ``(n_worlds,)``; some may stay so.
            tries: How often it is run at most.

        Raises:
            NotRecordableError: Another function that calls this one is being recorded, but this one cannot be.
        """
        if self._recordings.is_checking:
            self.function(shard)
            return
        if _lists_jobs.get():
            self.function(shard)
            call_until_done(shard.worlds, 0, 0, tries, failed, np.zeros(BLOCK, np.int64))
            return
        program = self._program(shard.slot)
        if program is not None:
            # Other programs hold this address, too; ``forget`` has to be called for all of them.
            left = self._left.setdefault(shard.slot, np.zeros(BLOCK, np.int64))
            call_until_done(shard.worlds, program.address, program.n_calls, tries, failed, left)
            return
        if is_recording():
            raise NotRecordableError(f"{self.__qualname__} is to be repeated, and cannot be recorded")
        remaining = shard
        for _ in range(tries):
            self(remaining)
            worlds = remaining.worlds[failed[remaining.worlds] > 0]
            if not len(worlds):
                break
            remaining = Shard(worlds, shard.slot)

    def _program(self, slot: int) -> Program | None:
        """Return what is replayed for a slot, recorded now if need be; None where the function runs as it is."""
        if slot not in self.programs:
            self.prepare(slot)
        if not self.is_fusable:
            return None
        # A program on trial is not replayed yet, but a recording that contains it needs its address.
        return self.programs.get(slot) or (self._on_trial.get(slot) if is_recording() else None)

    def prepare(self, slot: int) -> None:
        """Record the function for a slot, unless that was done before.

        Call this before threads get the function: recording compiles, and only the main thread receives interrupts.
        """
        if self.is_fusable and slot not in self.programs and slot not in self._on_trial:
            program = self._record(slot)
            # Kinds of the package are trusted at once; those from outside are on trial for some calls.
            programs: dict[int, Any] = self.programs if program is None or self._trials <= 0 else self._on_trial
            programs[slot] = program

    def forget(self) -> None:
        """Record again in the next call, because an array or a number was replaced."""
        self.programs.clear()
        self._on_trial.clear()

    def _record(self, slot: int) -> Program | None:
        """Return the program for a slot; None where recording twice does not give the same one.

        The first program holds the arrays made during its recording, so the second one has others.
        """
        recordings = self._recordings
        if self._trials > 0 and not recordings.is_broken:
            recordings.is_checking = True
            try:
                place = place_of_write(lambda: self._note(slot), getattr(self.function, "__self__", None))
            finally:
                recordings.is_checking = False
            if place:
                recordings.break_off(place)
        if recordings.is_broken and not self._is_trusted:
            return None
        try:
            first, second = (self._look(slot) for _ in range(2))
        except NotRecordableError as error:
            self._refuse(str(error))
            return None
        if first.equals(second):
            return first
        self._refuse("a kernel is called with an array that is made anew")
        return None

    def _refuse(self, why: str) -> None:
        if not self._is_trusted:
            self._recordings.break_off(why)

    def _try_again(self, slot: int) -> None:
        """Record the function once more, and compare; after enough equal recordings, its program is replayed."""
        self._trials -= 1
        if not self._on_trial[slot].equals(self._look(slot)):
            self._refuse("its kernels are called with other numbers or arrays from step to step")
        elif self._trials <= 0:
            self.programs.update(self._on_trial)
            self._on_trial.clear()

    def _note(self, slot: int) -> tuple[Calls, Ints]:
        worlds = np.zeros(1, np.int64)
        return record(self.function, Shard(worlds, slot)), worlds

    def _look(self, slot: int) -> Program:
        return Program(*self._note(slot), self._recordings.compile_ahead)

    def jobs(self) -> list[Job]:
        """Return what has to be compiled for the function; nothing while kinds from outside the package are checked."""
        if not self.is_fusable or not self._is_trusted:
            return []
        token = _lists_jobs.set(True)
        try:
            calls, worlds = self._note(0)
            packer = Packer(worlds)
            return [packer.job(*call) for call in calls]
        except Exception:  # raised again where the function is really recorded
            return []
        finally:
            _lists_jobs.reset(token)

    def __getstate__(self) -> dict[str, object]:
        # Recorded calls hold addresses, which mean nothing in another process.
        return {**self.__dict__, "programs": {}, "_on_trial": {}, "_left": {}}


@kernel
def call_until_done(worlds: Ints, calls: int, n_calls: int, tries: int, failed: Ints, left: Ints) -> None:
    """Make the calls for some worlds, and repeat them for those in which they failed.

    Args:
        worlds: The worlds to treat, shape ``(n,)``.
        calls: Where the calls stand; they write ``failed``.
        n_calls: How many they are.
        tries: How often they are made at most.
        failed: Above 0 where the calls failed, shape ``(n_worlds,)``.
        left: Scratch memory, for so many worlds at a time.
    """
    for first in range(0, worlds.shape[0], left.shape[0]):
        count = min(left.shape[0], worlds.shape[0] - first)
        for i in range(count):
            left[i] = worlds[first + i]
        for _ in range(tries):
            if call_all(calls, n_calls, left.ctypes.data, count, count):
                raise RuntimeError("a kernel failed")
            remaining = 0
            for i in range(count):
                # Worlds in which the calls failed move to the front of ``left``: they are the next try.
                if failed[left[i]] > 0:
                    left[remaining] = left[i]
                    remaining += 1
            count = remaining
            if count == 0:
                break
