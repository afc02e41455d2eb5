"""Figures for documents: scenes drawn by matplotlib, anew for each file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from irsim_gym.rendering.figures.figure_artists import TEXT, SceneArtists
from irsim_gym.rendering.frames.card import NAME_SIZE, STATUS_SIZE, TICK_SIZE, Head, number_text, ticks
from irsim_gym.rendering.frames.letters import Masks
from irsim_gym.rendering.looks import fonts, theme
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.scene.frame_layout import DOTS_PER_INCH, POINTS_PER_INCH, Layout
from irsim_gym.rendering.scene.scene import Scene
from irsim_gym.scenario.specs.plot_spec import SavedFigure

READABLE: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "ps.fonttype": 42}
"""Settings that keep text as text in vector formats, with embedded fonts where possible."""


@dataclass(frozen=True)
class Frame:
    """The surroundings of the world on a figure.

    Attributes:
        titled: Whether a title replaces name, status and time.
        axis: Whether to draw ticks and the world's border.
        shows_title: Whether there is a line of text above the world.
    """

    titled: bool = False
    axis: bool = True
    shows_title: bool = True


def scene_figure(scene: Scene, layout: Layout, around: Frame, background: str = theme.CARD) -> Figure:
    """Return a figure of a scene with the size of a frame, at 100 dots per inch times the layout's enlargement.

    Args:
        scene: The scene.
        layout: Layout of the figure.
        around: The surroundings of the world.
        background: Colour of the world's rectangle; ``"none"`` for transparent.
    """
    dpi = DOTS_PER_INCH * layout.enlargement
    figure = Figure(figsize=(layout.width / dpi, layout.height / dpi), dpi=dpi, facecolor=theme.PAPER)
    width, height = layout.width, layout.height
    place = layout.left / width, layout.bottom / height, layout.plot_width / width, layout.plot_height / height
    axes = figure.add_axes(place)
    x_min, y_min, x_max, y_max = layout.limits
    axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max), autoscale_on=False)
    axes.set_axis_off()
    x_min, y_min, x_max, y_max = layout.bounds
    edge = theme.RULE if around.axis else theme.CARD
    card = Rectangle((x_min, y_min), x_max - x_min, y_max - y_min, facecolor=background, edgecolor=edge, linewidth=0.8)
    axes.add_patch(card)
    if around.axis:
        _add_ticks(figure, axes, layout)
    SceneArtists(axes, layout, clipped=scene.center is None).add(scene)
    if around.shows_title:
        _add_head(figure, layout, scene, titled=around.titled)
    return figure


def save_figure(
    scene: Scene, layout: Layout, around: Frame, path: Path, options: SavedFigure, dots_per_inch: float
) -> None:
    """Write a figure of a scene to a file, in the format of its suffix.

    Args:
        scene: The scene.
        layout: Layout of the figure.
        around: The surroundings of the world.
        path: File to write, ``.png``, ``.pdf``, ``.svg`` or another format of matplotlib; missing folders are created.
        options: Margins and background.
        dots_per_inch: 100 for the size of a frame, 200 for twice the width and height in pixels.
    """
    with whole_file(path) as part, matplotlib.rc_context({**matplotlib.rcParamsDefault, **READABLE}):
        figure = scene_figure(scene, layout, around, "none" if options.transparent else theme.CARD)
        figure.savefig(
            part,
            dpi=figure.dpi * dots_per_inch / DOTS_PER_INCH,
            bbox_inches="tight" if options.bbox_inches == "tight" else None,
            pad_inches=options.pad_inches,
            facecolor="none" if options.transparent else options.facecolor or theme.PAPER,
        )


def _add_ticks(figure: Figure, axes: Axes, layout: Layout) -> None:
    """Add the grid and its coordinates; the last number below has the unit."""
    columns, rows, (left, low, right, high) = ticks(layout)
    gap, look = 6.0 * layout.enlargement, {**TEXT, "fontsize": TICK_SIZE, "color": theme.INK_LIGHT}
    for x in columns:
        axes.plot([x, x], [low, high], color=theme.GRID, linewidth=0.7)
        column, row = layout.column_row(x, low)
        place = column / layout.width, 1.0 - (row + gap) / layout.height
        figure.text(*place, number_text(x) + (" m" if x == columns[-1] else ""), ha="center", va="top", **look)
    for y in rows:
        axes.plot([left, right], [y, y], color=theme.GRID, linewidth=0.7)
        column, row = layout.column_row(left, y)
        place = (column - gap) / layout.width, 1.0 - row / layout.height
        figure.text(*place, number_text(y), ha="right", va="center", **look)


def _add_head(figure: Figure, layout: Layout, scene: Scene, *, titled: bool) -> None:
    """Add name, status and time, or the title, at the positions of frames."""
    by_hand = scene.overlay.title
    point = DOTS_PER_INCH / POINTS_PER_INCH * layout.enlargement
    head = Head(Masks(), point, layout, titled=titled or by_hand is not None)
    level = 1.0 - head.middle / layout.height
    for words, column, bold, coloured in head.texts(
        scene.title if by_hand is None else by_hand, scene.status, scene.time
    ):
        text, face = fonts.families(words, bold=bold)
        tone = theme.status_colour(scene.status) if coloured else theme.INK
        look = {**TEXT, **face, "fontsize": NAME_SIZE if bold else STATUS_SIZE, "color": tone}
        figure.text(column / layout.width, level, text, va="center", **look)
