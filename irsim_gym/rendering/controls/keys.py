"""Key strokes, and the keys that are held."""

from dataclasses import dataclass

REPEAT_S = 0.03
"""A key that goes down again within this time after going up counts as held, since keyboards repeat so [s]."""


@dataclass(frozen=True)
class Stroke:
    """The press or release of a key.

    Attributes:
        key: Name of the key without modifiers: ``w``, ``1``, ``space``, ``escape``, ``f5``.
        down: Whether the key was pressed.
        time: Time of the stroke [s], by any clock that all strokes of a source share.
        alt: Whether an alt key was down.
        shift: Whether a shift key was down.
    """

    key: str
    down: bool
    time: float
    alt: bool = False
    shift: bool = False


class HeldKeys:
    """The keys that are down, in the order in which they were pressed.

    A held key repeats as pairs of up and down, so a key counts as down until it stays up for ``REPEAT_S``.
    """

    def __init__(self) -> None:
        self._down: list[str] = []
        self._up_since: dict[str, tuple[float, float]] = {}

    def take(self, stroke: Stroke, now: float) -> bool:
        """Process a stroke that arrives now [s]; return whether it newly presses a key."""
        if not stroke.down:
            if stroke.key in self._down:
                # Two clocks: strokes are compared by their source's, waiting is measured by the caller's.
                self._up_since[stroke.key] = stroke.time, now
            return False
        went_up, _ = self._up_since.pop(stroke.key, (None, None))
        if stroke.key in self._down:
            # Down again without going up, or soon after it: the key repeats.
            if went_up is None or stroke.time - went_up <= REPEAT_S:
                return False
            self._down.remove(stroke.key)
        self._down.append(stroke.key)
        return True

    def settle(self, now: float) -> None:
        """Release keys that have been up for long enough, by the clock of ``take`` [s]."""
        for key, (_, since) in list(self._up_since.items()):
            if now - since > REPEAT_S:
                self._down.remove(key)
                del self._up_since[key]

    def latest(self, *keys: str) -> str | None:
        """Return the key among ``keys`` that was pressed last and is still down; None if none is down."""
        return next((key for key in reversed(self._down) if key in keys), None)
