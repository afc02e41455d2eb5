"""Draws worlds with matplotlib's Agg canvas: no display, no pyplot, no global state."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags
from irsim_gym.render.layout import Layout, Limits, lay_out
from irsim_gym.render.reader import SceneReader
from irsim_gym.render.scene import Scene
from irsim_gym.render.stage import Stage
from irsim_gym.world.group import Group
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState
from irsim_gym.world.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class Renderer:
    """Pictures of a simulation's worlds. It only reads, and costs nothing until the first frame.

    Args:
        scenario: What is simulated, for names, colours and plot options.
        model: The simulation's constants.
        state: Its present state.
        sensors: Its sensor groups.
        learners: Bodies whose goals and trajectories are drawn unless the scenario says otherwise.
        size: Width and height of the frames in pixels, made even; None for ``figure_pixels`` where the
            scenario sets it, else for what the world's proportions ask for (600 x 600 for a square).
        trails: Where bodies have been, kept by who steps the worlds; by default paths and trails go through the poses
            at which frames were drawn.
        explored: Which cells of the world its robots have seen (``Simulation.explored``); what is left lies in fog.
    """

    def __init__(
        self,
        scenario: Scenario,
        model: WorldModel,
        state: WorldState,
        sensors: Sequence[Group] = (),
        *,
        learners: Collection[int] = (),
        size: tuple[int, int] | None = None,
        trails: Trails | None = None,
        explored: Flags | None = None,
    ) -> None:
        plot = scenario.world.plot
        self._reader = SceneReader(scenario, model, state, sensors, learners, trails, explored)
        self._saved_figure = plot.saved_figure
        self._axis, self._show_title, self._titled = not plot.no_axis, bool(plot.show_title), plot.title is not None
        self._layout = lay_out(
            model.bounds,
            size or plot.figure_pixels,
            axis=self._axis,
            title=self._show_title,
            tight=plot.tight,
        )
        self._stage: Stage | None = None
        self._looked_at: Limits | None = None

    @property
    def layout(self) -> Layout:
        """Where the world is on a frame; with a viewpoint, on one that shows the whole world."""
        return self._layout if self._looked_at is None else self._layout.showing(self._looked_at)

    def look_at(self, limits: Limits | None) -> None:
        """Show another part of the world from now on, in frames and in saved pictures.

        Args:
            limits: That part [m]: x_min, y_min, x_max, y_max; None for what the scenario says. Where its proportions
                are not those of the drawing area, more is shown on both sides.

        Raises:
            OptionError: The numbers bound no area.
        """
        if limits is not None:
            limits = self._layout.showing(limits).limits
        self._looked_at = limits
        if self._stage is not None:
            self._stage.look_at(limits)

    @property
    def trails(self) -> Trails:
        """Where bodies have been."""
        return self._reader.trails

    def scene(self, world: int = 0, status: str = "") -> Scene:
        """Return what a frame of the world would show, as data."""
        return self._reader.read(world, status)

    def frame(self, world: int = 0, status: str = "") -> Bytes:
        """Draw a world.

        Args:
            world: Its index.
            status: How its episode stands: ``running``, ``success``, ``collision``, ``timeout``, ``left_world``
                or any other text; the outcomes tint the frame. Read from the state when empty.

        Returns:
            The picture, uint8, shape ``(height, width, 3)``; the caller's own, never written again.
        """
        scene = self._reader.read(world, status)
        return self._ready(scene).draw(scene)

    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds.

        Args:
            worlds: Their indices.
            statuses: How their episodes stand, one for each, see ``frame``; none to read all from the state.

        Returns:
            The pictures, uint8, shape ``(n, height, width, 3)``.
        """
        told = statuses or [""] * len(worlds)
        pictures = np.empty((len(worlds), self._layout.height, self._layout.width, 3), np.uint8)
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
                self._layout,
                titled=self._titled,
                axis=self._axis,
                show_title=self._show_title,
                clipped=scene.center is None,
            )
            self._stage.look_at(self._looked_at)
        return self._stage

    def clear(self, world: int | None = None) -> None:
        """Forget the trails of one world, or of all; for the beginning of an episode."""
        self._reader.clear(world)

    def close(self) -> None:
        """Let go of the figure; a later frame makes a new one."""
        self._stage = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_stage": None}
