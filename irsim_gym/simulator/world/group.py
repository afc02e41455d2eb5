"""The members of one kind, with their parameters as a record array."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Ints


@dataclass
class Shard:
    """A share of the work: which worlds, and whose scratch memory.

    Attributes:
        worlds: Indices of the worlds, shape ``(n,)``.
        slot: Number of the share; two shares that run at the same time have different ones.
    """

    worlds: Ints
    slot: int = 0


@dataclass
class Group:
    """All members of one kind.

    Attributes:
        kind: The registered class, whose static methods run the members.
        options: One instance of it for each member.
        members: Body of each member, shape ``(n_members,)``.
        params: Records of the members' numeric options, shape ``(n_members,)``.
        arrays: The kind's own arrays, of any shape: readings, tables, scratch.
        tables: What the kind's kernels take as structs, as ``prepare`` makes it.
        names: Names of all bodies, for kinds that tell them; may be empty.
        context: Specifications and sensors of all bodies, for kinds that show them; may be None.
        guide: The members that a behaviour drives through velocities (``simulator.step.guide``); None without any.
        scan: The members' own scans (``own_scan.OwnScan``), for behaviours with ``reads_scan``; else None.
    """

    kind: Any
    options: Sequence[Any]
    members: Ints
    params: Any = None
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    tables: Any = None
    names: tuple[str, ...] = ()
    context: WorldContext | None = None
    guide: Any = None
    scan: Any = None

    def __post_init__(self) -> None:
        if self.params is None:
            self.params = records(self.options)

    def __repr__(self) -> str:
        return f"<Group of {len(self.members)} {getattr(self.kind, '__name__', self.kind)}>"

    def select(self, chosen: Ints) -> Group:
        """Return a group of some of the members, by their numbers in this one; it shares the arrays.

        Args:
            chosen: Numbers of the members, shape ``(n,)``.
        """
        options = [self.options[k] for k in chosen]
        params = self.params[chosen]
        members = self.members[chosen]
        guide = None if self.guide is None else self.guide.among(members)
        scan = None if self.scan is None else self.scan.select(chosen)
        return replace(self, options=options, members=members, params=params, guide=guide, scan=scan)


@dataclass(frozen=True)
class WorldContext:
    """The bodies of a scenario, their sensors and their fields of view.

    Attributes:
        bodies: What the file says of each body.
        sensors: Groups of sensors with their readings.
        detect: Writes who is in a body's field of view, see ``simulator.engine.field_of_view``.
        weighed: Returns the masses of the bodies (``simulator.pushing.matter.Matter``).
        pushing: What they feel of each other (``simulator.pushing.memory.Pushing``); None if they do not push.
    """

    bodies: Sequence[Any]
    sensors: Sequence[Group]
    detect: Callable[..., None]
    weighed: Callable[[], Any]
    pushing: Any


def find_sensor(
    bodies: Sequence[Any], sensors: Sequence[Group], body: int, reading: str, index: int = 0
) -> tuple[Group, int] | None:
    """Return the group and the member number of one of a body's sensors with some reading, None without it.

    Args:
        bodies: What the file says of each body.
        sensors: The groups of sensors.
        body: The body.
        reading: What the sensor reads, such as ``"ranges"``.
        index: Which of these sensors, in the order of the file.
    """
    wanted = [options for options in bodies[body].sensors if options.reading == reading]
    if not 0 <= index < len(wanted):
        return None
    for group in sensors:
        for k in map(int, np.flatnonzero(group.members == body)):
            if group.options[k] is wanted[index]:
                return group, k
    return None


def records(options: Sequence[object]) -> Any:
    """Return the numeric fields of dataclass instances as an array of records that kernels read by name.

    It is a plain array with the dtype ``np.record``: Numba takes 3 us longer to recognise an ``np.recarray``.

    Numbers and booleans enter it, choices (``Literal``) as the index of the choice, tuples of numbers as
    sub-arrays and an absent number (None) as NaN; text and ragged values do not. The array always has at
    least the field ``index``.
    """
    hints = {kind: get_type_hints(kind) for kind in {type(item) for item in options}}
    read: dict[int, dict[str, NDArray[Any]]] = {}  # by identity: the members of a crowd share one instance
    for item in options:
        if id(item) not in read:
            read[id(item)] = _numbers(item, hints[type(item)])
    rows = [read[id(item)] for item in options]
    fields: list[Any] = [("index", np.int64)]
    for name, value in rows[0].items() if rows else ():
        fields.append((name, value.dtype, value.shape) if value.ndim else (name, value.dtype))
    table = np.zeros(len(options), np.dtype((np.record, fields)))
    table["index"] = np.arange(len(options))
    for k, row in enumerate(rows):
        for name, value in row.items():
            table[name][k] = value
    return table


def _numbers(item: Any, hints: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    names = [declared.name for declared in dataclasses.fields(item)]
    numbers = {name: _as_number(getattr(item, name), hints[name]) for name in names}
    return {name: value for name, value in numbers.items() if value is not None}


def _as_number(value: Any, hint: Any) -> NDArray[Any] | None:
    """Return an option as a number or a row of numbers; None when it is neither."""
    if get_origin(hint) is Literal:
        return np.asarray(get_args(hint).index(value), np.int64)
    if hint in (int, bool):
        return np.asarray(int(value), np.int64)
    if hint is float or hint == (float | None):
        return np.asarray(np.nan if value is None else value, np.float64)
    if get_origin(hint) is tuple and Ellipsis not in get_args(hint) and set(get_args(hint)) <= {int, float}:
        return np.asarray(value, np.int64 if set(get_args(hint)) == {int} else np.float64)
    return None
