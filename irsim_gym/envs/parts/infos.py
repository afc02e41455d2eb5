"""Infos of agents: as Python numbers, or as arrays with masks."""

import struct
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from itertools import chain
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.tasks import Episodes

NUMBERS = ("path_length", "min_clearance", "goal_distance", "stalled")
COUNTS = ("outcome", "hit", "hit_kind", "steps", "level")
FLAGS = ("is_success", "deadlocked")
DERIVED = ("_together", "_flat", "_flat_terms", "_row")
"""Attributes that point into arrays; a copy finds its own."""
KEYS = (*NUMBERS, *COUNTS, *FLAGS)
_NUMPY: dict[str, Any] = {**dict.fromkeys((*COUNTS, "shield", "cost"), np.int64), **dict.fromkeys(FLAGS, np.array)}
"""NumPy's types of all but floats; Gymnasium's vector environments make objects of ``np.bool_``."""
Row = tuple[Any, ...]
"""The values of ``KEYS``, of the reward's terms and of extras; ``alone`` reads reward and flags behind them."""


class Infos:
    """The infos of the agents of some worlds. All return values are fresh.

    ``EpisodeState`` stores the columns of one type next to each other, so three copies serve eleven columns. With one
    world and one agent, all values lie in one block of memory, which a single call reads. In a copy (pickle, deepcopy)
    the columns lie apart; there each call joins them.

    Args:
        in_numpy: Infos of single agents hold NumPy scalars, see ``WorldEnv``; else Python numbers.
    """

    def __init__(self, episodes: Episodes, in_numpy: bool = False) -> None:
        view = episodes.view
        self._in_numpy = in_numpy
        self._columns = [[view.infos[key] for key in keys] for keys in (NUMBERS, COUNTS, FLAGS)]
        self._terms, self._reward, self._ends = view.reward_terms, view.reward, [view.terminated, view.truncated]
        self._extra = episodes.state.extra
        self._names = (*reward_keys(episodes.reward_names), *episodes.extra_names)
        self._places = tuple(enumerate(self._names, start=len(KEYS)))
        self._masked = tuple(chain(*((key, f"_{key}") for key in (*KEYS, *self._names))))
        self._n_worlds, self._n_agents = episodes.n_worlds, episodes.n_agents
        self._find_blocks()

    def of(self, w: int, agent: int = 0) -> dict[str, Any]:
        """Return the info of an agent of a world."""
        if self._row is not None:
            return self.of_row(self._row())
        values = chain(*(block[:, w, agent].tolist() for block in self._blocks()), self._terms[w, agent].tolist())
        values = chain(values, self._extra[w, agent].tolist())
        return self.of_row(tuple(values))

    def of_row(self, row: Row) -> dict[str, Any]:
        """Return the info of one of ``rows``.

        A dict display takes two thirds of the time of ``dict(zip(keys, row))``.
        """
        (
            path_length, min_clearance, goal_distance, stalled,
            outcome, hit, hit_kind, steps, level,
            is_success, deadlocked,
        ) = row[: len(KEYS)]  # fmt: skip
        # Keys are written out: 0.59 us for 18 of them, where dict(zip(...)) takes 0.80, of a step of some 3 us.
        info = {"outcome": outcome, "hit": hit, "hit_kind": hit_kind, "path_length": path_length}
        info |= {
            "min_clearance": min_clearance,
            "goal_distance": goal_distance,
            "is_success": is_success,
            "steps": steps,
        }
        info |= {"stalled": stalled, "deadlocked": deadlocked, "level": level}
        for place, name in self._places:
            info[name] = row[place]
        return _in_numpy(info) if self._in_numpy else info

    def alone(self) -> tuple[float, bool, bool, dict[str, Any]]:
        """Return reward, termination, truncation and info of the first agent of the first world."""
        if self._row is not None:
            row = self._row()
            return row[-3], row[-2], row[-1], self.of_row(row)
        terminated, truncated = (flags.item(0) for flags in self._ends)
        return self._reward.item(0), terminated, truncated, self.of(0)

    def rows(self, places: Ints) -> list[Row]:
        """Return the rows of some agents, ``world * n_agents + agent`` each; ``of_row`` makes an info of each."""
        return _rows(self.now(), places)

    def now(self) -> list[NDArray[Any]]:
        """Return numbers, counts, flags, ``(n_columns, n_places)`` each; terms and extras, ``(n_places, n)`` each."""
        blocks = self._flat or [block.reshape(len(block), -1) for block in self._blocks()]
        return [*blocks, self._flat_terms, self._extra.reshape(len(self._flat_terms), -1)]

    def batched(self, chosen: Flags | None = None) -> dict[str, Any]:
        """Return the first agents' infos as Gymnasium's vector environments do: arrays, and a mask ``_key`` for each.

        Args:
            chosen: Worlds that have an info, shape ``(n_worlds,)``; the others get zeros. None for all.
        """
        parts = [*(block[:, :, 0] for block in self._blocks()), self._terms[:, 0].T, self._extra[:, 0].T]
        masks = np.empty((len(KEYS) + len(self._names), self._n_worlds), np.bool_)
        if chosen is None:
            copies = [np.array(part, order="C") for part in parts]
            masks[:] = True
        else:
            rows = chosen.nonzero()[0]
            copies = [_spread(part, rows) for part in parts]
            masks[:] = chosen
        values = chain.from_iterable(zip(chain(*copies), masks, strict=True))
        return dict(zip(self._masked, values, strict=True))

    def _blocks(self) -> list[NDArray[Any]]:
        """Return arrays of shape ``(n_columns, n_worlds, n_agents)``: numbers, counts, flags."""
        return self._together or [np.stack(columns) for columns in self._columns]

    def _find_blocks(self) -> None:
        blocks = [block for block in map(_block, self._columns) if block is not None]
        self._together = blocks if len(blocks) == len(self._columns) else []
        self._flat = [block.reshape(len(block), -1) for block in self._together]
        self._flat_terms = self._terms.reshape(self._n_worlds * self._n_agents, self._terms.shape[2])
        columns = [*chain(*self._columns), self._terms, self._extra, self._reward, *self._ends]
        self._row = _row_reader(columns) if self._n_worlds == self._n_agents == 1 else None

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key not in DERIVED}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._find_blocks()


def reward_keys(names: Iterable[str]) -> tuple[str, ...]:
    """Return the keys of reward terms in an info: ``reward/progress`` and so on.

    They are flat because the readers of some libraries, TorchRL among them, know no dict within a dict.
    """
    return tuple(f"reward/{name}" for name in names)


class Record:
    """A copy of each agent's info at a moment of its own, such as the beginning of its episode.

    Args:
        infos: The infos to copy from.
    """

    def __init__(self, infos: Infos) -> None:
        self._infos = infos
        self._parts = [np.zeros_like(part) for part in infos.now()]

    def note(self, places: Ints) -> None:
        """Copy the present infos of some agents."""
        *blocks, terms, extra = self._infos.now()
        *columns_before, kept_terms, kept_extra = self._parts
        for ours, block in zip(columns_before, blocks, strict=True):
            ours[:, places] = block.take(places, axis=1)
        kept_terms[places], kept_extra[places] = terms.take(places, axis=0), extra.take(places, axis=0)

    def infos_of(self, places: Ints) -> list[dict[str, Any]]:
        """Return the copied infos of some agents."""
        return [self._infos.of_row(row) for row in _rows(self._parts, places)]


# TorchRL needs it. It is not the default, because a step takes half as long again (8.2 us, not 5.2).
def _in_numpy(info: dict[str, Any]) -> dict[str, Any]:
    return {key: _NUMPY.get(key, np.float64)(value) for key, value in info.items()}


def _rows(parts: Sequence[NDArray[Any]], places: Ints) -> list[Row]:
    *blocks, terms, extra = parts
    columns: list[Any] = []
    for block in (*blocks, terms.T, extra.T):
        columns += block.take(places, axis=1).tolist()
    return list(zip(*columns, strict=True))


def _block(columns: Sequence[NDArray[Any]]) -> NDArray[Any] | None:
    """Return the array that has these columns as rows; None where they do not lie side by side."""
    first = columns[0]
    for k, item in enumerate(columns):
        if item.base is None or item.base is not first.base or item.ctypes.data != first.ctypes.data + k * first.nbytes:
            return None
    return as_strided(first, (len(columns), *first.shape), (first.nbytes, *first.strides))


def _row_reader(columns: Sequence[NDArray[Any]]) -> Callable[[], Row] | None:
    """Return a function that reads all columns of one world as Python numbers; None where they lie apart."""
    first, layout = columns[0], "@"
    for item in columns:
        layout += f"0{item.dtype.char}"
        if item.base is not first.base or item.ctypes.data != first.ctypes.data + struct.calcsize(layout):
            return None
        layout += f"{item.size}{item.dtype.char}"
    if not isinstance(first.base, np.ndarray):
        return None
    begin = first.ctypes.data - first.base.ctypes.data
    return partial(struct.Struct(layout).unpack_from, first.base.data, begin)


def _spread(part: NDArray[Any], chosen: Ints) -> NDArray[Any]:
    """Return a fresh copy with zeros in all columns but the chosen ones."""
    copy = np.zeros(part.shape, part.dtype)
    copy[:, chosen] = part.take(chosen, axis=1) if part.flags.c_contiguous else part[:, chosen]  # the faster one
    return copy
