"""The members of one kind, with their parameters as a record array."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Ints


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
        params: Record array of the members' numeric options, shape ``(n_members,)``.
        arrays: The kind's own arrays: readings, tables, scratch.
    """

    kind: Any
    options: Sequence[Any]
    members: Ints
    params: Any = None
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.params is None:
            self.params = records(self.options)


def records(options: Sequence[Any]) -> Any:
    """Return the numeric fields of dataclass instances as a record array that kernels read by name.

    Numbers and booleans enter it, and choices (``Literal`` fields) as the index of the choice; text,
    None and ragged values do not. The array always has at least the field ``index``.
    """
    names: dict[str, type[Any]] = {}
    rows = [_numbers(item) for item in options]
    for row in rows:
        for name, value in row.items():
            names[name] = np.float64 if isinstance(value, float) else np.int64
    dtype = np.dtype([("index", np.int64), *((name, kind) for name, kind in names.items())])
    table = np.zeros(len(options), dtype)
    table["index"] = np.arange(len(options))
    for k, row in enumerate(rows):
        for name, value in row.items():
            table[name][k] = value
    return table.view(np.recarray)


def _numbers(item: Any) -> dict[str, float | int]:
    found: dict[str, float | int] = {}
    hints = get_type_hints(type(item))
    for declared in dataclasses.fields(item):
        value, hint = getattr(item, declared.name), hints[declared.name]
        if get_origin(hint) is Literal:
            found[declared.name] = get_args(hint).index(value)
        elif isinstance(value, bool) or (hint is int and isinstance(value, int)):
            found[declared.name] = int(value)
        elif isinstance(value, (int, float)):
            found[declared.name] = float(value)
    return found
