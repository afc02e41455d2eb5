"""Checks of actions, observations, rewards and endings of plugins, beyond their protocols.

The protocols in ``term`` and ``words`` define the methods and attributes that a kind must or may have.
"""

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np

from irsim_gym.base.contract import Contract, check_method, has_member, refuse
from irsim_gym.simulator.world.names import Model
from irsim_gym.tasks.terms import HasArrays, HasGraph, IsImage, Outcome, TellsActions, TellsColumns, TellsWhen, Term
from irsim_gym.tasks.terms.mirrored import HasMirrored, Mirrored
from irsim_gym.tasks.terms.term import (
    ActionKind,
    EndingKind,
    HasBounds,
    HasUnused,
    ObservationKind,
    Remembers,
    RewardKind,
)


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
OBSERVATION = Contract(
    ObservationKind, (HasArrays, Remembers, HasUnused, HasMirrored, TellsColumns, HasGraph), _observation
)
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
        arrays = term.arrays
        types = {name: type(array) for name, array in arrays.items()} if isinstance(arrays, Mapping) else type(arrays)
        if not isinstance(types, dict) or not all(issubclass(kind, np.ndarray) for kind in types.values()):
            problems.append(f"arrays() must return a dict of NumPy arrays by name, got {types}")
    if family == "observation" and isinstance(options, IsImage):
        shape: Any = options.image_shape
        sizes = shape if isinstance(shape, tuple | list) else ()
        if len(sizes) != 3 or not all(_is_number(size, int | np.integer) and size > 0 for size in sizes):
            problems.append(f"image_shape must be (height, width, channels), whole numbers > 0, got {shape!r}")
    refuse(family, term.name, type(options), problems)


def _is_number(value: Any, kind: Any = int | float | np.integer | np.floating) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool) and bool(np.isfinite(value))


def checked_bounds(term: Term, model: Model) -> tuple[Any, Any]:
    """Return the bounds of a plugin's observation as float32 arrays.

    Raises:
        KindError: If the bounds are invalid.
    """
    limits = term.options.bounds(term, model)
    try:
        low, high = (np.asarray(values, np.float32) for values in limits)
    except (TypeError, ValueError):
        low = high = np.zeros(0, np.float32)  # refused as too few
    problems = _bound_problems(term, model, low, high, limits)
    refuse("observation", term.name, type(term.options), islice(problems, 1), "bounds")
    return low, high


def _bound_problems(term: Term, model: Model, low: Any, high: Any, limits: object) -> Iterator[str]:
    if low.ndim != 1 or low.shape != high.shape or not low.size:
        yield (
            "bounds() must return two arrays of numbers, of one shape (width,), the least and the greatest values; "
            f"got {limits!r}"
        )
    wrong = ~((low >= -1.0) & (low <= high) & (high <= 1.0))
    if wrong.any():
        k = int(np.argmax(wrong))
        yield (
            "bounds() must return finite numbers within [-1, 1], the least values first: "
            f"element {k} is from {low[k]:g} to {high[k]:g}; scale what write() writes"
        )
    if isinstance(term.options, HasUnused):
        used, shape = np.asarray(term.options.used(term)), (len(term.agents), low.size)
        if used.shape != shape or used.dtype != np.bool_:
            yield f"used() must return flags of shape {shape}, got {used.dtype} of shape {used.shape}"
    if isinstance(term.options, TellsColumns):
        width = sum(item.count for item in term.options.columns(term, model, 0))
        if width != low.size:
            yield f"columns() tells {width} columns, but bounds() has {low.size}"


def checked_mirrored(term: Term, width: int) -> Mirrored | str:
    """Return what a plugin's observation becomes in a mirror, or why it has none.

    Args:
        width: Its number of columns; for an image, of columns of pixels.

    Raises:
        KindError: If that is invalid.
    """
    answer = term.options.mirrored(term)
    if isinstance(answer, str):
        return answer
    try:
        mirrored = Mirrored(np.asarray(answer.columns), np.asarray(answer.signs, np.float32))
        is_right = _is_own_inverse(mirrored, width)
    except (AttributeError, TypeError, ValueError):
        is_right = False
    if not is_right:
        problem = (
            f"mirrored() must return the reason as text, or Mirrored(columns, signs) that names each of the {width} "
            f"columns once, with 1 or -1, and changes nothing when it is applied twice; got {answer!r}"
        )
        refuse("observation", term.name, type(term.options), [problem], "mirrored")
    return mirrored


def _is_own_inverse(mirrored: Mirrored, width: int) -> bool:
    columns, signs = mirrored.columns, mirrored.signs
    is_order = columns.dtype.kind in "iu" and columns.ndim == 1 and sorted(columns.tolist()) == list(range(width))
    if not is_order or signs.shape != (width,) or not (np.abs(signs) == 1).all():
        return False
    return bool((columns[columns] == np.arange(width)).all() and (signs == signs[columns]).all())
