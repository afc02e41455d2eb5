"""Gymnasium spaces of a task, and observations in the form that the space declares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete

from irsim_gym.arraytypes import Flags, Ints, Rays
from irsim_gym.tasks import Episodes

Observation: TypeAlias = Rays | dict[str, Rays]


@dataclass(frozen=True)
class Layout:
    """Where each observation term stands in the flat observation, and which form the user asked for.

    Attributes:
        columns: Columns of each term, by name, in order.
        picked: All these columns; None where that is every one there is.
        flat: True for one vector, False for a dict of vectors.
    """

    columns: dict[str, slice | Ints]
    picked: Ints | None
    flat: bool

    def fresh(self, rows: Rays) -> Observation:
        """Return a copy of flat observations in the declared form.

        Args:
            rows: Flat observations, shape ``(..., n_features)``.
        """
        if not self.flat:
            return {name: np.array(rows[..., columns], order="C") for name, columns in self.columns.items()}
        return rows.copy() if self.picked is None else rows.take(self.picked, axis=-1)

    def formed(self, rows: Rays) -> Observation:
        """Return flat observations that nobody else holds in the declared form, themselves where that is theirs."""
        return rows if self.flat and self.picked is None else self.fresh(rows)

    def each(self, rows: Rays) -> Sequence[Observation]:
        """Return each of some flat observations that nobody else holds, shape ``(n, n_features)``, as ``formed``."""
        formed = self.formed(rows)
        if not isinstance(formed, dict):
            return list(formed)
        return [dict(zip(formed, row, strict=True)) for row in zip(*formed.values(), strict=True)]


def observation_layout(episodes: Episodes, agent: int | None = None) -> Layout:
    """Return the layout of the observations of a task.

    Args:
        episodes: The task.
        agent: Leave out the columns that mean nothing to this agent; None for those of the richest.
    """
    columns: dict[str, slice | Ints] = {}
    picked: list[Ints] = []
    start = 0
    for name, low, _ in episodes.observation_terms:
        used = np.ones(low.size, np.bool_) if agent is None else _used(episodes, agent, start, low.size)
        if used.any():
            places = start + np.flatnonzero(used)
            columns[name] = slice(start, start + low.size) if used.all() else places
            picked.append(places)
        start += low.size
    every = sum(map(len, picked)) == start
    return Layout(columns, None if every else np.concatenate(picked), episodes.task.observation_form == "flat")


def observation_space(episodes: Episodes, agent: int | None = None) -> Space[Any]:
    """Return a ``Box`` for flat observations, else a ``Dict`` with one for each term; see ``observation_layout``."""
    boxes, start = {}, 0
    for name, low, high in episodes.observation_terms:
        used = np.ones(low.size, np.bool_) if agent is None else _used(episodes, agent, start, low.size)
        start += low.size
        if used.any():
            boxes[name] = low[used], high[used]
    if episodes.task.observation_form == "flat":
        low, high = (np.concatenate(bounds) for bounds in zip(*boxes.values(), strict=True))
        return Box(low, high, dtype=np.float32)
    return Dict({name: Box(low, high, dtype=np.float32) for name, (low, high) in boxes.items()})


def _used(episodes: Episodes, agent: int, start: int, width: int) -> Flags:
    return np.asarray(episodes.feature_mask[agent, start : start + width])


def action_space(episodes: Episodes, agent: int | None = None) -> Space[Any]:
    """Return ``Discrete(n)`` or the ``Box`` [-1, 1] of a task's actions: one agent's, or that of the largest drive."""
    if episodes.action_kind == "discrete":
        return Discrete(episodes.n_discrete)
    low, high = (np.asarray(bound, np.float32) for bound in (episodes.action_low, episodes.action_high))
    size = len(low) if agent is None else int(episodes.action_sizes[agent])
    return Box(low[:size], high[:size], dtype=np.float32)
