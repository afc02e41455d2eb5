"""The figure: everything that is drawn, in the order in which it covers each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D, Bbox

from irsim_gym.arraytypes import Bytes
from irsim_gym.render import artists, scan_artists, theme
from irsim_gym.render.artists import clear_of_flags
from irsim_gym.render.backdrop import Backdrop
from irsim_gym.render.body_artists import Bodies, Headings, Impacts, MapImage, Touch
from irsim_gym.render.brush import Brush
from irsim_gym.render.card import Play, Ticks, add_frame, make_axes
from irsim_gym.render.files import whole_file
from irsim_gym.render.head import Head
from irsim_gym.render.image_artists import Fog
from irsim_gym.render.layout import DOTS_PER_INCH, POINTS_PER_INCH, Layout, Limits
from irsim_gym.render.lettering import Lettering
from irsim_gym.render.mark_artists import Marks, Words
from irsim_gym.render.path_artists import Trails
from irsim_gym.render.scene import BodyView, LabelView, MapView, Scene
from irsim_gym.render.styles import GROUND, TOP
from irsim_gym.scenario.plot_spec import SavedFigure
from irsim_gym.world.marks import Mark, TextMark

READABLE: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42}
"""Text stays text in files that can hold it, and its fonts come along where a format can embed them."""
HALF_A_WALL = 1.1
"""Half the width of a wall's line [point]: one along the border is drawn whole."""

NOWHERE = Bbox.from_extents(-2.0, -2.0, -1.0, -1.0)
"""A part of no canvas."""

Layer = tuple[float, int, Any, list[Any]]
"""What is drawn together: layer, rank within the layer, who draws it, and what."""


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
        self._dpi = dpi = DOTS_PER_INCH * layout.enlargement
        self._figure = Figure(figsize=(layout.width / dpi, layout.height / dpi), dpi=dpi, facecolor=theme.PAPER)
        self._canvas: Any = FigureCanvasAgg(self._figure)
        self._axes = axes = make_axes(self._figure, layout, axis)
        self._ticks = Ticks(self._figure, axes) if axis else None
        lettering = Lettering(self._figure)
        self._map = MapImage(axes)
        self._fixed, self._ghosts, self._moving = Bodies(axes, shadows=True), Bodies(axes), Bodies(axes)
        self._fog = Fog(axes)
        self._scans, self._hits = scan_artists.Scans(), scan_artists.Hits()
        self._fields, self._goals, self._trails = artists.Fields(), artists.Goals(), Trails()
        self._headings, self._impacts = Headings(), Impacts()
        self._labels = artists.Labels(lettering)
        self._marks, self._words = Marks(), Words(lettering)
        self._outcome = add_frame(axes, layout, linewidth=2.2, facecolor="none", animated=True)
        self._touch = Touch(layout.bounds)
        self._head = Head(lettering, layout, titled=titled) if show_title else None
        self._clipped = clipped
        self._whole, self._layout = layout, replace(layout, limits=(0.0, 0.0, 0.0, 0.0))
        self._chosen: Limits | None = None
        self._backdrop = Backdrop(self._canvas, self._draw_ground)
        self._brush: Brush | None = None

    def look_at(self, limits: Limits | None) -> None:
        """Show this part of the world [m] from now on, x_min, y_min, x_max, y_max; None for what the scene says."""
        self._chosen = limits

    def draw(self, scene: Scene) -> Bytes:
        """Return a picture of the scene, shape ``(height, width, 3)``, in memory of its own."""
        self._look(scene)
        brush = self._brush
        if brush is None:
            brush = self._brush = self._make_brush(self._canvas.get_renderer(), washes=True)
        fixed, slow, live = self._layers(scene)
        ground = scene.fixed, len(fixed), scene.map, self._layout
        self._backdrop.put(
            scene.world, ground, [layer[2:] for layer in slow], lambda part, views: self._play(brush, part, views)
        )
        self._finish(brush, scene, live)
        return _without_alpha(np.asarray(self._canvas.buffer_rgba()))

    def save(self, scene: Scene, path: Path, dots_per_inch: float, options: SavedFigure) -> None:
        """Write a picture of the scene to a file, in the format of its suffix.

        Args:
            scene: What it shows.
            path: A format that matplotlib writes, such as ``.png``, ``.pdf`` or ``.svg``; missing folders are made.
            dots_per_inch: 100 for the size of a frame, 200 for twice as many pixels each way.
            options: Margins and background.
        """
        self._look(scene)
        fixed, slow, live = self._layers(scene)

        def draw(renderer: RendererBase) -> None:
            brush = self._make_brush(renderer, washes=_is_opaque(renderer))
            x, y = self._figure.transFigure.transform((0.0, 0.0)).tolist()
            brush.corner = x, y
            self._draw_bodies(brush, fixed, scene.map)
            for *_, part, views in slow:
                self._play(brush, part, views)
            self._finish(brush, scene, live)

        def extent(renderer: RendererBase) -> Bbox:
            brush = self._make_brush(renderer)
            return Bbox.null() if self._head is None else self._head.extent(brush, scene)

        play = Play(draw, extent)
        self._figure.add_artist(play)
        self._axes.leaves_out_animated = True
        self._axes.card.set_facecolor("none" if options.transparent else theme.CARD)
        try:
            with whole_file(path) as part, matplotlib.rc_context(READABLE):
                self._figure.savefig(
                    part,
                    dpi=self._figure.dpi * dots_per_inch / DOTS_PER_INCH,
                    bbox_inches="tight" if options.bbox_inches == "tight" else None,
                    pad_inches=options.pad_inches,
                    facecolor="none" if options.transparent else options.facecolor or theme.PAPER,
                )
        finally:
            self._axes.card.set_facecolor(theme.CARD)
            self._axes.leaves_out_animated = False
            self._brush = None  # saving at another resolution leaves the canvas with another renderer
            play.remove()

    def count_artists(self) -> int:
        """Return how many artists the figure holds."""
        return len(self._figure.findobj())

    def _layers(self, scene: Scene) -> tuple[list[BodyView], list[Layer], list[Layer]]:
        """Return fixed bodies that nothing lies below, layers over them that seldom change, and those drawn anew."""
        layers = self._anew(scene)
        floor = min((order for order, *_ in layers), default=TOP)
        fixed = [view for view in scene.fixed if view.style.order <= floor]
        raised = [view for view in scene.fixed if view.style.order > floor]
        layers += [(order, 0, self._fixed, views) for order, views in by_layer(raised, lambda view: view.style.order)]
        layers.sort(key=lambda layer: layer[:2])
        count = next((k for k, layer in enumerate(layers) if layer[2] not in (self._fog, self._ghosts)), len(layers))
        colour = _tint(scene)
        touch: list[Layer] = [] if colour is None else [(floor, 0, self._touch, [colour])]
        return fixed, touch + layers[:count], layers[count:]

    def _anew(self, scene: Scene) -> list[Layer]:
        """Return the layers of all that is not fixed."""
        bodies = scene.fixed + scene.moving
        marks, words = self._drawn_over(scene)
        parts: tuple[tuple[Any, Sequence[Any], Callable[[Any], float]], ...] = (
            (self._fog, () if scene.fog is None else (scene.fog,), lambda view: GROUND),
            (self._ghosts, scene.ghosts, lambda view: view.style.order),
            (self._scans, scene.scans, lambda view: GROUND),
            (self._fields, scene.fields, lambda view: view.style.field_order),
            (self._goals, scene.goals, lambda view: view.style.goal_order),
            (self._trails, scene.trails, lambda view: view.style.trajectory_order),
            (self._moving, scene.moving, lambda view: view.style.order),
            (self._headings, [view for view in bodies if len(view.heading)], _heading_order),
            (self._hits, scene.scans, lambda view: TOP),
            (self._impacts, scene.struck, lambda view: TOP),
            (self._labels, self._visible(scene), lambda view: view.style.label_order),
            (self._marks, marks, _mark_order),
            (self._words, words, _mark_order),
        )
        return [
            (order, rank, part, chosen)
            for rank, (part, views, layer) in enumerate(parts, start=1)
            for order, chosen in by_layer(views, layer)
        ]

    def _visible(self, scene: Scene) -> list[LabelView]:
        """Return the labels that stand in the part of the world that is shown."""
        point = DOTS_PER_INCH / POINTS_PER_INCH * self._layout.enlargement / self._layout.scale
        labels = clear_of_flags(scene.labels, scene.goals, point)
        return [view for view in labels if self._layout.contains(view.x, view.y)]

    def _drawn_over(self, scene: Scene) -> tuple[list[Mark], list[TextMark]]:
        """Return the marks over the world, and apart from them the texts whose places are shown."""
        texts = [mark for mark in scene.overlay.marks if isinstance(mark, TextMark)]
        others: list[Mark] = [mark for mark in scene.overlay.marks if not isinstance(mark, TextMark)]
        return others, [mark for mark in texts if self._layout.contains(mark.x, mark.y)]

    def _play(self, brush: Brush, part: Any, views: Sequence[Any]) -> None:
        """Let a part draw its views, cut at the borders."""
        if part in (self._labels, self._words):
            brush.cut(self._figure.bbox)
        elif part in (self._fixed, self._moving, self._headings, self._impacts):
            brush.cut(brush.wide_box)
        else:
            brush.cut(brush.box)
        part.draw(brush, views)

    def _finish(self, brush: Brush, scene: Scene, live: Sequence[Layer]) -> None:
        """Draw what is drawn anew, and how the scene stands."""
        for *_, part, views in live:
            self._play(brush, part, views)
        colour = _tint(scene)
        if colour is not None:
            self._outcome.set(edgecolor=to_rgba(colour, 0.9))
            self._outcome.draw(brush.renderer)
        if self._head is not None:
            brush.cut(self._figure.bbox)
            self._head.draw(brush, scene)

    def _draw_ground(self, fixed: tuple[BodyView, ...], count: int, map_view: MapView | None, layout: Layout) -> None:
        """Draw an empty figure, the map and the first ``count`` fixed bodies on the canvas for frames."""
        self._canvas.draw()
        brush = self._make_brush(self._canvas.get_renderer(), washes=True)
        self._draw_bodies(brush, fixed[:count], map_view)

    def _draw_bodies(self, brush: Brush, fixed: Sequence[BodyView], map_view: MapView | None) -> None:
        """Draw the map and fixed bodies."""
        if map_view is not None:
            self._map.draw(brush.renderer, map_view)
        self._play(brush, self._fixed, fixed)

    def _look(self, scene: Scene) -> None:
        """Show the chosen part of the world, or that around the scene's centre."""
        layout = self._whole
        if self._chosen is not None:
            layout = layout.showing(self._chosen)
        elif scene.center is not None:
            layout = layout.centred(*scene.center)
        if layout == self._layout:
            return
        self._layout, self._brush = layout, None
        x_min, y_min, x_max, y_max = layout.limits
        self._axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max))
        self._map.zoom(layout.scale)
        if self._ticks is not None:
            self._ticks.update(layout)

    def _make_brush(self, renderer: RendererBase, *, washes: bool = False) -> Brush:
        """Return a brush for a canvas that the figure is being drawn on, which may have a resolution of its own."""
        canvas: Any = renderer
        keeps_strips = isinstance(renderer, RendererAgg) and self._figure.dpi == self._dpi
        to_canvas = Affine2D(self._axes.transData.get_matrix())
        area = Bbox(self._axes.bbox.get_points())
        if not self._clipped:
            return Brush(renderer, to_canvas, area, area, keeps_strips=keeps_strips, washes=washes)
        x_min, y_min, x_max, y_max = self._layout.bounds
        world = Bbox(to_canvas.transform([(x_min, y_min), (x_max, y_max)]))
        wall = HALF_A_WALL * float(canvas.points_to_pixels(1.0))
        boxes = (Bbox.intersection(world.padded(margin), area) or NOWHERE for margin in (0.0, wall))
        return Brush(renderer, to_canvas, *boxes, keeps_strips=keeps_strips, washes=washes)


def _is_opaque(renderer: Any) -> bool:
    """Return whether a canvas has pixels through which nothing is seen."""
    pixels = np.asarray(renderer.buffer_rgba()) if hasattr(renderer, "buffer_rgba") else None
    return pixels is not None and bool((pixels[..., 3] == 255).all())


def _tint(scene: Scene) -> str | None:
    """Return the colour of the scene's outcome; None while it is running."""
    return theme.status_colour(scene.status) if theme.ends_episode(scene.status) else None


def by_layer(views: Sequence[Any], layer: Callable[[Any], float]) -> Iterator[tuple[float, list[Any]]]:
    """Yield the views of each layer; within a layer they keep their order."""
    layers: dict[float, list[Any]] = {}
    for view in views:
        layers.setdefault(layer(view), []).append(view)
    yield from layers.items()


def _heading_order(view: BodyView) -> float:
    return view.style.order if view.style.arrow_order is None else view.style.arrow_order


def _mark_order(mark: Mark) -> float:
    return mark.layer


def _without_alpha(rgba: Bytes) -> Bytes:
    """Copy the colours of an opaque picture, four bytes at a time: each pixel's opacity is overwritten by the next."""
    rgb = np.empty((*rgba.shape[:2], 3), np.uint8)
    pixels = rgba.view(np.uint32).reshape(-1)
    np.ndarray((len(pixels) - 1,), np.uint32, rgb, strides=(3,))[:] = pixels[:-1]
    rgb[-1, -1] = rgba[-1, -1, :3]
    return rgb
