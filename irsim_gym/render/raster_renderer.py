"""Draws worlds with kernels of our own, without matplotlib: for pictures as observations and for many films."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags
from irsim_gym.render.easel import Easel, Share
from irsim_gym.render.layout import Layout
from irsim_gym.render.renderer import WorldRenderer
from irsim_gym.render.styles import TOP
from irsim_gym.world.group import Group
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class RasterRenderer(WorldRenderer):
    """Pictures of a simulation's worlds, drawn by kernels.

    Args:
        scenario: What is simulated, for names, colours and plot options.
        model: The simulation's constants.
        state: Its present state.
        sensors: Its sensor groups.
        learners: Bodies whose goals and trajectories are drawn unless the scenario says otherwise.
        explored: Which cells of the world its robots have seen; what is left lies in fog.
        share: Who divides the work of ``frames`` among threads; None for nobody. Pictures do not depend on it.
        options: See ``WorldRenderer``.
    """

    def __init__(
        self,
        scenario: Scenario,
        model: WorldModel,
        state: WorldState,
        sensors: Sequence[Group] = (),
        *,
        learners: Collection[int] = (),
        explored: Flags | None = None,
        share: Share | None = None,
        **options: Any,
    ) -> None:
        super().__init__(scenario, model, state, sensors, learners=learners, explored=explored, **options)
        self._scenario, self._model, self._state, self._sensors = scenario, model, state, sensors
        self._learners, self._explored, self._share = learners, explored, share
        self._easel: Easel | None = None

    def frame(self, world: int = 0, status: str = "") -> Bytes:
        """Draw a world; see ``WorldRenderer``."""
        picture: Bytes = self.frames([world], [status])[0]
        return picture

    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds; see ``WorldRenderer``."""
        chosen, told = np.array(worlds, np.int64), list(statuses) or [""] * len(worlds)
        if len(told) != len(chosen):
            raise ValueError(f"as many statuses as worlds: {len(chosen)}, got {len(told)}")
        state, reader = self._state, self._reader
        for world in dict.fromkeys(chosen.tolist()):
            self.trails.record(np.array([world]), state.step[[world]], state.pose[[world]])
        overlays = [reader.overlay(world) for world in chosen.tolist()]
        lowest = min((mark.layer for overlay in overlays for mark in overlay.marks), default=TOP)
        if self._easel is not None and lowest < self._easel.covered:
            self._easel = None  # a mark lies below what the easel has for ground
        ready = [status or reader.status(world) for world, status in zip(chosen.tolist(), told, strict=True)]
        if self._easel is None:
            self._easel = Easel(
                self._scenario,
                self._model,
                state,
                self._sensors,
                self._learners,
                reader,
                self._explored,
                self._share,
                self._whole,
                lowest,
            )
        return self._easel.draw(chosen, ready, [self._layout_of(world) for world in chosen.tolist()], overlays)

    def _layout_of(self, world: int) -> Layout:
        """Return which part of a world is shown."""
        if self._looked_at is not None:
            return self.layout
        center = self._reader.center(world)
        return self._whole if center is None else self._whole.centred(*center)

    def close(self) -> None:
        """Let go of the memory that pictures are drawn with; a later frame makes it anew."""
        self._easel = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_easel": None}
