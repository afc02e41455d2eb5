"""Matplotlib artists of one axes, made once and given new data for every frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.text import Text

from irsim_gym.arraytypes import Floats
from irsim_gym.render import shapes, theme
from irsim_gym.render.patches import Colour, empty_collection, paint
from irsim_gym.render.scene import FieldView, GoalView, LabelView, TrailView

FAINTEST = 0.12
FLAG = (6.5, 10.5)
"""Width and height of a goal's flag, from its foot [point]."""
POLE = Path([(0.0, 0.0), (0.0, 2.0)])
PENNANT = Path([(0.0, 2.0), (1.25, 1.55), (0.0, 1.1), (0.0, 2.0)], closed=True)


class Trails:
    """Trajectories: thin ones fade towards their beginning, those with a width are one band."""

    def __init__(self, axes: Axes, pixels_per_point: float) -> None:
        self._lines: Any = LineCollection([], capstyle="butt", joinstyle="round", animated=True)
        axes.add_collection(self._lines, autolim=False)
        self._pixels_per_point = pixels_per_point
        self._points_per_metre = self._apart = 1.0

    def zoom(self, pixels_per_metre: float) -> None:
        """Draw at this scale."""
        self._points_per_metre = pixels_per_metre / self._pixels_per_point
        self._apart = 1.5 / pixels_per_metre

    def update(self, views: Sequence[TrailView]) -> None:
        """Show these trajectories."""
        pieces: list[Floats] = []
        colours: list[Colour] = []
        widths: list[float] = []
        styles: list[str] = []
        for view in views:
            points, width = shapes.thinned(view.points, self._apart), view.style.trajectory_width
            parts = shapes.pieces(points) if width is None else [points][: len(points) > 1]
            strengths = np.linspace(1.0 if width else FAINTEST, 1.0, len(parts)) * view.style.trajectory_alpha
            pieces += parts
            colours += [to_rgba(view.style.trajectory_colour, strength) for strength in strengths]
            widths += [1.9 if width is None else max(width * self._points_per_metre, 0.3)] * len(parts)
            styles += [view.style.trajectory_style] * len(parts)
        self._lines.set_segments(pieces)
        self._lines.set_color(colours)
        self._lines.set_linewidths(widths or [1.0])
        self._lines.set_linestyles(styles or ["solid"])

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._lines.draw(renderer)


class Goals:
    """For each goal the circle of its tolerance, a flag, and dots for the goals after it."""

    def __init__(self, axes: Axes) -> None:
        self._circles = empty_collection(axes)
        self._circles.set_linewidths([1.1])
        self._later = Line2D([], [], linestyle="none", marker="o", animated=True)
        self._flags = [
            Line2D([], [], linestyle="none", marker=shape, markersize=20.0, animated=True) for shape in (POLE, PENNANT)
        ]
        self._flags[0].set_markeredgewidth(1.3)
        self._flags[1].set_markeredgewidth(0.0)
        for line in (self._later, *self._flags):
            axes.add_line(line)
        self._views: Sequence[GoalView] = ()
        self._later.set_markersize(4.5)

    def update(self, views: Sequence[GoalView]) -> None:
        """Show these goals."""
        self._views = views
        self._circles.set_paths([shapes.circle_path(view.x, view.y, view.tolerance) for view in views])
        colours = [to_rgba(view.style.goal_colour, view.style.goal_alpha) for view in views]
        paint(
            self._circles,
            [_faded(colour, 0.30 if view.arrived else 0.14) for colour, view in zip(colours, views, strict=True)],
            [_faded(colour, 0.9) for colour in colours],
        )

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave; flags one after another, because each has its colour."""
        self._circles.draw(renderer)
        for view in self._views:
            colour = to_rgba(view.style.goal_colour, view.style.goal_alpha)
            if len(view.later):
                self._later.set_data(view.later[:, 0], view.later[:, 1])
                self._later.set_color(_faded(colour, 0.45))
                self._later.draw(renderer)
            for line in self._flags:
                line.set_data([view.x], [view.y])
                line.set_color(colour)
                line.draw(renderer)


class Fields:
    """Fields of view: sectors of a disc, or a whole one."""

    def __init__(self, axes: Axes) -> None:
        self._sectors = empty_collection(axes)
        self._sectors.set_linewidths([0.9])

    def update(self, views: Sequence[FieldView]) -> None:
        """Show these fields of view."""
        self._sectors.set_paths([shapes.sector_path(view) for view in views])
        styles = [view.style for view in views]
        paint(
            self._sectors,
            [to_rgba(style.field_colour, style.field_alpha) for style in styles],
            [to_rgba(style.field_edge_colour, style.field_alpha) for style in styles],
        )

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        self._sectors.draw(renderer)


class Labels:
    """Texts beside bodies and goals."""

    def __init__(self, axes: Axes) -> None:
        self._text = Text(family=theme.FONT, ha="center", va="bottom", parse_math=False, usetex=False, animated=True)
        axes.add_artist(self._text)
        self._views: Sequence[LabelView] = ()

    def update(self, views: Sequence[LabelView]) -> None:
        """Show these labels."""
        self._views = views

    def draw(self, renderer: RendererBase) -> None:
        """Draw what the last update gave."""
        for view in self._views:
            style = view.style
            self._text.set(position=(view.x, view.y), text=view.text, color=style.label_colour, alpha=style.label_alpha)
            self._text.set_fontsize(style.label_size)
            self._text.draw(renderer)


def clear_of_flags(label: LabelView, goals: Sequence[GoalView], point: float) -> LabelView:
    """Return a label, below its body where it would stand on the flag of a goal.

    Args:
        label: The label.
        goals: The goals that are shown.
        point: A point of type [m].
    """
    height = 1.3 * label.style.label_size * point
    half = 0.35 * label.style.label_size * len(label.text) * point
    for goal in goals:
        beside = goal.x + FLAG[0] * point < label.x - half or goal.x > label.x + half
        apart = goal.y + FLAG[1] * point < label.y or goal.y > label.y + height
        if label.under is not None and not beside and not apart:
            return replace(label, y=label.under - height)
    return label


def _faded(colour: Colour, share: float) -> Colour:
    return *colour[:3], colour[3] * share
