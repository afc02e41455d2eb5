"""How times are taken: CPU time, several rounds, and loops of plain Python that say whether a round was disturbed.

Standard library alone: the peers' processes use it in their own virtual environments.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

CALIBRATION_LOOPS = 50_000
CALIBRATION_RUNS = 4
DISTURBED = 0.25
"""A round counts as disturbed when its calibration is off by more than this share of what is usual in its process."""


@dataclass(frozen=True)
class Timing:
    """What several rounds of one measurement gave, in the unit of the figure.

    Attributes:
        least: The least of all rounds.
        median: Their median.
        rounds: How many there were.
    """

    least: float
    median: float
    rounds: int

    @property
    def noise(self) -> float:
        """How far the median lies above the least, as a share of it."""
        return self.median / self.least - 1.0 if self.least > 0.0 else 0.0

    def times(self, factor: float) -> Timing:
        """Return the same in another unit."""
        return Timing(factor * self.least, factor * self.median, self.rounds)


def summed_up(values: list[float]) -> Timing:
    """Return what the rounds gave."""
    return Timing(min(values), statistics.median(values), len(values))


def seconds(function: Callable[[], Any], clock: Callable[[], float] = time.process_time) -> float:
    """Return the seconds of one call: of CPU of all threads, or by another clock."""
    begin = clock()
    function()
    return clock() - begin


def cost(
    function: Callable[[], Any],
    rounds: int,
    *,
    before: Callable[[], Any] | None = None,
    clock: Callable[[], float] = time.process_time,
) -> Timing:
    """Return the seconds of a call after a first one that does not count.

    Args:
        function: What is measured.
        rounds: How many calls count.
        before: Called before each, outside of the measurement.
        clock: Which clock.
    """
    values = []
    for _ in range(rounds + 1):
        if before is not None:
            before()
        values.append(seconds(function, clock))
    return summed_up(values[1:])


def calibration() -> float:
    """Return the CPU seconds of a loop of plain Python: the least of a few, so that waking up does not count."""
    return min(seconds(_count) for _ in range(CALIBRATION_RUNS))


def _count() -> int:
    total = 0
    for number in range(CALIBRATION_LOOPS):
        total += number & 7
    return total


def off(calibrations: Sequence[float]) -> list[float]:
    """Return by what share the calibration of each round is off from their median: as often too slow as too fast."""
    usual = statistics.median(calibrations) if calibrations else 1.0
    return [max(one, usual) / min(one, usual) - 1.0 for one in calibrations]
