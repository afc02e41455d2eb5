"""Pictures of a world that is run by hand: frames, figures in files, films."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.arraytypes import Bytes
from irsim_gym.engine import Simulation
from irsim_gym.live.drawing import Drawing
from irsim_gym.live.painted import PaintedBeams
from irsim_gym.live.reel import Reel
from irsim_gym.live.track import Track
from irsim_gym.scenario.looks import drawn_with, saved_with
from irsim_gym.world.marks import Overlay
from irsim_gym.world.trails import Trails

if TYPE_CHECKING:
    from irsim_gym.render import Renderer
    from irsim_gym.render.layout import Layout, Limits
    from irsim_gym.render.scene import Scene
    from irsim_gym.scenario import Scenario

FILMS = (".mp4", ".gif")
PAGES = (".html",)
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
FIGURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".eps", ".ps", ".tif", ".tiff", ".webp")


class Camera:
    """Draws one simulation. The renderer is made with the first picture.

    Paths and trails are those of the track, however seldom a picture is made, and stay when bodies come and go.

    Attributes:
        painted: Beams in colours of their own.
    """

    def __init__(self, simulation: Simulation, track: Track, drawing: Drawing) -> None:
        self._simulation, self._track, self._drawing = simulation, track, drawing
        self._told = 0
        self._renderer: Renderer | None = None
        self._limits: Limits | None = None
        self._options: Mapping[str, Any] = {}
        self.painted = PaintedBeams()
        self._painted_version = 0
        self._reel = Reel()
        self._is_kept = self._is_rendered = False
        self._kept_status = ""

    def look_at(self, simulation: Simulation) -> None:
        """Draw this simulation from now on; kept frames stay."""
        self._simulation = simulation
        self.close()

    def frame(self, status: str) -> Bytes:
        """Return a picture, uint8, shape ``(height, width, 3)``."""
        from irsim_gym.render.picture import Picture

        return self._ready().frame(0, status).view(Picture)

    def show(self, status: str) -> Bytes:
        """Return a picture that somebody is going to see: what was drawn over the world for one picture is in it.

        A film shows what was seen last of a moment.
        """
        picture, drawing = self.frame(status), self._drawing
        if self._is_kept and (drawing.is_changed or drawing.has_old):
            self._reel.keep_again(picture, self._scene(status))
            drawing.keep()
        drawing.shown()
        self._is_rendered = True
        return picture

    def leave(self) -> None:
        """Note that the world goes on from the present moment."""
        self._catch_up()
        if len(self._drawing) and not self._is_rendered and self._is_sample():
            self._drawing.grow_old()
        self._is_kept = self._is_rendered = False

    def _is_sample(self) -> bool:
        return int(self._simulation.state.step[0]) % self._simulation.scenario.world.steps_per_sample == 0

    def _catch_up(self) -> None:
        """Keep the present moment again if it was kept, nobody has seen it, and something was drawn since."""
        if self._is_kept and not self._is_rendered and self._drawing.is_changed:
            self._keep(self._reel.keep_again, self._kept_status)

    def draw_with(self, options: Mapping[str, Any]) -> None:
        """Draw all bodies with these keys of ``plot`` in place of their own, until other ones are given.

        Raises:
            ScenarioError: One of them has a bad value.
        """
        if options != self._options:
            drawn_with(self._simulation.scenario, options)
            self._options = dict(options)
            self.close()

    def show_part(self, limits: Limits | None) -> None:
        """Draw another part of the world from now on, x_min, y_min, x_max, y_max [m]; None for what the file says."""
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
        """Let somebody keep the present moment, without what only waits to be rendered."""
        renderer, overlay = self._ready(), self._drawing.keep()
        renderer.lay_over(overlay)
        keep(renderer.frame(0, status), self._scene(status, overlay))

    def _scene(self, status: str, overlay: Overlay | None = None) -> Scene:
        """Return the present moment as data, each scan in one piece; by default with all that was drawn over it."""
        ready = self._ready()
        if overlay is not None:
            ready.lay_over(overlay)
        if not self.painted.version:
            return ready.scene(0, status)
        from irsim_gym.render import Renderer

        seen = self._simulation
        parts = self._scenario(), seen.model, seen.state, seen.sensors
        whole = Renderer(*parts, trails=ready.trails, explored=seen.explored)
        whole.lay_over(self._drawing.overlay() if overlay is None else overlay)
        return whole.scene(0, status)

    def clear(self) -> None:
        """Begin another episode, with new paths and trails."""
        self._told = 0
        self._drawing.begin()
        self._reel.begin()
        if self._renderer is not None:
            self._renderer.clear()

    def save_figure(self, path: Path, status: str, options: Mapping[str, Any]) -> Path:
        """Write a picture to a file, in the format of its suffix or of the scenario; return the path.

        Args:
            path: The file.
            status: How the world stands.
            options: Keys of ``saved_figure`` in place of the scenario's.

        Raises:
            ScenarioError: One of them has a bad value.
            ValueError: Another suffix than those of figures.
        """
        scenario = saved_with(self._scenario(), options) if options else self._scenario()
        saved = scenario.world.plot.saved_figure
        target = _with_suffix(path, FIGURES, saved.format)
        renderer = self._renderer_with(scenario) if options else self._ready()
        renderer.save(target, 0, status, dots_per_inch=saved.dpi)
        return target

    def save_film(self, path: Path, fps: float) -> Path:
        """Write the kept frames to an mp4 or gif file and let go of them; return the path.

        Raises:
            ValueError: Another suffix than those of films, or no frames.
        """
        target = _with_suffix(path, FILMS, "mp4")
        self._catch_up()
        self._reel.save_film(target, fps)
        return target

    def save_html(self, path: Path) -> Path:
        """Write a page that plays all episodes that were kept; return its path.

        Raises:
            ValueError: Another suffix, or nothing was kept.
        """
        target = _with_suffix(path, PAGES, "html")
        self._catch_up()
        self._reel.save_html(target)
        return target

    def save_sheet(self, path: Path, count: int) -> Path:
        """Write one picture with some of the kept frames; return its path.

        Raises:
            ValueError: Another suffix, no frames, or fewer than two asked for.
        """
        target = _with_suffix(path, PICTURES, "png")
        self._catch_up()
        self._reel.save_sheet(target, count)
        return target

    def save_strobe(self, path: Path) -> Path:
        """Write one picture with the ways of the robots in the present episode; return its path.

        Raises:
            ValueError: Another suffix, or nothing was kept.
        """
        target = _with_suffix(path, FIGURES, "png")
        self._catch_up()
        self._reel.save_strobe(target, self._ready().layout)
        return target

    def _ready(self) -> Renderer:
        if self._painted_version != self.painted.version:
            self._painted_version = self.painted.version
            self.close()
        self.painted.follow()
        if self._renderer is None:
            from irsim_gym.render import Renderer

            seen = self._simulation
            parts = self._scenario(), seen.model, seen.state, self.painted.groups(seen)
            self._renderer = Renderer(*parts, explored=seen.explored)
            if self._limits is not None:
                self._renderer.look_at(self._limits)
        self._tell(self._renderer.trails)
        self._renderer.lay_over(self._drawing.overlay())
        return self._renderer

    def _scenario(self) -> Scenario:
        """Return what is drawn, as it is to be drawn."""
        scenario = self._simulation.scenario
        return drawn_with(scenario, self._options) if self._options else scenario

    def _renderer_with(self, scenario: Scenario) -> Renderer:
        """Return a renderer of the present moment with other plot options."""
        from irsim_gym.render import Renderer

        ready, seen = self._ready(), self._simulation
        parts = scenario, seen.model, seen.state, self.painted.groups(seen)
        made = Renderer(*parts, trails=ready.trails, explored=seen.explored)
        made.lay_over(self._drawing.overlay())
        if self._limits is not None:
            made.look_at(self._limits)
        return made

    def _tell(self, trails: Trails) -> None:
        """Add what the track noted since the last picture."""
        if len(trails.bodies):
            for step, poses in self._track.since(self._told, self._simulation.parts.names):
                trails.record(np.zeros(1, np.int64), np.array([step]), poses[None])
        self._told = len(self._track)

    def close(self) -> None:
        """Free the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer, self._told = None, 0


def target(path: str | Path | None, name: str) -> Path:
    """Return the file that is meant: by default one of this name.

    Raises:
        ValueError: It is a folder.
    """
    chosen = Path(name if path is None else path)
    if path is not None and chosen.is_dir():
        inside = chosen / name
        raise ValueError(
            f"'{path}' is a folder: name a file, such as '{inside}' in it or '{chosen.name or name}.png' beside it"
        )
    return chosen


def _with_suffix(path: Path, known: tuple[str, ...], default: str) -> Path:
    """Return the path with a suffix; a point in a name such as ``run-0.5`` begins none."""
    if not path.stem.strip(" .") or path.name.lower() in known:
        raise ValueError(f"a file needs a name before its suffix, such as 'world.{default}', got '{path.name}'")
    if path.suffix.lower() in known:
        return path
    if path.suffix and not path.suffix[1:].isdigit():
        raise ValueError(f"the file's name must end in {', '.join(known)}, got '{path.name}'")
    return path.with_name(f"{path.name}.{default}")
