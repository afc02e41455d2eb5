"""One world, stepped with as little Python as possible."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.engine.fused import Fused
from irsim_gym.jit import kernel
from irsim_gym.replay import call_all

FLOATS = np.dtype(np.float32), np.dtype(np.float64)
REFUSED = -1


class Alone:
    """A function of the only world that begins by reading numbers from outside, such as a learner's action.

    Where the function is recorded, one compiled call looks at the numbers, takes them over and does all the rest.

    Args:
        function: What to run.
        worlds: The one world, shape ``(1,)``.
        taken: Where the function reads the numbers, shape ``(1, 1, n)``.
    """

    def __init__(self, function: Fused, worlds: Ints, taken: Floats) -> None:
        self._function, self._worlds, self._taken = function, worlds, taken
        self._take_and_call: Any = take_and_call.compiled  # type: ignore[attr-defined]

    def run(self, given: NDArray[Any]) -> bool:
        """Take over numbers, shape ``(n,)``, and run the function.

        Returns:
            Whether that was done. Else nothing has happened: the function is not recorded, or the numbers are not
            floating-point, or not finite.
        """
        program = self._function.programs.get(0)
        if program is None or given.dtype not in FLOATS:
            return False
        failed = self._take_and_call(program.entries, self._worlds, given, self._taken)
        if failed > 0:
            program.check(failed)
        return not failed


@kernel
def take_and_call(entries: Ints, worlds: Ints, given: Floats, taken: Floats) -> int:
    """Copy numbers ``(n,)`` to ``taken`` ``(1, 1, n)`` and make all calls for the one world, unless one is not finite.

    Returns:
        The number of the call that failed, from 1; 0 if none did; ``REFUSED`` for a number that is not finite.
    """
    for c in range(given.shape[0]):
        if not np.isfinite(given[c]):
            return REFUSED
    for c in range(given.shape[0]):
        taken[0, 0, c] = given[c]
    return call_all(entries.ctypes.data, entries.shape[0], worlds.ctypes.data, 1, 1)
