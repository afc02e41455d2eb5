"""The members of one kind, with their parameters as a record array."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints

if TYPE_CHECKING:
    from irsim_gym.world.company import Company


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
        arrays: The kind's own arrays: readings, tables, scratch.
        tables: What the kind's kernels take as structs, as ``prepare`` makes it.
        names: Names of all bodies, for kinds that tell them; may be empty.
        company: What else there is to tell of all bodies, for kinds that do; may be None.
    """

    kind: Any
    options: Sequence[Any]
    members: Ints
    params: Any = None
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    tables: Any = None
    names: tuple[str, ...] = ()
    company: Company | None = None

    def __post_init__(self) -> None:
        if self.params is None:
            self.params = records(self.options)

    def __repr__(self) -> str:
        return f"<Group of {len(self.members)} {getattr(self.kind, '__name__', self.kind)}>"

    def select(self, chosen: Ints) -> Group:
        """Return a group of some of the members, by their numbers in this one; it shares the arrays."""
        options = [self.options[k] for k in chosen]
        members, params = self.members[chosen], self.params[chosen]
        return Group(self.kind, options, members, params, self.arrays, self.tables, self.names, self.company)


def records(options: Sequence[Any]) -> Any:
    """Return the numeric fields of dataclass instances as an array of records that kernels read by name.

    It is a plain array whose rows are ``np.record``: Numba takes 3 us longer to recognise a ``np.recarray``.

    Numbers and booleans enter it, choices (``Literal``) as the index of the choice, tuples of numbers as
    sub-arrays and an absent number (None) as NaN; text and ragged values do not. The array always has at
    least the field ``index``.
    """
    hints = {kind: get_type_hints(kind) for kind in {type(item) for item in options}}
    read: dict[int, dict[str, NDArray[Any]]] = {}  # a crowd shares one instance
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
    found = {name: _as_number(getattr(item, name), hints[name]) for name in names}
    return {name: value for name, value in found.items() if value is not None}


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
