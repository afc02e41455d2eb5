"""How long a piece of work takes, and whether threads make it faster: learnt from how long it took so far."""

from __future__ import annotations

SPELL = 8
"""So many shared jobs in a row are judged together."""
FIRST_S = 1e-5
"""What a job takes on one thread in addition [s]: kernels have to come into the cache first."""
REST, MOST_REST = 32, 512
"""So many jobs stay on one thread where sharing did not pay; each time that it does not pay again, twice as many."""


class Pace:
    """What is known about one function of worlds.

    Whether sharing pays cannot be told beforehand: where other programs keep the processors busy, a thread that has
    taken a piece may be made to wait for milliseconds, and everybody waits for it. So it is tried now and then.

    Attributes:
        least_s: Least time per world on one thread so far [s]; 0 while nothing is known.
    """

    def __init__(self) -> None:
        self.least_s = 0.0
        self._is_compiled = False
        self._rest, self._next_rest = 0, REST
        self._taken_s, self._alone_s, self._jobs = 0.0, 0.0, 0

    def note(self, seconds: float, n_worlds: int) -> None:
        """Learn how long one thread took for some worlds; the first time does not count, functions are compiled."""
        if not n_worlds:
            return
        if self._is_compiled:
            known, now = self.least_s, seconds / n_worlds
            self.least_s = min(known, now) if known else now
        self._is_compiled = True

    def note_shared(self, seconds: float, n_worlds: int) -> None:
        """Learn how long a shared job took from its beginning to its end."""
        self._taken_s += seconds
        self._alone_s += self.least_s * n_worlds + FIRST_S
        self._jobs += 1
        if self._jobs < SPELL or not self.least_s:
            return
        if self._taken_s > self._alone_s:
            self._rest, self._next_rest = self._next_rest, min(2 * self._next_rest, MOST_REST)
        else:
            self._next_rest = REST
        self._taken_s, self._alone_s, self._jobs = 0.0, 0.0, 0

    def workers(self, n_worlds: int, most: int, worth_s: float) -> int:
        """Return how many may do the work, ``most`` at most, so that each has enough for its trouble ``worth_s``."""
        most = min(most, n_worlds)
        if worth_s <= 0.0:
            return most
        return max(1, min(most, int(self.least_s * n_worlds / worth_s)))

    def is_worth_a_try(self) -> bool:
        """Return whether the next job may be shared; asked once for each, as those that may not are counted."""
        if self._rest:
            self._rest -= 1
            return False
        return True
