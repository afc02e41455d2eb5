"""What actions, observations, rewards and endings from outside have to be: checked when they are registered and bound.

The methods that a kind must or may have, and their arguments, are those of the protocols in ``term`` and ``words``.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from pydantic.fields import FieldInfo

from irsim_gym.errors import KindError, nearest, suggestion
from irsim_gym.registry import OWN
from irsim_gym.scenario.options import option_fields
from irsim_gym.tasks.outcome import PRECEDENCE, Outcome
from irsim_gym.tasks.term import (
    ActionKind,
    EndingKind,
    HasArrays,
    HasUnused,
    IsImage,
    ObservationKind,
    Remembers,
    RewardKind,
    Role,
    Term,
)
from irsim_gym.tasks.words import TellsActions, TellsColumns, TellsWhen
from irsim_gym.world.model import WorldModel

NEEDS = {
    "needs_goal": "True if it means nothing for an agent without a goal, else False",
    "needs_scan": "True if it needs a range sensor, else False",
    "needs_ending": "True if it is paid only where the task ends on its outcome, else False",
}


@dataclass(frozen=True)
class Contract:
    """What the kinds of a family have to have.

    Attributes:
        protocol: Declares the methods.
        method: The one that each kind must have.
        flags: Attributes that are True or False.
        optional: Protocols whose methods a kind may have.
    """

    protocol: type[Any]
    method: str
    flags: tuple[str, ...] = ()
    optional: tuple[type[Any], ...] = ()


CONTRACTS = {
    "action": Contract(ActionKind, "act", (), (HasArrays, TellsActions)),
    "observation": Contract(
        ObservationKind, "write", ("needs_goal", "needs_scan"), (HasArrays, Remembers, HasUnused, TellsColumns)
    ),
    "reward": Contract(RewardKind, "pay", ("needs_goal", "needs_ending"), (HasArrays, Remembers, TellsWhen)),
    "ending": Contract(EndingKind, "ends", ("needs_goal",), (HasArrays, TellsWhen)),
}


def is_foreign(kind: Any) -> bool:
    """Return whether a kind is not one of the package's own, which its tests see to."""
    return not str(getattr(kind, "__module__", "")).startswith(OWN)


def check_kind(family: str, name: str, kind: Any) -> None:
    """Check a class that is about to be registered.

    Raises:
        KindError: It cannot work; the error lists all that is wrong with it.
    """
    if not isinstance(kind, type):
        raise KindError(f"{family} '{name}': register takes the class, got {kind!r}")
    contract = CONTRACTS[family]
    problems = list(_making(kind))
    problems += _method(kind, contract.method, contract.protocol, required=True)
    for protocol in contract.optional:
        for method in _methods(protocol):
            problems += _method(kind, method, protocol, required=False)
    for flag in contract.flags:
        problems += _flag(kind, flag)
    problems += {"action": _action, "observation": _observation, "reward": _reward, "ending": _ending}[family](kind)
    refuse(family, name, kind, problems)


def refuse(family: str, name: str, kind: type[Any], problems: Iterable[str], method: str = "") -> None:
    """Raise a KindError that lists problems, if there are any, with file and line of the kind or of its method."""
    found = list(problems)
    if not found:
        return
    head = f"{family} '{name}' ({kind.__qualname__}{place_of(kind, method)})"
    raise KindError(f"{head}: {found[0]}" if len(found) == 1 else "\n  ".join([f"{head}:", *found]))


def place_of(kind: type[Any], method: str = "") -> str:
    """Return ``, file:line`` of a method, or of a class; nothing where that is not known."""
    names = [method] if method else [name for name in vars(kind) if not name.startswith("__")]
    codes = [getattr(_function(vars(kind).get(name)), "__code__", None) for name in names]
    known = [code for code in codes if code is not None]
    try:
        if not method:
            return f", {inspect.getsourcefile(kind)}:{inspect.getsourcelines(kind)[1]}"
    except (OSError, TypeError):
        pass  # made by exec, or typed in
    return f", {known[0].co_filename}:{known[0].co_firstlineno}" if known else ""


def _function(attribute: Any) -> Any:
    """Return the function behind a method, a static one or a property."""
    if isinstance(attribute, property):
        return attribute.fget
    return getattr(attribute, "__func__", attribute)


def _methods(protocol: type[Any]) -> list[str]:
    return [name for name, value in vars(protocol).items() if not name.startswith("_") and _is_method(value)]


def _is_method(value: Any) -> bool:
    return inspect.isfunction(value) or isinstance(value, staticmethod)


def _making(kind: type[Any]) -> Iterator[str]:
    """Yield whether the class was made by ``@kind``, with all its options."""
    if not hasattr(kind, "__pydantic_fields__"):
        yield "it is no kind: write @kind above the class (from irsim_gym.scenario.options import kind)"
        return
    known = option_fields(kind)
    for name, value in vars(kind).items():
        if isinstance(value, FieldInfo) and name not in known:
            yield f"option '{name}' has no type: write '{name}: float = option(...)'"
    hints = {name: str(hint) for name, hint in vars(kind).get("__annotations__", {}).items() if name not in known}
    lost = [name for name, hint in hints.items() if "ClassVar" not in hint]
    if lost:
        yield f"its options {', '.join(lost)} are not known: write @kind above this class too"


def _method(kind: type[Any], name: str, protocol: type[Any], *, required: bool) -> Iterator[str]:
    """Yield what is wrong with a method."""
    wanted = [one for one in inspect.signature(getattr(protocol, name)).parameters if one != "self"]
    call = f"{name}({', '.join(wanted)})"
    given = inspect.getattr_static(kind, name, None)
    if given is None:
        if required:
            others = [one for one, value in vars(kind).items() if _is_method(value)]
            near = nearest(name, others)
            yield f"it has no method {call}" + (f"; is '{near}' meant?" if near else "")
        return
    function = _function(given)
    if not callable(function) or isinstance(given, property):
        yield f"'{name}' must be a method {call}, got {type(given).__name__}"
        return
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return
    bound = 0 if isinstance(given, staticmethod) else 1
    if not _takes(signature, bound + len(wanted)):
        cure = "; write @staticmethod above it" if bound and _takes(signature, len(wanted)) else ""
        yield f"'{name}' is called as {call}, but takes {signature}{cure}"
        return
    names = list(signature.parameters)[bound : bound + len(wanted)]
    if names != wanted and sorted(names) == sorted(wanted):
        yield f"'{name}' is called as {call}, by position, but takes {signature}: another order"


def _takes(signature: inspect.Signature, count: int) -> bool:
    try:
        signature.bind(*range(count))
    except TypeError:
        return False
    return True


def _flag(kind: type[Any], name: str) -> Iterator[str]:
    given = inspect.getattr_static(kind, name, None)
    if given is None:
        yield f"it has no '{name}': {NEEDS[name]}"
    elif not isinstance(given, bool | property):
        yield f"'{name}' must be {NEEDS[name]}, got {given!r}"


def _has(kind: type[Any], name: str) -> bool:
    return name in getattr(kind, "__pydantic_fields__", ()) or inspect.getattr_static(kind, name, None) is not None


def _action(kind: type[Any]) -> Iterator[str]:
    if not _has(kind, "n_choices"):
        yield "it has no 'n_choices': a property, the number of choices, 0 for a continuous action"


def _observation(kind: type[Any]) -> Iterator[str]:
    if _has(kind, "image_shape"):
        return
    if not _has(kind, "bounds"):
        yield "it has neither 'bounds(term, model)' nor, for a picture, 'image_shape'"
    else:
        yield from _method(kind, "bounds", ObservationKind, required=True)


def _reward(kind: type[Any]) -> Iterator[str]:
    role, outcome = (inspect.getattr_static(kind, name, None) for name in ("role", "outcome"))
    roles = get_args(Role)
    if role is None:
        yield f"it has no 'role': one of {', '.join(roles)}"
    elif not isinstance(role, property) and role not in roles:
        yield f"its role must be one of {', '.join(roles)}, got {role!r}{suggestion(str(role), roles)}"
    yield from _outcome(outcome, list(Outcome), "what a bonus or a penalty is for, else Outcome.RUNNING")
    if role == "bonus" and outcome is Outcome.RUNNING:
        yield "a bonus is for an outcome, such as Outcome.SUCCESS, got Outcome.RUNNING"
    if not _has(kind, "weight"):
        yield "it has no option 'weight': write 'weight: float = option(1.0, ge=0.0, meaning=...)'"


def _ending(kind: type[Any]) -> Iterator[str]:
    outcome = inspect.getattr_static(kind, "outcome", None)
    yield from _outcome(outcome, list(PRECEDENCE), "what becomes of an agent whose episode ends so")


def _outcome(given: Any, allowed: list[Outcome], meaning: str) -> Iterator[str]:
    names = ", ".join(f"Outcome.{one.name}" for one in allowed)
    if given is None:
        yield f"it has no 'outcome', {meaning}: one of {names} (from irsim_gym.tasks import Outcome)"
    elif not isinstance(given, property) and (not isinstance(given, Outcome) or given not in allowed):
        yield f"its outcome, {meaning}, must be one of {names}, got {given!r}"


def check_bound(family: str, term: Term) -> None:
    """Check a kind from outside that has been bound to a simulation, with its options as they are given.

    Raises:
        KindError: It cannot work so.
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


def _arrays(given: Any) -> Iterator[str]:
    if not isinstance(given, Mapping):
        yield f"arrays() must return a dict of arrays by name, got {type(given).__name__}"
        return
    for name, value in given.items():
        if not isinstance(value, np.ndarray):
            yield f"arrays() must return NumPy arrays, got {type(value).__name__} for {name!r}"


def _image_shape(given: Any) -> Iterator[str]:
    sizes = given if isinstance(given, tuple | list) else ()
    if len(sizes) != 3 or not all(_is_number(size, int | np.integer) and size > 0 for size in sizes):
        yield f"image_shape must be (height, width, channels), whole numbers > 0, got {given!r}"


def checked_bounds(term: Term, model: WorldModel) -> tuple[Any, Any]:
    """Return the bounds of an observation from outside as float32 arrays.

    Raises:
        KindError: They are no bounds.
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
