"""Matplotlib artists of what range sensors see: beams, the points that they hit, and how fast these go."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes
from irsim_gym.render.scene import ScanView
from irsim_gym.render.styles import VelocityStyle


class Scans:
    """For each scan the area seen and the beams, or beams in the colours of their radial velocity."""

    def __init__(self, axes: Axes) -> None:
        self._area = PathPatch(Path([(0.0, 0.0)]), linewidth=0.0, animated=True)
        self._beams = PathPatch(Path([(0.0, 0.0)]), fill=False, animated=True)
        self._coloured: Any = LineCollection([], capstyle="butt", animated=True)
        axes.add_patch(self._area)
        axes.add_patch(self._beams)
        axes.add_collection(self._coloured, autolim=False)
        self._views: Sequence[ScanView] = ()

    def update(self, views: Sequence[ScanView]) -> None:
        """Show these scans."""
        self._views = views

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave, one scan after another: collections of few large paths are slow."""
        for view in self._views:
            velocity = view.style.velocity
            if velocity is not None and velocity.coloured:
                self._draw_velocities(renderer, view, velocity)
                continue
            colour, alpha = view.style.colour, view.style.alpha
            self._area.set(path=shapes.seen_path(view), facecolor=to_rgba(colour, min(0.22 * alpha, 1.0)))
            self._area.draw(renderer)
            self._draw_beams(renderer, shapes.beam_path(view), to_rgba(colour, min(0.9 * alpha, 1.0)), 0.45)

    def _draw_velocities(self, renderer: RendererBase, view: ScanView, style: VelocityStyle) -> None:
        path = shapes.rays_path(view.origin, view.ends[~view.valid])
        self._draw_beams(renderer, path, to_rgba(style.free_colour, style.free_alpha), style.free_width)
        ends = view.ends[view.valid]
        self._coloured.set_segments(np.stack([np.broadcast_to(view.origin, ends.shape), ends], axis=1))
        self._coloured.set_color(velocity_colours(view, style, view.style.alpha))
        self._coloured.set_linewidths([style.width])
        self._coloured.draw(renderer)

    def _draw_beams(self, renderer: RendererBase, path: Path, colour: Any, width: float) -> None:
        self._beams.set(path=path, edgecolor=colour, linewidth=width)
        self._beams.draw(renderer)


class Hits:
    """The points where beams end on something."""

    def __init__(self, axes: Axes) -> None:
        self._dots = Line2D([], [], linestyle="none", marker="o", markersize=2.6, markeredgewidth=0.0, animated=True)
        axes.add_line(self._dots)
        self._marks: Any = axes.scatter([], [], animated=True)
        self._views: Sequence[ScanView] = ()

    def update(self, views: Sequence[ScanView]) -> None:
        """Show the hits of these scans."""
        self._views = views

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for view in self._views:
            if view.style.velocity is not None:
                self._draw_marks(renderer, view, view.style.velocity)
                continue
            ends = view.ends[view.hits]
            self._dots.set_data(ends[:, 0], ends[:, 1])
            self._dots.set_color(to_rgba(view.style.colour, min(3.0 * view.style.alpha, 1.0)))
            self._dots.draw(renderer)

    def _draw_marks(self, renderer: RendererBase, view: ScanView, style: VelocityStyle) -> None:
        if style.mark_size > 0.0:
            self._marks.set_offsets(view.ends[view.valid])
            self._marks.set_sizes([style.mark_size])
            self._marks.set_facecolor(velocity_colours(view, style, 1.0))
            self._marks.set_edgecolor(style.mark_edge_colour)
            self._marks.set_linewidths([style.mark_edge_width])
            self._marks.draw(renderer)


def velocity_colours(view: ScanView, style: VelocityStyle, alpha: float) -> Floats:
    """Return the colours of the beams that hit: the sign's, mixed with that of rest below the full speed.

    Returns:
        Red, green, blue, opacity, shape ``(n_valid, 4)``.
    """
    speeds = view.speeds[view.valid]
    share = np.minimum(np.abs(speeds) / style.full_speed, 1.0)[:, None]
    ends = np.where(speeds[:, None] >= 0.0, to_rgba(style.away_colour), to_rgba(style.nearer_colour))
    colours: Floats = (1.0 - share) * np.array(to_rgba(style.rest_colour)) + share * ends
    colours[:, 3] = alpha
    return colours
