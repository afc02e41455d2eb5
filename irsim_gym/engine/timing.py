"""Measures how long a function of worlds takes, and decides whether threads make it faster."""

from __future__ import annotations

JUDGED = 8
"""Number of successive shared jobs whose total time is compared with that of one thread."""
FIRST_S = 1e-5
"""Overhead of a job on one thread until its kernels are in the cache [s]."""
REST, MOST_REST = 32, 512
"""Number of jobs that stay on one thread after sharing did not pay: first value, doubled each time, and maximum."""


class Timing:
    """Measured durations of one function of worlds.

    Whether sharing pays cannot be known beforehand. If other programs keep the processors busy, a thread that has taken
    a piece may lose its processor for milliseconds, and the whole job waits. So sharing is tried from time to time.

    Attributes:
        least_s: Least time per world on one thread so far [s]; 0 while nothing is known.
    """

    def __init__(self) -> None:
        self.least_s = 0.0
        self._is_compiled = False
        self._rest, self._next_rest = 0, REST
        self._taken_s, self._alone_s, self._jobs = 0.0, 0.0, 0

    def note(self, seconds: float, n_worlds: int) -> None:
        """Note the duration of some worlds on one thread. The first call, which compiles, does not count."""
        if not n_worlds:
            return
        if self._is_compiled:
            known, now = self.least_s, seconds / n_worlds
            self.least_s = min(known, now) if known else now
        self._is_compiled = True

    def note_shared(self, seconds: float, n_worlds: int) -> None:
        """Note the duration of a shared job."""
        self._taken_s += seconds
        # What the job would have taken on one thread.
        self._alone_s += self.least_s * n_worlds + FIRST_S
        self._jobs += 1
        if self._jobs < JUDGED or not self.least_s:
            return
        # Sharing did not pay: rest, and longer each time that this happens in a row.
        if self._taken_s > self._alone_s:
            self._rest, self._next_rest = self._next_rest, min(2 * self._next_rest, MOST_REST)
        else:
            self._next_rest = REST
        self._taken_s, self._alone_s, self._jobs = 0.0, 0.0, 0

    def workers(self, n_worlds: int, most: int, worth_s: float) -> int:
        """Return the number of threads that may share the work, at most ``most``.

        Each gets at least ``worth_s`` [s] of it.
        """
        most = min(most, n_worlds)
        if worth_s <= 0.0:
            return most
        return max(1, min(most, int(self.least_s * n_worlds / worth_s)))

    def is_worth_a_try(self) -> bool:
        """Return whether the next job may be shared. Call it once per job, because it counts jobs that may not."""
        if self._rest:
            self._rest -= 1
            return False
        return True
