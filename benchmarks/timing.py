"""How times are taken: CPU time, several rounds, and a loop of plain Python that says whether a round was disturbed.

Standard library alone: the peers' processes use it in their own virtual environments.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

CALIBRATION_LOOPS = 200_000
DISTURBED = 0.25
"""A round counts as disturbed when its calibration loop took longer than the least one by more than this share."""


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
    """Return the CPU seconds of a fixed loop of plain Python."""
    begin = time.process_time()
    total = 0
    for number in range(CALIBRATION_LOOPS):
        total += number & 7
    return time.process_time() - begin


def is_disturbed(taken: float, least: float) -> bool:
    """Return whether a calibration loop says that something else slowed the round down."""
    return taken > (1.0 + DISTURBED) * least
