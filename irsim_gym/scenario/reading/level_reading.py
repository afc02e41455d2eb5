"""Reads levels from a file, or lists all its mistakes: first those of arrays, then those of levels."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags
from irsim_gym.base.errors import Problem, ScenarioError, UnreadableFileError, suggestion
from irsim_gym.base.options import LARGEST
from irsim_gym.base.outside_files import json_text, npz_arrays, reading
from irsim_gym.scenario.specs.level_set import ARRAYS, NEEDED, SPLITS, LevelSet, with_goal_axis

MOST_TOLD = 3
"""Maximum number of levels that are named for one mistake of an array."""

Found = dict[str, NDArray[Any]]
Mistake = tuple[str, str]
"""Name of an array, and its mistake."""


def read_levels(file: str | Path) -> LevelSet:
    """Read a file of levels.

    Raises:
        ScenarioError: If the file cannot be used; the error lists every problem.
    """
    levels, mistakes = load_levels(Path(file))
    if levels is None or mistakes:
        raise ScenarioError(str(file), [Problem(0, name, text) for name, text in mistakes])
    return levels


def load_levels(file: Path) -> tuple[LevelSet | None, list[Mistake]]:
    """Return the levels of a file and its mistakes; None for the levels if they cannot be read."""
    try:
        with reading(file, "file of levels"):
            arrays = npz_arrays(file)
    except UnreadableFileError as error:
        return None, [("", error.reason)]
    unknown, mistakes = list(_unknown(arrays)), [*_missing(arrays), *_shapes(arrays)]
    if mistakes:
        return None, [*unknown, *mistakes]
    levels = complete_levels(str(file), arrays, _about(arrays.get("about")))
    return levels, [*unknown, *_values(levels, arrays)]


def _unknown(arrays: Found) -> Iterator[Mistake]:
    for name in arrays:
        if name not in ARRAYS:
            yield name, f"unknown array{suggestion(name, ARRAYS) or '; known: ' + ', '.join(ARRAYS)}"


def _missing(arrays: Found) -> Iterator[Mistake]:
    for name in NEEDED:
        if name not in arrays:
            yield name, "is missing"
    for rows, start in (("segments", "segment_start"), ("discs", "disc_start"), ("splits", "split_start")):
        if (rows in arrays) != (start in arrays):
            present, missing = (rows, start) if rows in arrays else (start, rows)
            yield missing, f"is missing, and {present} needs it"


def _shapes(arrays: Found) -> Iterator[Mistake]:
    """Yield arrays with a wrong type or shape; the first array with an axis determines its length."""
    sizes: dict[str, tuple[int, str]] = {}
    for name, declared in ARRAYS.items():
        array = arrays.get(name)
        if array is None:
            continue
        if array.dtype.kind not in declared.kinds:
            yield name, f"must hold {_WORDS[declared.kinds[0]]}, got {array.dtype}"
        axes, wish = declared.axes_of(array.ndim), f"must have the axes ({', '.join(declared.axes)})"
        if array.ndim != len(axes):
            yield name, f"{wish}, got shape {array.shape}"
            continue
        for axis, length in zip(axes, array.shape, strict=True):
            if axis.isdigit():
                if length != int(axis):
                    yield name, f"{wish}, got shape {array.shape}"
                continue
            key, more = axis.removesuffix("+1"), int(axis.endswith("+1"))
            base_length, whose = sizes.setdefault(key, (length - more, name))
            if length != base_length + more:
                yield name, f"axis {axis} must be {base_length + more} long, as {whose} has {base_length}, got {length}"
    for axis in ("level", "goal"):
        if sizes.get(axis, (1, ""))[0] == 0:
            yield sizes[axis][1], f"holds no {axis}"


_WORDS = {"U": "text", "f": "numbers", "b": "true or false", "i": "whole numbers", "u": "unsigned whole numbers"}


def complete_levels(file: str, arrays: Mapping[str, Any], about: Mapping[str, Any]) -> LevelSet:
    """Return levels, with defaults for missing arrays."""
    start = np.ascontiguousarray(arrays["start"], np.float64)
    count, size = start.shape[:2]
    offsets = np.zeros((count, size + 1), np.int64)
    names = [str(name) for name in arrays.get("splits", np.array(["all"]))]
    ends = np.asarray(arrays.get("split_start", np.array([0, count])), np.int64)
    splits = {name: (int(a), int(b - a)) for name, a, b in zip(names, ends[:-1], ends[1:], strict=True)}
    cells, random = arrays.get("cells"), arrays.get("random")
    return LevelSet(
        file=file,
        bodies=tuple(str(name) for name in arrays["bodies"]),
        start=start,
        goal=with_goal_axis(arrays.get("goal", np.full(start.shape, np.nan))),
        present=np.ascontiguousarray(arrays.get("present", np.ones((count, size))), np.bool_),
        segments=np.ascontiguousarray(arrays.get("segments", np.zeros((0, 4))), np.float64),
        segment_start=np.ascontiguousarray(arrays.get("segment_start", offsets), np.int64),
        discs=np.ascontiguousarray(arrays.get("discs", np.zeros((0, 3))), np.float64),
        disc_start=np.ascontiguousarray(arrays.get("disc_start", offsets), np.int64),
        cells=None if cells is None else np.ascontiguousarray(cells, np.bool_),
        random=None if random is None else np.ascontiguousarray(random, np.uint64),
        splits=splits,
        about=about,
    )


def _about(text: NDArray[Any] | None) -> Mapping[str, Any]:
    """Return the file's description of itself; empty if it is not a JSON object."""
    try:
        return {} if text is None else json_text(str(text))
    except (ValueError, RecursionError):
        return {}


def _values(levels: LevelSet, arrays: Found) -> Iterator[Mistake]:
    """Yield mistakes in the values of levels."""
    doubled = sorted({name for name in levels.bodies if levels.bodies.count(name) > 1})
    if doubled:
        yield "bodies", f"the name '{doubled[0]}' is there twice"
    bad = ~((np.abs(levels.start) <= LARGEST).all(axis=2)) & levels.present
    yield from _per_level("start", bad, levels, "must be three numbers between -1e7 and 1e7", levels.start)
    yield from _goal_mistakes(levels)
    for name, rows in (("segment_start", levels.segments), ("disc_start", levels.discs)):
        offsets = getattr(levels, name)
        bad = (np.diff(offsets, axis=1) < 0) | (offsets[:, :-1] < 0) | (offsets[:, 1:] > len(rows))
        wish = f"must not fall, and lie between 0 and {len(rows)}"
        yield from _per_level(name, bad, levels, wish, np.stack([offsets[:, :-1], offsets[:, 1:]], axis=2))
    is_side = np.array((np.abs(levels.segments) <= LARGEST).all(axis=1), np.bool_)
    yield from _per_row("segments", is_side, levels.segments, "must be four numbers between -1e7 and 1e7")
    is_disc = np.array((np.abs(levels.discs) <= LARGEST).all(axis=1) & (levels.discs[:, 2] > 0.0), np.bool_)
    yield from _per_row("discs", is_disc, levels.discs, "must be x, y and a radius above 0")
    cells = arrays.get("cells")
    if cells is not None and (cells > 1).any():
        level = int(np.argwhere(cells > 1)[0, 0])
        yield "cells", f"level {level}: must be 0 (free) or 1 (occupied), got {cells[level].max()}"
    yield from _split_mistakes(levels, arrays)


def _goal_mistakes(levels: LevelSet) -> Iterator[Mistake]:
    """Yield invalid goals, and gaps in the order of goals."""
    x, y, heading = np.moveaxis(levels.goal, 3, 0)
    is_good = (np.abs(x) <= LARGEST) & (np.abs(y) <= LARGEST) & ~(np.abs(heading) > LARGEST)
    is_none = np.array(np.isnan(levels.goal).all(axis=3), np.bool_)
    shown = levels.goal if levels.goal.shape[2] > 1 else levels.goal[:, :, 0]
    bad = ~(is_good | is_none).all(axis=2) & levels.present
    yield from _per_level("goal", bad, levels, "must be x, y and a heading or NaN, or three NaN", shown)
    gap = (is_none[:, :, :-1] & ~is_none[:, :, 1:]).any(axis=2) & levels.present & ~bad
    yield from _per_level("goal", gap, levels, "rows of NaN must come after all goals", shown)


def _per_row(name: str, is_good: Flags, values: NDArray[Any], wish: str) -> Iterator[Mistake]:
    """Yield the first bad row of a table."""
    bad = np.flatnonzero(~is_good)
    if bad.size:
        yield name, f"row {bad[0]}: {wish}, got {values[bad[0]]}"


def _per_level(name: str, bad: Flags, levels: LevelSet, wish: str, values: NDArray[Any]) -> Iterator[Mistake]:
    """Yield the first levels with bad values of a body, by flags ``(n_levels, n_bodies)``."""
    places = np.argwhere(bad).tolist()
    for level, body in places[:MOST_TOLD]:
        yield name, f"level {level}, '{levels.bodies[body]}': {wish}, got {values[level, body].tolist()}"
    if len(places) > MOST_TOLD:
        yield name, f"and {len(places) - MOST_TOLD} more like these"


def _split_mistakes(levels: LevelSet, arrays: Found) -> Iterator[Mistake]:
    if "splits" not in arrays:
        return
    names = [str(name) for name in arrays["splits"]]
    wrong = [name for name in names if name not in SPLITS and len(names) > 1]
    if wrong or len(set(names)) < len(names) or not names:
        yield "splits", f"must be different ones of {', '.join(SPLITS)}, got {', '.join(names) or 'none'}"
    ends = arrays["split_start"].tolist()
    if ends[0] != 0 or ends[-1] != levels.count or any(b <= a for a, b in pairwise(ends)):
        yield "split_start", f"must rise from 0 to the number of levels, {levels.count}, got {ends}"
