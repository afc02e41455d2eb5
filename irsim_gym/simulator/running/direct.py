"""Steps all worlds with as little Python as possible."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.kernels.replay import BLOCK, call_all
from irsim_gym.simulator.running.fused import Fused
from irsim_gym.simulator.world.names import Floats, Ints, kernel

FLOATS = np.dtype(np.float32), np.dtype(np.float64)
REFUSED = -1


class Direct:
    """A function of all worlds that begins by reading numbers from outside, such as learners' actions.

    Where the function is recorded, one compiled call checks the numbers, copies them and makes all its calls.

    Args:
        function: What to run.
        worlds: All worlds, shape ``(n_worlds,)``.
        sizes: How many numbers of each agent are used, shape ``(n_agents,)``; the others are ignored.
        taken: Where the function reads the numbers, shape ``(n_worlds, n_agents, n)``.
    """

    def __init__(self, function: Fused, worlds: Ints, sizes: Ints, taken: Floats) -> None:
        self._function, self._worlds, self._sizes, self._taken = function, worlds, sizes, taken
        self._take_and_call: Any = take_and_call.compiled  # type: ignore[attr-defined]

    def run(self, actions: NDArray[Any]) -> bool:
        """Copy numbers, shape ``(n_worlds * n_agents * n,)``, and run the function.

        Returns:
            Whether it ran. It does not if the function is not recorded, or the numbers are not floating-point or not
            finite.
        """
        program = self._function.programs.get(0)
        if program is None or actions.dtype not in FLOATS:
            return False
        failed = self._take_and_call(program.entries, self._worlds, self._sizes, actions, self._taken)
        if failed > 0:
            program.check(failed)
        return not failed


@kernel
def take_and_call(entries: Ints, worlds: Ints, sizes: Ints, actions: Floats, taken: Floats) -> int:
    """Copy numbers to ``taken`` and make all calls for the worlds, unless a number is not finite.

    Args:
        entries: The calls, see ``replay.Program``.
        worlds: All worlds, ``(n_worlds,)``.
        sizes: How many numbers of each agent are used, ``(n_agents,)``.
        actions: The numbers, in a row.
        taken: Written, ``(n_worlds, n_agents, n)``.

    Returns:
        The number of the call that failed, from 1; 0 if none did; ``REFUSED`` for a number that is not finite.
    """
    # ``given`` is flat: all numbers of one agent, agent after agent, world after world.
    k = 0
    for w in range(taken.shape[0]):
        for a in range(taken.shape[1]):
            for c in range(taken.shape[2]):
                if c < sizes[a] and not np.isfinite(actions[k]):
                    return REFUSED
                taken[w, a, c] = actions[k]
                k += 1
    return call_all(entries.ctypes.data, entries.shape[0], worlds.ctypes.data, worlds.shape[0], BLOCK)
