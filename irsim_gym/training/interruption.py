"""How a command that was stopped ends."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

from irsim_gym.errors import IrsimGymError


class TrainingInterruptedError(IrsimGymError):
    """A run was stopped by a signal; its checkpoint is on disk.

    Attributes:
        signal: Number of the signal.
    """

    def __init__(self, message: str, number: int) -> None:
        super().__init__(message)
        self.signal = number


def stopped_early(steps: int, number: int) -> TrainingInterruptedError:
    """Return the error of a run that a signal stopped after so many steps."""
    return TrainingInterruptedError(f"stopped after {steps:,} steps; nothing is lost", number)


def stopped_at_end(steps: int, number: int) -> TrainingInterruptedError:
    """Return the error of a run that a signal stopped when it had taken all steps."""
    return TrainingInterruptedError(f"stopped after all {steps:,} steps; the run is finished", number)


@contextmanager
def ctrl_c_told(message: str) -> Iterator[None]:
    """Turn Ctrl-C, where nothing else listens to it, into an error with this message.

    Raises:
        TrainingInterruptedError: Ctrl-C.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise TrainingInterruptedError(message, signal.SIGINT) from None
