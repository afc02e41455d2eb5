"""Interrupted commands: their error, and a clean stop."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from irsim_gym.base.errors import IrsimGymError


class TrainingInterruptedError(IrsimGymError):
    """Raised if a signal stops a run. Its checkpoint is on disk.

    Attributes:
        signal: Number of the signal.
    """

    def __init__(self, message: str, number: int) -> None:
        super().__init__(message)
        self.signal = number


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


class StopRequest:
    """A request to stop by Ctrl-C, SIGTERM or SIGHUP. A second signal stops at once.

    Attributes:
        signal: Number of the signal; None before the first one.
    """

    def __init__(self) -> None:
        self.signal: int | None = None

    @contextmanager
    def listening(self) -> Iterator[StopRequest]:
        """Handle these signals, but not SIGHUP where ``nohup`` ignores it. Does nothing outside the main thread."""
        if threading.current_thread() is not threading.main_thread():
            yield self
            return
        kinds = [signal.SIGINT, signal.SIGTERM]
        if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
            kinds.append(signal.SIGHUP)
        before = {kind: signal.signal(kind, self._handle) for kind in kinds}
        try:
            yield self
        finally:
            for kind, handler in before.items():
                signal.signal(kind, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None:
            raise KeyboardInterrupt
        self.signal = number
