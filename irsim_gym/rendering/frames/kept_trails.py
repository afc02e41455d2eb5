"""Cached pictures of the ground with the outlines in trails, since most frames add no outline."""

from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.raster import records
from irsim_gym.rendering.raster.play import note_past
from irsim_gym.simulator.readings.trails import Trails
from irsim_gym.simulator.world.model import Model

MOST_NUMBERS = 4096
"""Maximum number of values in a cached trail; larger trails are drawn anew for each frame."""


class KeptTrails:
    """Caches the latest such picture of each world.

    Frames of a world with everything on take 8 % longer without it (benchmarks/choices.md).

    Args:
        live: The items of a plan that are drawn anew for each frame.
        model: Constants of the simulation.
        trails: Past poses of its bodies.
        room: Maximum number of worlds.
        end: Maximum number of items to cache, because marks are drawn above them and below the next one.

    Attributes:
        items: The cached items of ``live``: outlines with only the ground below them.
        others: The other items.
    """

    def __init__(self, live: Any, model: Model, trails: Trails, room: int, end: int) -> None:
        is_kept = (live["kind"] == records.GHOSTS) & (live["every"] > 1)
        count = min(int(np.argmin(np.append(is_kept, False))), end)
        self.items, self.others = live[:count], live[count:]
        self._model, self._trails, self._room = model, trails, room
        bodies = [int(body) for body in self.items["body"]]
        self._bodies = np.array(bodies, np.int64)
        self._segments = rows_of(model.segment_start, model.segment_count, bodies, model.local_segments.shape[1])
        self._discs = rows_of(model.disc_start, model.disc_count, bodies, model.local_discs.shape[1])
        self._known: dict[int, tuple[Any, Bytes]] = {}

    def key(self, world: int, ground: object) -> Any:
        """Return the key of a world's picture, given the key of its ground; None if the picture is not cached."""
        if not len(self.items):
            return None
        numbers, model = np.empty(MOST_NUMBERS), self._model
        count = note_past(self.items, world, records.Past(*self._trails.tables()), numbers)
        if count < 0 or (world not in self._known and len(self._known) >= self._room):
            return None
        shapes = (
            table[world % len(table), rows]
            for table, rows in (
                (model.local_segments, self._segments),
                (model.local_discs, self._discs),
                (model.segment_count, self._bodies),
                (model.disc_count, self._bodies),
                (model.present, self._bodies),
            )
        )
        return ground, numbers[:count].tobytes(), *(shape.tobytes() for shape in shapes)

    def known(self, world: int, key: object) -> Bytes | None:
        """Return the cached picture of a world; None if it is outdated or missing."""
        kept = self._known.get(world)
        return kept[1] if kept is not None and kept[0] == key else None

    def keep(self, world: int, key: object, picture: Bytes) -> None:
        """Cache a picture, which must not change any more, replacing an older one."""
        self._known[world] = key, picture


def rows_of(start: Any, size: Any, bodies: Any, n_rows: int) -> Any:
    """Return the rows of some bodies in a table of outlines, for the largest outlines of all worlds."""
    ends = [int(start[b]) + int(size[:, b].max(initial=0)) for b in bodies]
    rows = [np.arange(start[b], min(end, n_rows)) for b, end in zip(bodies, ends, strict=True)]
    return np.concatenate([np.zeros(0, np.int64), *rows])
