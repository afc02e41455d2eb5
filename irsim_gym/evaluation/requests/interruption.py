"""The error of an interrupted command."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

from irsim_gym.base.errors import IrsimGymError


class TrainingInterruptedError(IrsimGymError):
    """Raised if a signal stops a run. Its checkpoint is on disk.

    Attributes:
        signal: Number of the signal.
    """

    def __init__(self, message: str, number: int) -> None:
        super().__init__(message)
        self.signal = number


def stopped_early(steps: int, number: int) -> TrainingInterruptedError:
    """Return the error of a run that a signal stopped after ``steps`` steps."""
    return TrainingInterruptedError(f"stopped after {steps:,} steps; nothing is lost", number)


def stopped_at_end(steps: int, number: int) -> TrainingInterruptedError:
    """Return the error of a run that a signal stopped after its last step."""
    return TrainingInterruptedError(f"stopped after all {steps:,} steps; the run is finished", number)


@contextmanager
def ctrl_c_as_error(message: str) -> Iterator[None]:
    """Convert a ``KeyboardInterrupt`` to an error with this message.

    Raises:
        TrainingInterruptedError: If Ctrl-C is pressed and no other handler takes it.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise TrainingInterruptedError(message, signal.SIGINT) from None
