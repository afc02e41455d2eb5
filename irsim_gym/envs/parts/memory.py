"""The memory that worlds need, estimated from a few before all of it is taken."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path

from irsim_gym.base.errors import warn_caller
from irsim_gym.simulator.world.arrays import GB, total_memory

MANY = 10_000
"""Number of worlds from which on their memory is estimated."""
FEW = 2, 10
"""Numbers of worlds from whose memory that of a further one follows."""


def check_memory(make: Callable[[int], object], n_worlds: int) -> None:
    """Check that there is memory for many worlds; warn if they need more than half of what is free.

    Args:
        make: Makes a number of worlds.
        n_worlds: Number of worlds that are asked for.

    Raises:
        MemoryError: If there is too little.
    """
    free = free_memory()
    if n_worlds < MANY or free is None or tracemalloc.is_tracing():
        return
    kept = [make(1)]  # compiles and imports what all of them need
    sizes = []
    tracemalloc.start()
    try:
        for count in FEW:
            before = tracemalloc.get_traced_memory()[0]
            kept.append(make(count))
            sizes.append(tracemalloc.get_traced_memory()[0] - before)
    finally:
        tracemalloc.stop()
    each = (sizes[1] - sizes[0]) / (FEW[1] - FEW[0])
    told = (
        f"{n_worlds:,} worlds of this scenario need about {n_worlds * each / GB:,.1f} GB of memory "
        f"({each / 1e3:,.1f} kB each), {free / GB:,.1f} GB are free"
    )
    if n_worlds * each > free:
        raise MemoryError(f"{told}: take fewer worlds")
    if n_worlds * each > 0.5 * free:
        warn_caller(told)


def free_memory() -> float | None:
    """Return the memory that is free on this machine [byte]; None where the system does not tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024.0 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration, ValueError):
        return total_memory()
