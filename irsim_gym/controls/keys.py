"""Keys that go down and up, and which of them are held."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

REPEAT_S = 0.03
"""A key that is down again within this time after it went up was held: so do keyboards repeat [s]."""


@dataclass(frozen=True)
class Stroke:
    """A key that went down or up.

    Attributes:
        key: Its name without modifiers: ``w``, ``1``, ``space``, ``escape``, ``f5``.
        down: Whether it went down.
        time: When [s], by any clock that all strokes of a source share.
        alt: An alt key was down.
        shift: A shift key was down.
    """

    key: str
    down: bool
    time: float
    alt: bool = False
    shift: bool = False


class KeySource(ABC):
    """Where strokes come from."""

    name: str

    @abstractmethod
    def strokes(self) -> list[Stroke]:
        """Return the strokes since the last call, in order."""

    @abstractmethod
    def close(self) -> None:
        """Listen no longer. May be called twice."""


class HeldKeys:
    """The keys that are down, in the order in which they were pressed.

    A held key repeats as pairs of up and down, so one that goes up counts as down until it stays up for ``REPEAT_S``.
    """

    def __init__(self) -> None:
        self._down: list[str] = []
        self._up_since: dict[str, tuple[float, float]] = {}

    def take(self, stroke: Stroke, now: float) -> bool:
        """Take a stroke that arrives now [s]; return whether a key was pressed that was not down before."""
        if not stroke.down:
            if stroke.key in self._down:
                self._up_since[stroke.key] = stroke.time, now
            return False
        went_up, _ = self._up_since.pop(stroke.key, (None, None))
        if stroke.key in self._down:
            if went_up is None or stroke.time - went_up <= REPEAT_S:
                return False
            self._down.remove(stroke.key)
        self._down.append(stroke.key)
        return True

    def settle(self, now: float) -> None:
        """Let go of keys that have been up for long enough; the time is that of ``take`` [s]."""
        for key, (_, since) in list(self._up_since.items()):
            if now - since > REPEAT_S:
                self._down.remove(key)
                del self._up_since[key]

    def release_all(self) -> None:
        """Let go of all keys, as when another window gets them."""
        self._down.clear()
        self._up_since.clear()

    def latest(self, *keys: str) -> str | None:
        """Return which of some keys was pressed last and is still down; None where none is."""
        return next((key for key in reversed(self._down) if key in keys), None)
