"""Pictures of a world that a script steps: frames, figures in files, films."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.live.drawing.drawing import Drawing
from irsim_gym.live.pictures.output_files import FIGURES, with_suffix
from irsim_gym.live.pictures.reel import Reel
from irsim_gym.live.session.session import Session
from irsim_gym.scenario.reading.plot_overrides import drawn_with, saved_with
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.readings.marks import Mark
from irsim_gym.simulator.readings.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.rendering import Renderer
    from irsim_gym.rendering.scene.frame_layout import Layout, Limits
    from irsim_gym.rendering.scene.scene import Scene
    from irsim_gym.scenario import Scenario


class Camera:
    """Draws the simulation of a session. A renderer is created with the first picture of each simulation.

    Paths and trails come from the track, whether or not pictures are made at each step, and remain when bodies are
    added or removed.

    Args:
        session: The session to draw.
        drawing: Marks drawn over it.
    """

    def __init__(self, session: Session, drawing: Drawing) -> None:
        self._session, self._drawing = session, drawing
        self._drawn = session.simulation
        self._n_recorded = 0
        self._renderer: Renderer | None = None
        self._limits: Limits | None = None
        self._options: Mapping[str, object] = {}
        self._reel = Reel()
        self._is_kept = self._is_rendered = False
        self._kept_status = ""

    @property
    def _simulation(self) -> Simulation:
        return self._session.simulation

    def frame(self, status: str) -> Bytes:
        """Return a picture, uint8, shape ``(height, width, 3)``."""
        from irsim_gym.rendering.windows.picture import NotebookPicture

        return self._ready().frame(0, status).view(NotebookPicture)

    def show(self, status: str) -> Bytes:
        """Return a picture to be shown, with the marks for one picture.

        If frames are kept, the film has the last picture of a moment that was shown.
        """
        picture, drawing = self.frame(status), self._drawing
        if self._is_kept and (drawing.is_changed or drawing.has_old):
            self._reel.keep_again(picture, self._ready().scene(0, status))
            drawing.keep()
        drawing.shown()
        self._is_rendered = True
        return picture

    def leave(self) -> None:
        """Note that the world is about to leave the present moment."""
        self._catch_up()
        if len(self._drawing) and not self._is_rendered and self.is_sample:
            self._drawing.grow_old()
        self._is_kept = self._is_rendered = False

    @property
    def is_sample(self) -> bool:
        """Whether the present moment is a sample. Samples are ``sample_time`` apart, rounded to whole steps."""
        return int(self._simulation.state.step[0]) % self._simulation.scenario.world.steps_per_sample == 0

    def _catch_up(self) -> None:
        """Keep the present moment again if it was kept but not shown, and marks were drawn since."""
        if self._is_kept and not self._is_rendered and self._drawing.is_changed:
            self._keep(self._reel.keep_again, self._kept_status)

    def draw_with(self, options: Mapping[str, object]) -> None:
        """Draw all bodies with these keys of ``plot`` instead of their own, until the next call.

        Raises:
            ScenarioError: One of them has a bad value.
        """
        if options != self._options:
            drawn_with(self._simulation.scenario, options)
            self._options = dict(options)
            self.close()

    def show_part(self, limits: Limits | None) -> None:
        """Draw the part x_min, y_min, x_max, y_max [m] of the world from now on; None for that of the file."""
        self._limits = limits
        if self._renderer is not None:
            self._renderer.look_at(limits)

    def seen(self) -> Layout:
        """Return where the world is on the picture."""
        return self._ready().seen()

    def keep(self, status: str) -> None:
        """Keep the present moment for films, replays and sheets."""
        self._is_kept, self._kept_status = True, status
        self._keep(lambda frame, scene: self._reel.keep(frame, scene, self._simulation), status)

    def _keep(self, keep: Callable[[Bytes, Scene], None], status: str) -> None:
        """Pass the present moment to ``keep``, without marks that only wait to be rendered."""
        renderer = self._ready()
        renderer.lay_over(self._drawing.keep())
        keep(renderer.frame(0, status), renderer.scene(0, status))

    def clear(self) -> None:
        """Start another episode, with empty paths and trails."""
        self._n_recorded = 0
        self._drawing.begin()
        self._reel.begin()
        if self._renderer is not None:
            self._renderer.clear()

    def save_figure(self, path: Path, status: str, options: Mapping[str, object]) -> Path:
        """Write a picture to a file, in the format of its suffix or of the scenario; return its path.

        Args:
            path: The file.
            status: Status of the world.
            options: Keys of ``saved_figure``, instead of the scenario's.

        Raises:
            ScenarioError: One of them has a bad value.
            ValueError: Another suffix than those of figures.
        """
        scenario = saved_with(self._scenario(), options) if options else self._scenario()
        saved = scenario.world.plot.saved_figure
        target = with_suffix(path, FIGURES, saved.format)
        renderer = self._ready()
        if options:
            renderer = self._renderer_of(scenario, renderer.trails)
            renderer.lay_over(self._drawing.overlay())
        renderer.save(target, 0, status, dots_per_inch=saved.dpi)
        return target

    @property
    def reel(self) -> Reel:
        """The kept frames, with the present moment as it is drawn now."""
        self._catch_up()
        return self._reel

    @property
    def layout(self) -> Layout:
        """Position of the world in pictures, as the renderer has it."""
        return self._ready().layout

    def _ready(self) -> Renderer:
        if self._drawn is not self._simulation:
            self._drawn = self._simulation
            self.close()
        if self._renderer is None:
            self._renderer = self._renderer_of(self._scenario())
        self._tell(self._renderer.trails)
        self._renderer.lay_over(self._drawing.overlay())
        return self._renderer

    def _scenario(self) -> Scenario:
        """Return what is drawn, as it is to be drawn."""
        scenario = self._simulation.scenario
        return drawn_with(scenario, self._options) if self._options else scenario

    def _renderer_of(self, scenario: Scenario, trails: Trails | None = None) -> Renderer:
        """Return a renderer of the present moment."""
        from irsim_gym.rendering import Renderer

        seen = self._simulation
        parts = scenario, seen.model, seen.state, seen.sensors
        made = Renderer(*parts, trails=trails, explored=seen.explored, marks=self._marks)
        if self._limits is not None:
            made.look_at(self._limits)
        return made

    def _marks(self, world: int) -> tuple[Mark, ...]:
        """Return the marks of the simulation, and the beams that have a colour of their own."""
        return (*self._simulation.marks(world), *self._session.painted.marks(self._simulation))

    def _tell(self, trails: Trails) -> None:
        """Pass what the track noted since the last picture to the renderer."""
        if len(trails.bodies):
            for step, poses in self._session.track.since(self._n_recorded, self._simulation.parts.names):
                trails.record(np.zeros(1, np.int64), np.array([step]), poses[None])
        self._n_recorded = len(self._session.track)

    def close(self) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer, self._n_recorded = None, 0
