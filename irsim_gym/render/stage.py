"""The figure: everything that is drawn, in the order in which it covers each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from irsim_gym.arraytypes import Bytes
from irsim_gym.render import artists, scan_artists, theme
from irsim_gym.render.artists import clear_of_flags
from irsim_gym.render.body_artists import Bodies, Headings, Impacts, MapImage
from irsim_gym.render.card import Play, Ticks, add_frame, make_axes
from irsim_gym.render.head import Head
from irsim_gym.render.image_artists import Fog
from irsim_gym.render.layout import Layout, Limits
from irsim_gym.render.scene import BodyView, LabelView, Scene
from irsim_gym.render.styles import GROUND, TOP

DOTS_PER_INCH = 100.0
POINTS_PER_INCH = 72.0
REMEMBERED_BACKDROPS = 8
HALF_A_WALL = 1.1
"""Half the width of a wall's line [point]: one along the border is drawn whole."""


class Stage:
    """A figure that shows scenes of one world size; everything on it is made once.

    What does not move is drawn into a backdrop for each world, which is drawn again only when it changes.

    Args:
        layout: Where things stand on it.
        titled: The heading is a title alone.
        axis: Draw ticks and the world's frame.
        show_title: Draw heading and status line.
        clipped: Cut what reaches beyond the world's rectangle.
    """

    def __init__(
        self, layout: Layout, *, titled: bool = False, axis: bool = True, show_title: bool = True, clipped: bool = True
    ) -> None:
        dpi = DOTS_PER_INCH * layout.enlargement
        self._figure = Figure(figsize=(layout.width / dpi, layout.height / dpi), dpi=dpi, facecolor=theme.PAPER)
        self._canvas: Any = FigureCanvasAgg(self._figure)
        self._axes = axes = make_axes(self._figure, layout, axis)
        self._ticks = Ticks(self._figure, axes) if axis else None
        self._map = MapImage(axes)
        self._fixed = Bodies(axes, shadows=True)
        self._fog = Fog(axes)
        self._scans = scan_artists.Scans(axes)
        self._fields = artists.Fields(axes)
        self._ghosts = Bodies(axes)
        self._goals = artists.Goals(axes)
        self._trails = artists.Trails(axes, dpi / POINTS_PER_INCH)
        self._moving = Bodies(axes)
        self._headings = Headings(axes)
        self._hits = scan_artists.Hits(axes)
        self._impacts = Impacts(axes)
        self._labels = artists.Labels(axes)
        self._outcome = add_frame(axes, layout, linewidth=2.2, animated=True)
        self._head = Head(self._figure, layout, titled=titled) if show_title else None
        self._clipped = clipped
        self._whole, self._layout = layout, replace(layout, limits=(0.0, 0.0, 0.0, 0.0))
        self._chosen: Limits | None = None
        self._backdrops: dict[int, tuple[tuple[Any, ...], Any]] = {}

    def look_at(self, limits: Limits | None) -> None:
        """Show this part of the world [m] from now on, x_min, y_min, x_max, y_max; None for what the scene says."""
        self._chosen = limits

    def draw(self, scene: Scene) -> Bytes:
        """Return a picture of the scene, shape ``(height, width, 3)``, in memory of its own."""
        self._look(scene)
        live, fixed, floor = self._layers(scene)
        self._canvas.restore_region(self._backdrop(scene, fixed, floor))
        self._play(self._canvas.get_renderer(), scene, live)
        return _without_alpha(np.asarray(self._canvas.buffer_rgba()))

    def save(self, scene: Scene, path: Path, dots_per_inch: float, *, cut: bool = False) -> None:
        """Write a picture of the scene to a file, in the format of its suffix.

        Args:
            scene: What it shows.
            path: A format that matplotlib writes, such as ``.png``, ``.pdf`` or ``.svg``; missing folders are made.
            dots_per_inch: 100 for the size of a frame, 200 for twice as many pixels each way.
            cut: Leave out the empty margins.
        """
        self._look(scene)
        live, fixed, _ = self._layers(scene)

        def draw(renderer: RendererBase) -> None:
            self._cut_at_borders()
            self._ground(renderer, scene, fixed)
            self._play(renderer, scene, live)

        play = Play(draw)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._figure.add_artist(play)
        self._axes.leaves_out_animated = True
        try:
            dpi = self._figure.dpi * dots_per_inch / DOTS_PER_INCH
            self._figure.savefig(path, dpi=dpi, bbox_inches="tight" if cut else None)
        finally:
            self._axes.leaves_out_animated = False
            play.remove()
            self._cut_at_borders()

    def _layers(self, scene: Scene) -> tuple[list[tuple[float, int, Any, list[Any]]], list[BodyView], float]:
        """Return what is drawn anew, the fixed bodies below all of it, and its lowest layer."""
        live = self._live(scene)
        floor = min((order for order, *_ in live), default=TOP)
        fixed = [view for view in scene.fixed if view.style.order <= floor]
        raised = [view for view in scene.fixed if view.style.order > floor]
        live += [(order, 0, self._fixed, views) for order, views in by_layer(raised, lambda view: view.style.order)]
        return sorted(live, key=lambda item: item[:2]), fixed, floor

    def _play(self, renderer: RendererBase, scene: Scene, live: list[tuple[float, int, Any, list[Any]]]) -> None:
        """Draw what is drawn anew, and how the scene stands."""
        colour = theme.status_colour(scene.status) if theme.ends_episode(scene.status) else None
        if colour is not None:
            self._outcome.set(facecolor=to_rgba(colour, 0.07), edgecolor="none")
            self._outcome.draw(renderer)
        for _, _, part, views in live:
            part.update(views)
            part.draw(renderer)
        if colour is not None:
            self._outcome.set(facecolor="none", edgecolor=to_rgba(colour, 0.9))
            self._outcome.draw(renderer)
        if self._head is not None:
            self._head.draw(renderer, scene)

    def _ground(self, renderer: RendererBase, scene: Scene, fixed: Sequence[BodyView]) -> None:
        """Draw the map and the bodies that nothing lies below."""
        if scene.map is not None:
            self._map.draw(renderer, scene.map)
        self._fixed.update(fixed)
        self._fixed.draw(renderer)

    def count_artists(self) -> int:
        """Return how many artists the figure holds."""
        return len(self._figure.findobj())

    def _live(self, scene: Scene) -> list[tuple[float, int, Any, list[Any]]]:
        """Return what is drawn anew: layer, rank within the layer, artist, views."""
        bodies = scene.fixed + scene.moving
        parts: tuple[tuple[Any, Sequence[Any], Callable[[Any], float]], ...] = (
            (self._fog, () if scene.fog is None else (scene.fog,), lambda view: GROUND),
            (self._scans, scene.scans, lambda view: GROUND),
            (self._fields, scene.fields, lambda view: view.style.field_order),
            (self._ghosts, scene.ghosts, lambda view: view.style.order),
            (self._goals, scene.goals, lambda view: view.style.goal_order),
            (self._trails, scene.trails, lambda view: view.style.trajectory_order),
            (self._moving, scene.moving, lambda view: view.style.order),
            (self._headings, [view for view in bodies if len(view.heading)], _heading_order),
            (self._hits, scene.scans, lambda view: TOP),
            (self._impacts, scene.struck, lambda view: TOP),
            (self._labels, self._visible(scene), lambda view: view.style.label_order),
        )
        return [
            (order, rank, part, chosen)
            for rank, (part, views, layer) in enumerate(parts, start=1)
            for order, chosen in by_layer(views, layer)
        ]

    def _visible(self, scene: Scene) -> list[LabelView]:
        """Return the labels that stand in the part of the world that is shown."""
        x_min, y_min, x_max, y_max = self._layout.limits
        point = DOTS_PER_INCH / POINTS_PER_INCH * self._layout.enlargement / self._layout.scale
        labels = [clear_of_flags(view, scene.goals, point) for view in scene.labels]
        return [view for view in labels if x_min <= view.x <= x_max and y_min <= view.y <= y_max]

    def _look(self, scene: Scene) -> None:
        """Show the chosen part of the world, or that around the scene's centre."""
        layout = self._whole
        if self._chosen is not None:
            layout = layout.showing(self._chosen)
        elif scene.center is not None:
            layout = layout.centred(*scene.center)
        if layout == self._layout:
            return
        self._layout = layout
        x_min, y_min, x_max, y_max = layout.limits
        self._axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max))
        self._map.zoom(layout.scale)
        self._trails.zoom(layout.scale)
        self._cut_at_borders()
        if self._ticks is not None:
            self._ticks.update(layout)

    def _cut_at_borders(self) -> None:
        """Cut what is drawn at the drawing area's edges and, where that is wanted, at the world's."""
        if not self._clipped:
            return
        wall = HALF_A_WALL * self._figure.dpi / POINTS_PER_INCH
        _clip((self._scans, self._hits, self._fields, self._ghosts, self._trails), self._world_box(0.0))
        _clip((self._fixed, self._moving, self._headings, self._impacts), self._world_box(wall))

    def _world_box(self, margin: float) -> Bbox:
        """Return the part of the world that is shown, wider by a margin [pixel], where it is on the canvas."""
        x_min, y_min, x_max, y_max = self._layout.bounds
        world = Bbox(self._axes.transData.transform([(x_min, y_min), (x_max, y_max)]))
        shown = Bbox.intersection(world.padded(margin), self._axes.bbox)
        return Bbox.null() if shown is None else shown

    def _backdrop(self, scene: Scene, fixed: Sequence[BodyView], floor: float) -> Any:
        """Return the canvas with all that does not move in the scene's world and that nothing lies below."""
        known = self._backdrops.pop(scene.world, None)
        key = (scene.fixed, scene.map, floor, self._layout)
        if known is None or known[0][0] is not scene.fixed or known[0][1:] != key[1:]:
            self._canvas.draw()
            self._ground(self._canvas.get_renderer(), scene, fixed)
            known = key, self._canvas.copy_from_bbox(self._figure.bbox)
            if len(self._backdrops) >= REMEMBERED_BACKDROPS:
                self._backdrops.pop(next(iter(self._backdrops)))
        self._backdrops[scene.world] = known
        return known[1]


def by_layer(views: Sequence[Any], layer: Callable[[Any], float]) -> Iterator[tuple[float, list[Any]]]:
    """Yield the views of each layer; within a layer they keep their order."""
    layers: dict[float, list[Any]] = {}
    for view in views:
        layers.setdefault(layer(view), []).append(view)
    yield from layers.items()


def _heading_order(view: BodyView) -> float:
    return view.style.order if view.style.arrow_order is None else view.style.arrow_order


def _clip(parts: Sequence[Any], box: Bbox) -> None:
    """Cut the artists of some parts at a box."""
    for part in parts:
        held = [item for value in vars(part).values() for item in (value if isinstance(value, list) else [value])]
        for artist in held:
            if isinstance(artist, Artist) and not isinstance(artist, Axes):
                artist.set_clip_box(box)


def _without_alpha(rgba: Bytes) -> Bytes:
    """Copy the colours of an opaque picture; channel by channel, which is four times as fast as one slice."""
    rgb = np.empty((*rgba.shape[:2], 3), np.uint8)
    for channel in range(3):
        rgb[..., channel] = rgba[..., channel]
    return rgb
