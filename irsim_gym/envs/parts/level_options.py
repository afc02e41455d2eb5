"""Levels that a caller asks for: the options of a reset, and choices of the level that follows."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import UnknownNameError, suggestion
from irsim_gym.simulator.engine.given import LEVELS
from irsim_gym.tasks.episodes.levels import CHAIN, check_split

LAST = 2 * LEVELS - 1


def read_options(options: Mapping[str, Any]) -> tuple[str | None, int | None]:
    """Return ``split`` and ``level`` of a reset's options, None for an absent one.

    Raises:
        UnknownNameError: An unknown key or split.
        ValueError: A level that is not a number from 0 on.
    """
    if not options:
        return None, None
    for key in options:
        if key not in ("split", "level"):
            raise UnknownNameError(f"no reset option named {key!r}{suggestion(str(key), ('split', 'level'))}")
    split, level = options.get("split"), options.get("level")
    if split is not None:
        check_split(split)
    is_number = isinstance(level, int | np.integer) and not isinstance(level, bool)
    if level is not None and not (is_number and 0 <= level <= LAST):
        raise ValueError(f"options['level'] must be an integer from 0 to {LAST}, got {level!r}")
    return split, None if level is None else int(level)


def checked_choice(levels: Sequence[int] | Ints, count: int) -> Ints:
    """Return the levels that worlds begin next, shape ``(count,)``.

    Raises:
        ValueError: They are no whole numbers from -1 on, or not so many.
    """
    numbers = np.asarray(levels)
    if numbers.shape != (count,) or numbers.dtype.kind not in "iu":
        raise ValueError(f"levels must hold a whole number for each of {count} worlds, got {levels!r}")
    wrong = (numbers < CHAIN) | (numbers > LAST)
    if wrong.any():
        raise ValueError(f"levels must be 0 to {LAST}, or {CHAIN} for the next of the chain, got {numbers[wrong][0]}")
    return numbers.astype(np.int64)


def fresh_level(w: int) -> int:
    """Return a level drawn from the operating system's entropy."""
    return int(np.random.default_rng().integers(LEVELS))
