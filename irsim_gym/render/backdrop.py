"""What seldom changes, kept as pixels: a frame begins with a copy of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import is_
from typing import Any

REMEMBERED_WORLDS = 16

Part = tuple[Any, list[Any]]
"""Who draws, and what."""


@dataclass
class _Known:
    """What was drawn for one world.

    Attributes:
        ground: What the ground was drawn from.
        region: The canvas with the ground alone.
        slow: What was drawn over it.
        slow_region: The canvas with both.
    """

    ground: tuple[Any, ...]
    region: Any
    slow: list[Part] = field(default_factory=list)
    slow_region: Any = None


class Backdrop:
    """The ground of each world, and over it what changes now and then and is only added to where that is enough.

    Args:
        canvas: An Agg canvas.
        draw_ground: Draws the ground on it.
    """

    def __init__(self, canvas: Any, draw_ground: Callable[..., None]) -> None:
        self._canvas, self._draw_ground = canvas, draw_ground
        self._worlds: dict[int, _Known] = {}

    def put(self, world: int, ground: tuple[Any, ...], slow: Sequence[Part], draw: Callable[[Any, Any], None]) -> None:
        """Put it on the canvas.

        Args:
            world: Whose it is.
            ground: What the ground is drawn from, the arguments of ``draw_ground``; the same ground as long as each is
                the same object or equal.
            slow: What lies over it: who draws, and what, the lowest first.
            draw: Lets somebody draw something.
        """
        known = self._worlds.pop(world, None)
        if known is None or not _same(known.ground, ground):
            self._draw_ground(*ground)
            known = _Known(ground, self._copied())
            if len(self._worlds) >= REMEMBERED_WORLDS:
                self._worlds.pop(next(iter(self._worlds)))
        self._worlds[world] = known
        added = _added(known.slow, slow) if known.slow_region is not None else None
        if added is None:
            self._canvas.restore_region(known.region)
            added = list(slow)
        else:
            self._canvas.restore_region(known.slow_region)
        if added or known.slow_region is None:
            for part, views in added:
                draw(part, views)
            known.slow, known.slow_region = list(slow), self._copied() if slow else known.region

    def _copied(self) -> Any:
        return self._canvas.copy_from_bbox(self._canvas.figure.bbox)


def _same(one: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Return whether two grounds are the same: tuples, such as those of bodies, where they are the same object."""
    return all(a is b or (not isinstance(a, tuple) and a == b) for a, b in zip(one, other, strict=True))


def _added(known: Sequence[Part], wanted: Sequence[Part]) -> list[Part] | None:
    """Return what has to be drawn over what is known; None where some of that is no longer wanted.

    Only the topmost layer may have grown: what lies below another one cannot be added any more.
    """
    if len(known) != len(wanted) or any(a[0] is not b[0] for a, b in zip(known, wanted, strict=True)):
        return None
    for (_, before), (_, now) in zip(known[:-1], wanted[:-1], strict=True):
        if len(before) != len(now) or not all(map(is_, before, now)):
            return None
    if not known:
        return []
    (_, before), (part, now) = known[-1], wanted[-1]
    if len(before) > len(now) or not all(map(is_, before, now)):
        return None
    return [(part, now[len(before) :])] if len(now) > len(before) else []
