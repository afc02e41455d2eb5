"""The ways of evaluated policies over the world: where they succeed, and where and how they fail."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, PowerNorm, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageDraw

from irsim_gym.arraytypes import Floats, Rays
from irsim_gym.render import fonts, theme
from irsim_gym.render.files import whole_file
from irsim_gym.render.scene import BodyView, MapView
from irsim_gym.render.stage import READABLE
from irsim_gym.render.tiles import few_columns

CELLS = 240
"""Cells along the longer side of the density of obstacles."""
FINER = 2
PANEL = 4.3
"""Longer side of a panel [inch]."""
BEYOND = 0.045
"""What is seen around the world, as a share of its longer side: some leave it."""
MARKS = {"collision": "X", "timeout": "s", "left_world": "D", "deadlock": "P"}
ORDER = ("success", "timeout", "deadlock", "left_world", "collision")
"""Ways are drawn in this order: what is rare and matters lies on top."""
OTHER = "#7B8794"


@dataclass(frozen=True)
class DrawnWay:
    """A way in the picture.

    Attributes:
        points: Positions [m], ``(n, 2)``; one where only its end is known.
        goal: Where it should end [m], ``(2,)``, or NaN.
        outcome: How it ended, e.g. ``"collision"``.
    """

    points: Rays
    goal: Floats
    outcome: str


@dataclass(frozen=True)
class Panel:
    """What one policy did.

    Attributes:
        title: Its name.
        success: What is said of its success.
        ways: Whole ways, and the ends of others.
        counts: How often each outcome occurred, over all levels.
    """

    title: str
    success: str
    ways: Sequence[DrawnWay]
    counts: Mapping[str, int]


class Density:
    """The share of levels in which a place is occupied.

    Args:
        bounds: The world's rectangle [m]: x_min, y_min, x_max, y_max, ``(4,)``.
    """

    def __init__(self, bounds: Floats) -> None:
        self.bounds = tuple(float(value) for value in bounds)
        x_min, y_min, x_max, y_max = self.bounds
        self._scale = FINER * CELLS / max(x_max - x_min, y_max - y_min)
        self._size = max(round((x_max - x_min) * self._scale), 1), max(round((y_max - y_min) * self._scale), 1)
        self._sum: Floats = np.zeros(self._size[::-1])
        self._levels = 0

    def add(self, bodies: Iterable[BodyView], occupied: MapView | None = None) -> None:
        """Add the obstacles of a level."""
        picture = Image.new("L", self._size)
        draw = ImageDraw.Draw(picture)
        for body in bodies:
            for line in body.lines:
                if body.solid:
                    draw.polygon(self._pixels(line), fill=1)
                else:
                    draw.line(self._pixels(line), fill=1, width=FINER)
            for x, y, radius in body.discs.tolist():
                (column, row), reach = self._pixels(np.array([[x, y]]))[0], radius * self._scale
                draw.ellipse((column - reach, row - reach, column + reach, row + reach), fill=1)
        if occupied is not None:
            self._draw_map(draw, occupied)
        self._sum += np.asarray(picture)
        self._levels += 1

    def shares(self) -> Floats:
        """Return the shares, row 0 at the top, shape ``(n_rows, n_columns)``."""
        rows, columns = (length // FINER for length in self._sum.shape)
        cut = self._sum[: rows * FINER, : columns * FINER].reshape(rows, FINER, columns, FINER).mean(axis=(1, 3))
        return np.asarray(cut / max(self._levels, 1))

    def _pixels(self, points: Floats) -> list[tuple[float, float]]:
        columns = (points[:, 0] - self.bounds[0]) * self._scale
        rows = (self.bounds[3] - points[:, 1]) * self._scale
        return list(zip(columns.tolist(), rows.tolist(), strict=True))

    def _draw_map(self, draw: ImageDraw.ImageDraw, view: MapView) -> None:
        x_min, y_min, x_max, y_max = view.extent
        wide, high = (x_max - x_min) / view.occupied.shape[0], (y_max - y_min) / view.occupied.shape[1]
        for column, row in np.argwhere(view.occupied).tolist():
            low = x_min + column * wide, y_min + row * high
            (left, bottom), (right, top) = self._pixels(np.array([low, (low[0] + wide, low[1] + high)]))
            draw.rectangle((left, top, right, bottom), fill=1)


def draw_ways(
    paths: Sequence[Path], panels: Sequence[Panel], density: Density, title: str, note: str, *, dots_per_inch: int = 120
) -> None:
    """Draw the ways of policies, a panel for each, into files.

    Green ways have arrived; marks show where the others ended. What is grey is occupied, the darker in the more levels.

    Args:
        paths: Files to write, ``.png``, ``.pdf``, ``.svg``.
        panels: The policies.
        density: Where obstacles are.
        title: Heading.
        note: What is shown, below the panels.
        dots_per_inch: Resolution of pixels.
    """
    x_min, y_min, x_max, y_max = density.bounds
    share = (y_max - y_min) / (x_max - x_min)
    columns = few_columns(len(panels))
    rows = math.ceil(len(panels) / columns)
    wide = PANEL * min(1.0, 1.0 / share)
    size = columns * (wide + 0.45) + 0.2, rows * (wide * share + 0.95) + 0.95
    figure = Figure(figsize=size, facecolor=theme.PAPER, layout="constrained")
    FigureCanvasAgg(figure)
    title, face = fonts.families(title, bold=True)
    figure.suptitle(title, x=0.02, ha="left", fontsize=11, color=theme.INK, **face)
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(rows, columns, k + 1)
        _draw_panel(axes, panel, density)
    figure.legend(handles=_legend(panels), loc="outside lower left", ncols=6, frameon=False, fontsize=8, title=note,
                  title_fontsize=8, alignment="left", labelcolor=theme.INK)  # fmt: skip
    for path in paths:
        with whole_file(path) as part, matplotlib.rc_context(READABLE):
            figure.savefig(part, dpi=dots_per_inch, facecolor=theme.PAPER)


def _draw_panel(axes: Axes, panel: Panel, density: Density) -> None:
    x_min, y_min, x_max, y_max = density.bounds
    grey = LinearSegmentedColormap.from_list("occupied", [theme.CARD, "#B8C0CA", "#5B6774"])
    shades = PowerNorm(0.5, vmin=0.0, vmax=1.0)  # what is there in few levels can be seen too
    axes.imshow(density.shares(), cmap=grey, norm=shades, extent=(x_min, x_max, y_min, y_max), zorder=0)
    ordered = sorted(panel.ways, key=lambda way: ORDER.index(way.outcome) if way.outcome in ORDER else 0)
    whole = [way for way in ordered if len(way.points) > 1]
    many = min(1.0, math.sqrt(60.0 / max(len(whole), 1)))
    alphas = {way.outcome: (0.75 if way.outcome == "success" else 0.95) * many for way in whole}
    lines: Any = LineCollection([way.points for way in whole], linewidths=1.0, capstyle="round", zorder=2)
    lines.set_color([to_rgba(colour_of(way.outcome), alphas[way.outcome]) for way in whole])
    axes.add_collection(lines, autolim=False)
    _dots(axes, [way.points[0] for way in whole], theme.INK_LIGHT, "o", 7.0 * many + 3.0, hollow=True)
    _dots(axes, [way.goal for way in whole], theme.INK, "^", 7.0 * many + 3.0)
    for outcome in ORDER[1:]:
        ends = [way.points[-1] for way in ordered if way.outcome == outcome]
        _dots(axes, ends, colour_of(outcome), MARKS[outcome], 26.0, order=4.0)
    beyond = BEYOND * max(x_max - x_min, y_max - y_min)
    axes.set(xlim=(x_min - beyond, x_max + beyond), ylim=(y_min - beyond, y_max + beyond), aspect="equal")
    axes.add_patch(Rectangle((x_min, y_min), x_max - x_min, y_max - y_min, fill=False, ec=theme.RULE, lw=0.8))
    title, face = fonts.families(panel.title, bold=True)
    axes.set_title(title, loc="left", fontsize=9, color=theme.INK, pad=15, **face)
    axes.text(0.0, 1.012, panel.success, transform=axes.transAxes, fontsize=8, color=theme.INK, family=theme.FONT)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    axes.tick_params(labelsize=7, colors=theme.INK_LIGHT, length=2)
    axes.set_facecolor(theme.PAPER)
    axes.spines[:].set_visible(False)
    counts = ", ".join(
        f"{outcome.replace('_', ' ')} {panel.counts[outcome]:,}" for outcome in ORDER if panel.counts.get(outcome)
    )
    axes.set_xlabel(counts, fontsize=7.5, color=theme.INK, family=theme.FONT, loc="left")


def _dots(
    axes: Axes,
    places: Sequence[Any],
    colour: str,
    marker: str,
    size: float,
    *,
    hollow: bool = False,
    order: float = 3.0,
) -> None:
    points = np.array(places, np.float64).reshape(-1, 2)
    points = points[~np.isnan(points).any(axis=1)]
    face = "none" if hollow else to_rgba(colour, 0.85)
    axes.scatter(
        points[:, 0], points[:, 1], s=size, marker=marker, facecolors=face,
        edgecolors=colour if hollow else theme.CARD, linewidths=0.7 if hollow else 0.5, zorder=order,
    )  # fmt: skip


def colour_of(outcome: str) -> str:
    """Return the colour of an outcome."""
    return theme.OUTCOMES.get(outcome, OTHER)


def _legend(panels: Sequence[Panel]) -> list[Line2D]:
    common: dict[str, Any] = {"markersize": 5, "markeredgewidth": 0.7}
    found = [outcome for outcome in ORDER if any(panel.counts.get(outcome) for panel in panels)]
    handles = [
        Line2D(
            [], [], color=colour_of(outcome), marker=MARKS.get(outcome, ""), label=outcome.replace("_", " "), **common
        )
        for outcome in found
    ]
    start = Line2D([], [], ls="", marker="o", mfc="none", mec=theme.INK_LIGHT, label="start", **common)
    goal = Line2D([], [], ls="", marker="^", mfc=theme.INK, mec=theme.CARD, label="goal", **common)
    return [*handles, start, goal]
