"""Renders frames of a simulation's worlds with compiled kernels, and writes figures of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Flags
from irsim_gym.rendering.frames.frame_painter import FramePainter, Share
from irsim_gym.rendering.looks.styles import TOP
from irsim_gym.rendering.scene.frame_layout import Layout, Limits, lay_out
from irsim_gym.rendering.scene.reader import DrawnSimulation, SceneReader
from irsim_gym.rendering.scene.scene import Scene
from irsim_gym.simulator.readings.marks import Mark, Overlay
from irsim_gym.simulator.readings.trails import Trails
from irsim_gym.simulator.world.group import Group
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State

if TYPE_CHECKING:
    from irsim_gym.scenario.specs.spec import Scenario


def no_marks(world: int) -> tuple[Mark, ...]:
    """Return the marks over a world that has none; unlike a lambda, this can be pickled."""
    return ()


class Renderer:
    """Draws pictures of a simulation's worlds. It only reads, and costs nothing before the first frame.

    Args:
        scenario: The scenario, for names, colours and plot options.
        model: Constants of the simulation.
        state: Its present state.
        sensors: Its sensor groups.
        learners: Bodies whose goals and trajectories are drawn by default.
        size: Width and height of the frames in pixels, rounded to even numbers; None for the scenario's
            ``figure_pixels``, or else for a size by the proportions of the world (600 x 600 for a square).
        trails: Past poses of bodies, recorded by the caller at each step; by default, the poses at which frames were
            drawn.
        explored: Cells of the world that its robots have seen (``Simulation.explored``); the others lie in fog.
        marks: Returns marks over a world (``Simulation.marks``), which every frame and figure shows.
        share: Divides the work of ``frames`` among threads, like ``Shards.run`` of the engine; None for one thread.
            Frames do not depend on it.
    """

    def __init__(
        self,
        scenario: Scenario,
        model: Model,
        state: State,
        sensors: Sequence[Group] = (),
        *,
        learners: Collection[int] = (),
        size: tuple[int, int] | None = None,
        trails: Trails | None = None,
        explored: Flags | None = None,
        marks: Callable[[int], tuple[Mark, ...]] = no_marks,
        share: Share | None = None,
    ) -> None:
        plot = scenario.world.plot
        self._drawn = DrawnSimulation(scenario, model, state, sensors, learners, explored, marks)
        self._reader = SceneReader(self._drawn, trails)
        shown = {"axis": not plot.no_axis, "title": bool(plot.show_title), "tight": plot.tight}
        self._whole = lay_out(model.bounds, size or plot.figure_pixels, **shown)
        self._looked_at: Limits | None = None
        self._share = share
        self._painter: FramePainter | None = None

    @property
    def layout(self) -> Layout:
        """The layout of a frame; with a viewpoint, that of a frame that shows the whole world."""
        return self._whole if self._looked_at is None else self._whole.showing(self._looked_at)

    @property
    def trails(self) -> Trails:
        """Past poses of bodies."""
        return self._reader.trails

    def seen(self, world: int = 0) -> Layout:
        """Return the layout of a frame that is drawn now, which follows a viewpoint."""
        center = None if self._looked_at is not None else self._reader.center(world)
        return self.layout if center is None else self._whole.centred(*center)

    def look_at(self, limits: Limits | None) -> None:
        """Set the part of the world that later frames and figures show.

        Args:
            limits: The part [m]: x_min, y_min, x_max, y_max, enlarged to the proportions of the drawing area; None for
                the default of the scenario.

        Raises:
            OptionError: If the limits are not finite or not increasing.
        """
        self._looked_at = None if limits is None else self._whole.showing(limits).limits

    def lay_over(self, overlay: Overlay, world: int = 0) -> None:
        """Set the marks over a world in later frames and figures."""
        self._reader.lay_over(world, overlay)

    def scene(self, world: int = 0, status: str = "") -> Scene:
        """Return the content of a frame of the world, as data."""
        return self._reader.read(world, status)

    def clear(self, world: int | None = None) -> None:
        """Clear the trails of one world, or of all worlds, at the start of an episode."""
        self._reader.clear(world)

    def frame(self, world: int = 0, status: str = "") -> Bytes:
        """Draw a world.

        Args:
            world: Index of the world.
            status: Status of its episode: ``running``, ``success``, ``collision``, ``timeout``, ``left_world`` or any
                other text; outcomes tint the frame. Empty to derive it from the state.

        Returns:
            The picture, uint8, shape ``(height, width, 3)``, a fresh array.
        """
        picture: Bytes = self.frames([world], [status])[0]
        return picture

    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds.

        Args:
            worlds: Indices of the worlds.
            statuses: Status of each episode, see ``frame``; empty to derive all from the state.

        Returns:
            The pictures, uint8, shape ``(n, height, width, 3)``.

        Raises:
            ValueError: If the numbers of statuses and worlds differ.
        """
        chosen, texts = np.array(worlds, np.int64), list(statuses) or [""] * len(worlds)
        if len(texts) != len(chosen):
            raise ValueError(f"as many statuses as worlds: {len(chosen)}, got {len(texts)}")
        state, reader = self._drawn.state, self._reader
        for world in dict.fromkeys(chosen.tolist()):
            self.trails.record(np.array([world]), state.step[[world]], state.pose[[world]])
        overlays = [reader.overlay(world) for world in chosen.tolist()]
        ready = [status or reader.status(world) for world, status in zip(chosen.tolist(), texts, strict=True)]
        painter = self._painter_for(min((mark.layer for overlay in overlays for mark in overlay.marks), default=TOP))
        return painter.draw(chosen, ready, [self.seen(world) for world in chosen.tolist()], overlays)

    def save(self, path: Path, world: int = 0, status: str = "", *, dots_per_inch: float = 100.0) -> None:
        """Write a figure of a world to a file, without empty margins if the scenario's ``bbox_inches`` is ``tight``.

        Args:
            path: File to write: ``.png``, ``.pdf``, ``.svg`` or another format that matplotlib writes.
            world: Index of the world.
            status: Status of its episode, as for ``frame``.
            dots_per_inch: 100 for the size of a frame, 200 for twice the width and height in pixels.
        """
        from irsim_gym.rendering.figures.figure import Frame, save_figure

        plot, scene = self._drawn.scenario.world.plot, self._reader.read(world, status)
        around = Frame(plot.title is not None, not plot.no_axis, bool(plot.show_title))
        save_figure(scene, self.seen(world), around, path, plot.saved_figure, dots_per_inch)

    def close(self) -> None:
        """Free the memory for drawing frames; a later frame allocates it again."""
        self._painter = None

    def _painter_for(self, lowest: float) -> FramePainter:
        """Return the painter, or a new one if a mark lies below the ground of the present one."""
        if self._painter is None or lowest < self._painter.plan.covered:
            self._painter = FramePainter(self._drawn, self._reader, self._share, self._whole, lowest)
        return self._painter

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_painter": None}
