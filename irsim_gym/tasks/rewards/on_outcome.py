"""An amount paid once, when an episode ends in a certain way."""

from __future__ import annotations

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.jit import kernel


@kernel
def pay_outcome(worlds: Ints, column: int, wanted: int, amount: float, outcome: Ints, out: Floats) -> None:
    """Write ``amount`` where the outcome is the wanted one, else 0."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        for a in range(outcome.shape[1]):
            out[w, a, column] = amount if outcome[w, a] == wanted else 0.0
