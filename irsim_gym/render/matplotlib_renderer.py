"""Draws worlds with matplotlib's Agg canvas: no display, no pyplot, no global state."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Bytes
from irsim_gym.render.renderer import WorldRenderer
from irsim_gym.render.scene import Scene
from irsim_gym.render.stage import Stage
from irsim_gym.world.group import Group
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class Renderer(WorldRenderer):
    """Pictures of a simulation's worlds, drawn by matplotlib, which also writes them to files.

    Args:
        scenario: What is simulated, for names, colours and plot options.
        model: The simulation's constants.
        state: Its present state.
        sensors: Its sensor groups.
        options: See ``WorldRenderer``.
    """

    def __init__(
        self, scenario: Scenario, model: WorldModel, state: WorldState, sensors: Sequence[Group] = (), **options: Any
    ) -> None:
        super().__init__(scenario, model, state, sensors, **options)
        plot = scenario.world.plot
        self._saved_figure = plot.saved_figure
        self._axis, self._show_title, self._titled = not plot.no_axis, bool(plot.show_title), plot.title is not None
        self._stage: Stage | None = None

    def frame(self, world: int = 0, status: str = "") -> Bytes:
        """Draw a world; see ``WorldRenderer``."""
        scene = self._reader.read(world, status)
        return self._ready(scene).draw(scene)

    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds, one after the other; see ``WorldRenderer``."""
        told = statuses or [""] * len(worlds)
        pictures = np.empty((len(worlds), self._whole.height, self._whole.width, 3), np.uint8)
        for picture, world, status in zip(pictures, worlds, told, strict=True):
            picture[:] = self.frame(world, status)
        return pictures

    def save(self, path: Path, world: int = 0, status: str = "", *, dots_per_inch: float = 100.0) -> None:
        """Write a picture of a world to a file, without empty margins if the scenario's ``bbox_inches`` is ``tight``.

        Args:
            path: File to write: ``.png``, ``.pdf``, ``.svg`` or another format that matplotlib writes.
            world: Its index.
            status: As for ``frame``.
            dots_per_inch: 100 for the size of a frame, 200 for twice as many pixels each way.
        """
        scene = self._reader.read(world, status)
        self._ready(scene).save(scene, path, dots_per_inch, self._saved_figure)

    def _ready(self, scene: Scene) -> Stage:
        if self._stage is None:
            self._stage = Stage(
                self._whole,
                titled=self._titled,
                axis=self._axis,
                show_title=self._show_title,
                clipped=scene.center is None,
            )
        self._stage.look_at(self._looked_at)
        return self._stage

    def close(self) -> None:
        """Let go of the figure; a later frame makes a new one."""
        self._stage = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_stage": None}
