"""What was read of some worlds last, for as long as nothing of it has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

REMEMBERED_WORLDS = 16


class Kept(Generic[T]):
    """One value for each of the worlds that were asked for last, and what it was made from."""

    def __init__(self) -> None:
        self._worlds: dict[int, tuple[object, T]] = {}

    def get(self, world: int, key: object, make: Callable[[T | None], T]) -> T:
        """Return the value of a world.

        Args:
            world: Its index.
            key: What the value is made from; as long as it is equal the value stays the same object.
            make: Makes the value, from the last one of this world where there is one.
        """
        known = self._worlds.pop(world, None)
        if known is None or known[0] != key:
            known = key, make(None if known is None else known[1])
            if len(self._worlds) >= REMEMBERED_WORLDS:
                self._worlds.pop(next(iter(self._worlds)))
        self._worlds[world] = known
        return known[1]
