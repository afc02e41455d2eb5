"""What every renderer of a simulation's worlds is: what it reads, which part it shows, and what it promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from irsim_gym.arraytypes import Bytes, Flags
from irsim_gym.render.layout import Layout, Limits, lay_out
from irsim_gym.render.reader import SceneReader
from irsim_gym.render.scene import Scene
from irsim_gym.world.group import Group
from irsim_gym.world.marks import Overlay
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState
from irsim_gym.world.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.scenario.spec import Scenario


class WorldRenderer(ABC):
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
        shown = {"axis": not plot.no_axis, "title": bool(plot.show_title), "tight": plot.tight}
        self._whole = lay_out(model.bounds, size or plot.figure_pixels, **shown)
        self._looked_at: Limits | None = None

    @property
    def layout(self) -> Layout:
        """Where the world is on a frame; with a viewpoint, on one that shows the whole world."""
        return self._whole if self._looked_at is None else self._whole.showing(self._looked_at)

    @property
    def trails(self) -> Trails:
        """Where bodies have been."""
        return self._reader.trails

    def look_at(self, limits: Limits | None) -> None:
        """Show another part of the world from now on, in frames and in saved pictures.

        Args:
            limits: That part [m]: x_min, y_min, x_max, y_max; None for what the scenario says. Where its proportions
                are not those of the drawing area, more is shown on both sides.

        Raises:
            OptionError: The numbers bound no area.
        """
        self._looked_at = None if limits is None else self._whole.showing(limits).limits

    def lay_over(self, overlay: Overlay, world: int = 0) -> None:
        """Draw marks over a world from now on, in frames and in saved pictures."""
        self._reader.lay_over(world, overlay)

    def scene(self, world: int = 0, status: str = "") -> Scene:
        """Return what a frame of the world would show, as data."""
        return self._reader.read(world, status)

    def clear(self, world: int | None = None) -> None:
        """Forget the trails of one world, or of all; for the beginning of an episode."""
        self._reader.clear(world)

    @abstractmethod
    def frame(self, world: int = 0, status: str = "") -> Bytes:
        """Draw a world.

        Args:
            world: Its index.
            status: How its episode stands: ``running``, ``success``, ``collision``, ``timeout``, ``left_world``
                or any other text; the outcomes tint the frame. Read from the state when empty.

        Returns:
            The picture, uint8, shape ``(height, width, 3)``; the caller's own, never written again.
        """

    @abstractmethod
    def frames(self, worlds: Sequence[int], statuses: Sequence[str] = ()) -> Bytes:
        """Draw several worlds.

        Args:
            worlds: Their indices.
            statuses: How their episodes stand, one for each, see ``frame``; none to read all from the state.

        Returns:
            The pictures, uint8, shape ``(n, height, width, 3)``.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of what frames were drawn with; a later frame makes it anew."""
