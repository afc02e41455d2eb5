"""Levels as data: the arrays of a file of levels, and how it is written."""

import hashlib
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Words
from irsim_gym.base.errors import UnknownNameError, suggestion

SPLITS = ("train", "dev", "test")
GRAIN = 1e6
"""Resolution of hashes [1/m, 1/rad]; the last bits of a sine differ between processors."""


@dataclass(frozen=True)
class LevelArray:
    """The declaration of one array of a file of levels.

    Attributes:
        axes: Names of its axes; a digit is a fixed length, and ``body+1`` is one more than the number of bodies. An
            axis in brackets may be omitted.
        kinds: NumPy's codes of the accepted kinds of types.
        unit: SI unit.
        meaning: Content of the array.
    """

    axes: tuple[str, ...]
    kinds: str
    unit: str
    meaning: str

    def axes_of(self, n_axes: int) -> tuple[str, ...]:
        """Return the names of the axes of an array with ``n_axes`` axes, without axes that it omits."""
        has_all = len(self.axes) == n_axes
        return tuple(axis.strip("[]") for axis in self.axes if has_all or not axis.startswith("["))


ARRAYS: Mapping[str, LevelArray] = {
    "bodies": LevelArray(("body",), "U", "", "Names of the bodies that the file places, in the order of its arrays."),
    "start": LevelArray(("level", "body", "3"), "fiu", "m, m, rad", "Pose at the start: x, y, heading."),
    "goal": LevelArray(
        ("level", "body", "[goal]", "3"),
        "fiu",
        "m, m, rad",
        "Goals in order: x, y, heading; a heading of NaN is any, a row of NaN no goal. Bodies without any keep "
        "those of the scenario.",
    ),
    "present": LevelArray(("level", "body"), "b", "", "False for a body that the level does not have."),
    "segments": LevelArray(("segment", "4"), "fiu", "m", "Sides of outlines in the body's frame: x0, y0, x1, y1."),
    "segment_start": LevelArray(
        ("level", "body+1"), "iu", "", "Rows of segments: those of body k end where those of body k + 1 begin."
    ),
    "discs": LevelArray(("disc", "3"), "fiu", "m", "Discs of outlines in the body's frame: x, y, radius."),
    "disc_start": LevelArray(("level", "body+1"), "iu", "", "Rows of discs, as segment_start."),
    "cells": LevelArray(
        ("level", "column", "row"), "biu", "", "Occupied cells of the map, columns from the left, rows from the bottom."
    ),
    "random": LevelArray(("level",), "u", "", "Random stream at the start, for noise and for goals that wander."),
    "splits": LevelArray(("split",), "U", "", "Names of the splits: train, dev, test; without it, the file is one."),
    "split_start": LevelArray(("split+1",), "iu", "", "First level of each split, and the number of all levels."),
    "about": LevelArray((), "U", "", "Where the levels come from, as a JSON object."),
}
NEEDED = ("bodies", "start")


@dataclass(frozen=True)
class LevelSet:
    """Levels, as arrays whose first axis is the level; see ``ARRAYS``.

    Attributes:
        file: Path of the file; empty for levels without a file.
        bodies: Names of the bodies.
        start: Poses [m, m, rad], shape ``(n_levels, n_bodies, 3)``.
        goal: Goals in order [m, m, rad], shape ``(n_levels, n_bodies, n_goals, 3)``; NaN after the last goal, and for
            bodies that keep the scenario's own goals.
        present: Whether the level has each body, shape ``(n_levels, n_bodies)``.
        segments: Sides of outlines [m], shape ``(n_segments, 4)``.
        segment_start: Rows of each body's segments, shape ``(n_levels, n_bodies + 1)``.
        discs: Discs of outlines [m], shape ``(n_discs, 3)``.
        disc_start: Rows of each body's discs, shape ``(n_levels, n_bodies + 1)``.
        cells: Occupied cells, shape ``(n_levels, columns, rows)``; None to keep the scenario's map.
        random: Random streams at the start, shape ``(n_levels,)``; None to derive them from the scenario's name.
        splits: First level and number of levels of each split; a single split serves as any.
        about: Origin of the levels.
    """

    file: str
    bodies: tuple[str, ...]
    start: Floats
    goal: Floats
    present: Flags
    segments: Floats
    segment_start: Ints
    discs: Floats
    disc_start: Ints
    cells: NDArray[np.bool_] | None
    random: Words | None
    splits: Mapping[str, tuple[int, int]]
    about: Mapping[str, Any] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of levels."""
        return len(self.start)

    def rows(self, split: str) -> tuple[int, int]:
        """Return the first level of a split and its number of levels.

        Raises:
            UnknownNameError: If the file has several splits, but not this one.
        """
        if len(self.splits) == 1:
            return next(iter(self.splits.values()))
        if split not in self.splits:
            alternatives = f"{suggestion(split, self.splits)}; it has {', '.join(self.splits)}"
            raise UnknownNameError(f"{self.file} has no split '{split}'{alternatives}")
        return self.splits[split]

    @property
    def shaped(self) -> Flags:
        """Whether each body gets its outline from the file, shape ``(n_bodies,)``."""
        rows = np.diff(self.segment_start, axis=1) + np.diff(self.disc_start, axis=1)
        return np.array((rows > 0).any(axis=0), np.bool_)

    def outline(self, level: int, body: int) -> tuple[Floats, Floats]:
        """Return the segments and discs [m] that a level gives a body."""
        segments, discs = self.segment_start[level], self.disc_start[level]
        return self.segments[segments[body] : segments[body + 1]], self.discs[discs[body] : discs[body + 1]]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the file by name, without those that hold only defaults."""
        arrays: dict[str, NDArray[Any]] = {"bodies": np.array(self.bodies, np.str_), "start": self.start}
        if not np.isnan(self.goal[..., 0]).all():
            arrays["goal"] = self.goal if self.goal.shape[2] > 1 else self.goal[:, :, 0]
        if not self.present.all():
            arrays["present"] = self.present
        for rows, start in (("segments", "segment_start"), ("discs", "disc_start")):
            if len(getattr(self, rows)):
                arrays |= {rows: getattr(self, rows), start: getattr(self, start)}
        arrays |= {name: value for name in ("cells", "random") if (value := getattr(self, name)) is not None}
        arrays["splits"] = np.array(list(self.splits), np.str_)
        arrays["split_start"] = np.array([*(first for first, _ in self.splits.values()), self.count], np.int64)
        arrays["about"] = np.array(json.dumps(self.about, sort_keys=True))
        return arrays

    def content(self) -> bytes:
        """Return the content of the file; equal levels give equal bytes."""
        room = io.BytesIO()
        np.savez_compressed(room, allow_pickle=False, **self.arrays())
        return room.getvalue()

    def hashes(self) -> Words:
        """Return a hash of the whole content of each level, shape ``(n_levels,)``.

        Lengths and angles are rounded to a millionth, so that the hashes agree on all machines.
        """
        names, shaped = "\0".join(self.bodies).encode(), np.flatnonzero(self.shaped)
        goals = self.goal.reshape(*self.start.shape[:2], 3 * self.goal.shape[2])
        places = _to_grains(np.concatenate([self.start, goals], axis=2))
        outlines = (self.segment_start, _to_grains(self.segments)), (self.disc_start, _to_grains(self.discs))
        hashes = np.zeros(self.count, np.uint64)
        for level in range(self.count):
            present = self.present[level]
            digest = hashlib.blake2b(names, digest_size=8)
            digest.update(present.tobytes() + places[level][present].tobytes())
            for k in shaped[present[shaped]]:
                for starts, rows in outlines:
                    first, end = starts[level, k : k + 2]
                    digest.update(f"{k} {end - first} ".encode() + rows[first:end].tobytes())
            if self.cells is not None:
                digest.update(f"{self.cells.shape[1:]}".encode() + np.packbits(self.cells[level]).tobytes())
            if self.random is not None:
                digest.update(self.random[level].astype("<u8").tobytes())
            hashes[level] = int.from_bytes(digest.digest(), "little")
        return hashes


def with_goal_axis(goal: NDArray[Any]) -> Floats:
    """Add the axis of goals if it is missing: return shape ``(n_levels, n_bodies, n_goals, 3)``."""
    return np.ascontiguousarray(goal[:, :, None] if goal.ndim == 3 else goal, np.float64)


def _to_grains(values: Floats) -> Ints:
    """Return numbers as whole millionths; NaN as the smallest integer."""
    whole = np.rint(np.nan_to_num(values) * GRAIN).astype("<i8")
    whole[np.isnan(values)] = np.iinfo(np.int64).min
    return whole


def set_hash(hashes: Words) -> str:
    """Return the hash of a set of levels, 16 hexadecimal digits, from the hashes of its levels in order."""
    return hashlib.blake2b(np.asarray(hashes).astype("<u8").tobytes(), digest_size=8).hexdigest()
