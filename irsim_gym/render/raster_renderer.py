"""Draws worlds with kernels of our own, without matplotlib: for pictures as observations and for many films."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Bytes, Flags
from irsim_gym.render.easel import Easel, Share
from irsim_gym.render.layout import Layout, Limits, lay_out
from irsim_gym.render.reader import SceneReader
from irsim_gym.render.scene import Scene
from irsim_gym.world.group import Group
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState
from irsim_gym.world.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class RasterRenderer:
    """Pictures of a simulation's worlds, drawn by kernels. It only reads, and costs nothing until the first frame.

    Args:
        scenario: What is simulated, for names, colours and plot options.
        model: The simulation's constants.
        state: Its present state.
        sensors: Its sensor groups.
        learners: Bodies whose goals and trajectories are drawn unless the scenario says otherwise.
        size: Width and height of the frames in pixels, made even; None for what the scenario asks for.
        trails: Where bodies have been, kept by who steps the worlds; None for poses at which frames were drawn.
        explored: Which cells of the world its robots have seen; what is left lies in fog.
        share: Who divides the work of ``frames`` among threads; None for nobody. Pictures do not depend on it.
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
        share: Share | None = None,
    ) -> None:
        plot = scenario.world.plot
        self._reader = SceneReader(scenario, model, state, sensors, learners, trails, explored)
        self._scenario, self._model, self._state, self._sensors = scenario, model, state, sensors
        self._learners, self._explored, self._share = learners, explored, share
        shown = {"axis": not plot.no_axis, "title": bool(plot.show_title), "tight": plot.tight}
        self._layout = lay_out(model.bounds, size or plot.figure_pixels, **shown)
        self._looked_at: Limits | None = None
        self._easel: Easel | None = None

    @property
    def layout(self) -> Layout:
        """Where the world is on a frame; with a viewpoint, on one that shows the whole world."""
        return self._layout if self._looked_at is None else self._layout.showing(self._looked_at)

    def look_at(self, limits: Limits | None) -> None:
        """Show another part of the world [m] from now on: x_min, y_min, x_max, y_max; None for what the scenario says.

        Raises:
            OptionError: The numbers bound no area.
        """
        if limits is not None:
            limits = self._layout.showing(limits).limits
        self._looked_at = limits

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
            status: How its episode stands; read from the state when empty.

        Returns:
            The picture, uint8, shape ``(height, width, 3)``; the caller's own, never written again.
        """
        picture: Bytes = self.frames([world], [status])[0]
        return picture

    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds.

        Args:
            worlds: Their indices.
            statuses: How their episodes stand, one for each; none to read all from the state.

        Returns:
            The pictures, uint8, shape ``(n, height, width, 3)``.
        """
        chosen, told = np.array(worlds, np.int64), list(statuses) or [""] * len(worlds)
        if len(told) != len(chosen):
            raise ValueError(f"as many statuses as worlds: {len(chosen)}, got {len(told)}")
        state, reader = self._state, self._reader
        for world in dict.fromkeys(chosen.tolist()):
            self.trails.record(np.array([world]), state.step[[world]], state.pose[[world]])
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
                self._layout,
            )
        return self._easel.draw(chosen, ready, [self._layout_of(world) for world in chosen.tolist()])

    def _layout_of(self, world: int) -> Layout:
        """Return which part of a world is shown."""
        if self._looked_at is not None:
            return self.layout
        center = self._reader.center(world)
        return self._layout if center is None else self._layout.centred(*center)

    def clear(self, world: int | None = None) -> None:
        """Forget the trails of one world, or of all; for the beginning of an episode."""
        self._reader.clear(world)

    def close(self) -> None:
        """Let go of the memory that pictures are drawn with; a later frame makes it anew."""
        self._easel = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_easel": None}
