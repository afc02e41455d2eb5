"""Checks of actions, observations, rewards and endings of plugins, beyond their protocols.

The protocols in ``term`` and ``words`` define the methods and attributes that a kind must or may have.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from irsim_gym.contract import Contract, check_method, has_member, refuse
from irsim_gym.tasks.mirrored import HasMirrored, Mirrored
from irsim_gym.tasks.outcome import Outcome
from irsim_gym.tasks.term import (
    ActionKind,
    EndingKind,
    HasArrays,
    HasBounds,
    HasUnused,
    IsImage,
    ObservationKind,
    Remembers,
    RewardKind,
    Term,
)
from irsim_gym.tasks.words import TellsActions, TellsColumns, TellsWhen
from irsim_gym.world.model import Model


def _observation(kind: type[Any]) -> Iterator[str]:
    if has_member(kind, "image_shape"):
        return
    if not has_member(kind, "bounds"):
        yield "it has neither 'bounds(term, model)' nor, for a picture, 'image_shape'"
    else:
        yield from check_method(kind, "bounds", HasBounds, required=True)


def _reward(kind: type[Any]) -> Iterator[str]:
    if vars(kind).get("role") == "bonus" and vars(kind).get("outcome") is Outcome.RUNNING:
        yield "a bonus is for an outcome, such as Outcome.SUCCESS, got Outcome.RUNNING"


ACTION = Contract(ActionKind, (HasArrays, Remembers, TellsActions))
OBSERVATION = Contract(ObservationKind, (HasArrays, Remembers, HasUnused, HasMirrored, TellsColumns), _observation)
REWARD = Contract(RewardKind, (HasArrays, Remembers, TellsWhen), _reward)
ENDING = Contract(EndingKind, (HasArrays, Remembers, TellsWhen))


def check_bound(family: str, term: Term) -> None:
    """Check a plugin's kind that has been bound to a simulation with its given options.

    Raises:
        KindError: If the kind cannot work with these options.
    """
    options, problems = term.options, []
    if family == "reward" and not (_is_number(options.weight) and options.weight >= 0.0):
        problems.append(f"its weight must be a number >= 0, its role gives the sign; got {options.weight!r}")
    if family == "action" and not (_is_number(options.n_choices, int) and options.n_choices >= 0):
        problems.append(f"n_choices must be a whole number >= 0, got {options.n_choices!r}")
    if isinstance(options, HasArrays):
        problems += _arrays(term.arrays)
    if family == "observation" and isinstance(options, IsImage):
        problems += _image_shape(options.image_shape)
    refuse(family, term.name, type(options), problems)


def _is_number(value: Any, kind: Any = int | float | np.integer | np.floating) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool) and bool(np.isfinite(value))


def _arrays(given: object) -> Iterator[str]:
    if not isinstance(given, Mapping):
        yield f"arrays() must return a dict of arrays by name, got {type(given).__name__}"
        return
    for name, value in given.items():
        if not isinstance(value, np.ndarray):
            yield f"arrays() must return NumPy arrays, got {type(value).__name__} for {name!r}"


def _image_shape(given: object) -> Iterator[str]:
    sizes = given if isinstance(given, tuple | list) else ()
    if len(sizes) != 3 or not all(_is_number(size, int | np.integer) and size > 0 for size in sizes):
        yield f"image_shape must be (height, width, channels), whole numbers > 0, got {given!r}"


def checked_bounds(term: Term, model: Model) -> tuple[Any, Any]:
    """Return the bounds of a plugin's observation as float32 arrays.

    Raises:
        KindError: If the bounds are invalid.
    """
    given = term.options.bounds(term, model)
    problems: list[str] = []
    low = high = np.zeros(0, np.float32)
    if not isinstance(given, tuple | list) or len(given) != 2:
        problems.append(f"bounds() must return two arrays, least and greatest values, got {given!r}")
    else:
        try:
            low, high = (np.asarray(values, np.float32) for values in given)
            problems += _bounds(low, high)
        except (TypeError, ValueError):
            problems.append(f"bounds() must return two arrays of numbers, got {given!r}")
    if not problems and isinstance(term.options, HasUnused):
        used = np.asarray(term.options.used(term))
        shape = len(term.agents), low.size
        if used.shape != shape or used.dtype != np.bool_:
            problems.append(f"used() must return flags of shape {shape}, got {used.dtype} of shape {used.shape}")
    if not problems and isinstance(term.options, TellsColumns):
        width = sum(one.count for one in term.options.columns(term, model, 0))
        if width != low.size:
            problems.append(f"columns() tells {width} columns, but bounds() has {low.size}")
    refuse("observation", term.name, type(term.options), problems, "bounds")
    return low, high


def _bounds(low: Any, high: Any) -> Iterator[str]:
    if low.ndim != 1 or low.shape != high.shape or not low.size:
        yield f"bounds() must return two arrays of one shape (width,), got {low.shape} and {high.shape}"
        return
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        yield "bounds() must be finite"
    elif (low > high).any():
        k = int(np.argmax(low > high))
        yield f"bounds() must return the least values first: element {k} is from {low[k]:g} to {high[k]:g}"
    elif low.min() < -1.0 or high.max() > 1.0:
        yield f"bounds() must be within [-1, 1], got {low.min():g} to {high.max():g}: scale what write() writes"


def checked_mirrored(term: Term, kind: type[Any], width: int) -> Mirrored | str:
    """Return what a plugin's observation becomes in a mirror, or why it has none.

    Args:
        kind: Its class.
        width: Its number of columns; for an image, of columns of pixels.

    Raises:
        KindError: If that is invalid.
    """
    given = term.options.mirrored(term)
    if isinstance(given, str):
        return given
    problems: list[str] = []
    if not isinstance(given, Mirrored):
        problems.append(f"mirrored() must return Mirrored(columns, signs) or the reason as text, got {given!r}")
    else:
        columns, signs = given.columns, given.signs
        problems += _mirror(columns, signs, width)
    refuse("observation", term.name, kind, problems, "mirrored")
    return Mirrored(np.asarray(given.columns), np.asarray(given.signs, np.float32))


def _mirror(columns: Any, signs: Any, width: int) -> Iterator[str]:
    try:
        columns, signs = np.asarray(columns), np.asarray(signs, np.float32)
    except (TypeError, ValueError):
        yield f"mirrored() must return arrays of {width} columns and {width} signs"
        return
    if columns.dtype.kind not in "iu" or sorted(columns.ravel().tolist()) != list(range(width)) or columns.ndim != 1:
        yield f"mirrored() must name each of the {width} columns once, as whole numbers, got {columns.tolist()}"
    elif signs.shape != (width,) or not np.isin(signs, (-1.0, 1.0)).all():
        yield f"mirrored() must return {width} signs that are 1 or -1, got {signs.tolist()}"
    elif (columns[columns] != np.arange(width)).any() or (signs != signs[columns]).any():
        yield "mirrored() must change nothing when it is applied twice"
