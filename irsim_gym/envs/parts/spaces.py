"""Gymnasium spaces of a task, and observations in the form that the space declares."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from gymnasium import Space
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from irsim_gym.base.arraytypes import Flags, Ints
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.episodes.transition import Percepts, Transition
from irsim_gym.tasks.terms.term import Term

Observation: TypeAlias = NDArray[Any] | dict[str, NDArray[Any]]
VECTOR = "vector"
"""Key of all that is no picture, where a flat observation has pictures beside it."""


@dataclass(frozen=True)
class ObservationLayout:
    """The place of each observation term in the flat observation, and the form that the user chose.

    Attributes:
        columns: Columns of each term, by name, in order.
        picked: All these columns; None where that is every one there is.
        flat: True for one vector, False for a dict of vectors.
        images: Names of the terms that are pictures. A flat observation is then a dict of them and the vector, or the
            one picture itself where there is nothing else.
        plain: Observations are the flat ones themselves.
    """

    columns: dict[str, slice | Ints]
    picked: Ints | None
    flat: bool
    images: tuple[str, ...] = ()
    plain: bool = field(init=False)

    def __post_init__(self) -> None:
        is_plain = self.flat and self.picked is None and not self.images
        object.__setattr__(self, "plain", is_plain)

    def fresh(self, seen: Percepts | Transition, place: Any = ...) -> Observation:
        """Return a copy of observations in the declared form.

        Args:
            seen: What agents perceive.
            place: An index into the axes of the agents: whose observations; by default all.
        """
        rows: NDArray[Any] = seen.observation[place]
        if self.plain:
            return rows.copy()
        if not self.flat:
            parts = {name: np.array(rows[..., columns], order="C") for name, columns in self.columns.items()}
            return {**parts, **self._pictures(seen, place)} if self.images else parts
        if self.images and not self.columns and len(self.images) == 1:
            return np.array(seen.images[self.images[0]][place], order="C")
        vector = rows.copy() if self.picked is None else rows.take(self.picked, axis=-1)
        if not self.images:
            return vector
        pictures = self._pictures(seen, place)
        return {**pictures, VECTOR: vector} if self.columns else pictures

    def shared(self, seen: Percepts, place: Any = ...) -> Observation:
        """Return observations in the declared form as views, which change with what the agents perceive.

        Args:
            seen: What agents perceive.
            place: A slice or an index into the axes of the agents.
        """
        rows: NDArray[Any] = seen.observation[place]
        if self.plain:
            return rows
        pictures = {name: seen.images[name][place] for name in self.images}
        if not self.flat:
            return {**{name: rows[..., columns] for name, columns in self.columns.items()}, **pictures}
        if self.columns:
            return {**pictures, VECTOR: rows}
        return next(iter(pictures.values())) if len(pictures) == 1 else pictures

    def formed(self, seen: Percepts) -> Observation:
        """Return unshared observations in the declared form; the given arrays where these have it."""
        return seen.observation if self.plain else self.fresh(seen)

    def each(self, seen: Percepts | Transition, worlds: Ints) -> Sequence[Observation]:
        """Return a fresh observation of the first agent in each of some worlds."""
        if self.plain:
            return list(seen.observation[:, 0].take(worlds, axis=0))
        formed = self.fresh(seen, (worlds, 0))
        if not isinstance(formed, dict):
            return list(formed)
        return [dict(zip(formed, row, strict=True)) for row in zip(*formed.values(), strict=True)]

    def _pictures(self, seen: Percepts | Transition, place: Any) -> dict[str, NDArray[Any]]:
        return {name: np.array(seen.images[name][place], order="C") for name in self.images}


def observation_layout(episodes: Episodes, agent: int | None = None) -> ObservationLayout:
    """Return the layout of the observations of a task.

    Args:
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
    is_flat = episodes.task.observation_form == "flat"
    return ObservationLayout(columns, None if every else np.concatenate(picked), is_flat, tuple(episodes.view.images))


def observation_space(episodes: Episodes, agent: int | None = None) -> Space[Any]:
    """Return the space of a task's observations, those of one agent or, with None, of the richest.

    Flat observations are a ``Box``, else there is a ``Dict`` with one ``Box`` for each term. A picture is a ``Box`` of
    its own, uint8 from 0 to 255, ``(height, width, n_channels)``: a flat observation with pictures is a
    ``Dict`` of these and the ``Box`` ``vector`` for all other terms, or the one picture itself where there is nothing
    else.
    """
    boxes, start = {}, 0
    for name, low, high in episodes.observation_terms:
        used = np.ones(low.size, np.bool_) if agent is None else _used(episodes, agent, start, low.size)
        start += low.size
        if used.any():
            boxes[name] = low[used], high[used]
    images = episodes.view.images
    spaces: dict[str, Space[Any]] = {name: Box(0, 255, image.shape[2:], np.uint8) for name, image in images.items()}
    if episodes.task.observation_form == "dict":
        return Dict({**spaces, **{name: Box(low, high, dtype=np.float32) for name, (low, high) in boxes.items()}})
    if boxes:
        low, high = (np.concatenate(sides) for sides in zip(*boxes.values(), strict=True))
        spaces[VECTOR] = Box(low, high, dtype=np.float32)
    return next(iter(spaces.values())) if len(spaces) == 1 else Dict(spaces)


def observed(episodes: Episodes) -> Iterator[tuple[str, Term]]:
    """Yield the key of each observation, which is empty where there is one array, and its term."""
    for term in episodes.terms["observations"]:
        yield _key(episodes, term.name), term


def _key(episodes: Episodes, name: str) -> str:
    if episodes.task.observation_form == "dict":
        return name
    images, n_columns = episodes.view.images, len(episodes.observation_terms)
    if len(images) + bool(n_columns) == 1:
        return ""
    return name if name in images else VECTOR


def _used(episodes: Episodes, agent: int, start: int, width: int) -> Flags:
    return np.asarray(episodes.feature_mask[agent, start : start + width])


def action_space(episodes: Episodes, agent: int | None = None) -> Space[Any]:
    """Return ``Discrete(n)`` or the ``Box`` [-1, 1] of a task's actions: one agent's, or that of the largest drive."""
    if episodes.action_kind == "discrete":
        return Discrete(episodes.n_discrete)
    low, high = (np.asarray(bound, np.float32) for bound in (episodes.action_low, episodes.action_high))
    size = len(low) if agent is None else int(episodes.action_sizes[agent])
    return Box(low[:size], high[:size], dtype=np.float32)
