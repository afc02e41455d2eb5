"""Gymnasium spaces of a task, and observations in the form that the space declares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete

from irsim_gym.arraytypes import Rays
from irsim_gym.tasks import Episodes

Observation: TypeAlias = Rays | dict[str, Rays]


@dataclass(frozen=True)
class Layout:
    """Where each observation term stands in the flat observation, and which form the user asked for.

    Attributes:
        slices: Columns of each term, by name, in order.
        flat: True for one vector, False for a dict of vectors.
    """

    slices: dict[str, slice]
    flat: bool

    def fresh(self, rows: Rays) -> Observation:
        """Return a copy of flat observations in the declared form.

        Args:
            rows: Flat observations, shape ``(..., n_features)``.
        """
        if self.flat:
            return rows.copy()
        return {name: rows[..., columns].copy() for name, columns in self.slices.items()}


def observation_layout(episodes: Episodes) -> Layout:
    """Return the layout of the observations of a task."""
    slices: dict[str, slice] = {}
    start = 0
    for name, low, _ in episodes.observation_terms:
        slices[name] = slice(start, start + low.size)
        start += low.size
    return Layout(slices, episodes.task.observation_form == "flat")


def observation_space(episodes: Episodes) -> Space[Any]:
    """Return a ``Box`` for flat observations, else a ``Dict`` with a ``Box`` for each term."""
    terms = episodes.observation_terms
    if episodes.task.observation_form == "flat":
        low = np.concatenate([low for _, low, _ in terms])
        high = np.concatenate([high for _, _, high in terms])
        return Box(low, high, dtype=np.float32)
    return Dict({name: Box(low, high, dtype=np.float32) for name, low, high in terms})


def action_space(episodes: Episodes) -> Space[Any]:
    """Return ``Discrete(n)`` or the ``Box`` [-1, 1] of a task's actions."""
    if episodes.action_kind == "discrete":
        return Discrete(episodes.n_discrete)
    low, high = (np.asarray(bound, np.float32) for bound in (episodes.action_low, episodes.action_high))
    return Box(low, high, dtype=np.float32)
