"""Plots the directions of observation columns: a level around a robot, overlaid with numbered sectors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Wedge
from matplotlib.transforms import Affine2D

from irsim_gym.base.arraytypes import Bytes, Floats, Rays
from irsim_gym.rendering.figures.figure import READABLE
from irsim_gym.rendering.figures.ways_levels import draw_map
from irsim_gym.rendering.looks import fonts, theme
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.looks.tiles import few_columns
from irsim_gym.rendering.scene.scene import Scene

PANEL = 4.6
"""Side of a panel [inch]."""
MOST_NUMBERS = 40
"""Maximum number of sector numbers; with more sectors, only some numbers are written."""
BEYOND = 1.2
"""Extent of a panel relative to the sectors."""
ROBOT_HALF = 0.5


@dataclass(frozen=True)
class SectorPanel:
    """Columns that belong to directions.

    Attributes:
        title: Their name.
        note: Their meaning.
        first: Number of the first column.
        sectors: Start and end angle of each [degree], 0 straight ahead, positive to the left.
        values: Their present values, scaled from 0 (minimum) to 1 (maximum).
    """

    title: str
    note: str
    first: int
    sectors: Sequence[tuple[float, float]]
    values: Rays


@dataclass(frozen=True)
class ImagePanel:
    """An image observation of a robot, or one channel of it.

    Attributes:
        title: Its name.
        note: Its meaning.
        image: uint8, ``(height, width)`` or ``(height, width, 3)``.
    """

    title: str
    note: str
    image: Bytes


def draw_sectors(
    path: Path,
    panels: Sequence[SectorPanel | ImagePanel],
    scene: Scene,
    pose: Floats,
    reach: float,
    title: str,
    *,
    dots_per_inch: int = 110,
) -> None:
    """Draw the directions of columns, one panel each, with the robot in the middle and its heading up.

    Args:
        path: File to write, ``.png``, ``.pdf``, ``.svg``.
        panels: The panels.
        scene: The level.
        pose: The robot's pose [m, m, rad].
        reach: Radius of the sectors [m].
        title: Heading of the figure.
        dots_per_inch: Resolution.
    """
    columns = few_columns(len(panels))
    rows = math.ceil(len(panels) / columns)
    figure = Figure(figsize=(columns * PANEL, rows * (PANEL + 0.5) + 0.6), facecolor=theme.PAPER, layout="constrained")
    FigureCanvasAgg(figure)
    title, face = fonts.families(title, bold=True)
    figure.suptitle(title, x=0.02, ha="left", fontsize=11, color=theme.INK, **face)
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(rows, columns, k + 1)
        if isinstance(panel, ImagePanel):
            _draw_image(axes, panel)
        else:
            _draw_level(axes, scene, pose, BEYOND * reach)
            _draw_panel(axes, panel, reach)
        heading, face = fonts.families(panel.title, bold=True)
        axes.set_title(heading, loc="left", fontsize=9, color=theme.INK, **face)
        note: dict[str, Any] = {
            "fontsize": 7.5,
            "color": theme.INK,
            "family": theme.FONT,
            "wrap": True,
            "parse_math": False,
        }
        axes.set_xlabel(panel.note, loc="left", **note)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_color(theme.RULE)
    with whole_file(path) as part, matplotlib.rc_context(READABLE):
        figure.savefig(part, dpi=dots_per_inch, facecolor=theme.PAPER)


def _draw_image(axes: Axes, panel: ImagePanel) -> None:
    axes.imshow(panel.image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")


def _draw_level(axes: Axes, scene: Scene, pose: Floats, most: float) -> None:
    """Draw the surroundings of a robot, with its heading up."""
    x, y, heading = pose.tolist()
    turn = Affine2D().translate(-x, -y).rotate(0.5 * math.pi - heading) + axes.transData
    (x_min, y_min), (x_max, y_max) = scene.bounds[:2], scene.bounds[2:]
    around = [(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)]
    axes.add_patch(Polygon(around, fill=False, ec=theme.RULE, lw=1.2, zorder=1, transform=turn))
    if scene.map is not None:
        draw_map(axes, scene.map, theme.MAP, zorder=1, transform=turn)
    for body in (*scene.fixed, *scene.moving):
        for line in body.lines:
            look: dict[str, Any] = {"fill": body.solid, "fc": theme.RULE, "ec": theme.WALL, "lw": 1.0, "zorder": 2}
            closed = np.array_equal(line[0], line[-1])
            axes.add_patch(Polygon(line, closed=closed, transform=turn, **look))
        for across, up, radius in body.discs.tolist():
            own = math.hypot(across - x, up - y) < ROBOT_HALF * radius
            face, edge, order = (theme.ROBOT, theme.INK, 6) if own else (theme.RULE, theme.WALL, 2)
            axes.add_patch(Circle((across, up), radius, fc=face, ec=edge, lw=1.0, zorder=order, transform=turn))
    axes.set(xlim=(-most, most), ylim=(-most, most), aspect="equal", facecolor=theme.CARD)


def _draw_panel(axes: Axes, panel: SectorPanel, reach: float) -> None:
    """Draw numbered sectors, in stronger colour for larger values."""
    axes.annotate("", (0.0, 0.35 * reach), (0.0, 0.0), zorder=7, arrowprops={"arrowstyle": "->", "color": theme.INK})
    every = math.ceil(len(panel.sectors) / MOST_NUMBERS)
    for k, (begin, end) in enumerate(panel.sectors):
        shade = 0.06 + 0.6 * float(np.clip(panel.values[k], 0.0, 1.0))
        # Straight ahead is up in the panel, 90 degrees from its x axis.
        middle = math.radians(90.0 + 0.5 * (begin + end))
        tip = reach * math.cos(middle), reach * math.sin(middle)
        if begin == end:
            axes.plot([0.0, tip[0]], [0.0, tip[1]], color=theme.BEAM, alpha=shade, lw=2.2, zorder=3)
        else:
            axes.add_patch(
                Wedge((0.0, 0.0), reach, 90.0 + begin, 90.0 + end, fc=theme.BEAM, ec="none", alpha=shade, zorder=3)
            )
            axes.add_patch(
                Wedge((0.0, 0.0), reach, 90.0 + begin, 90.0 + end, fill=False, ec=theme.BEAM, lw=0.4, zorder=4)
            )
        if k % every == 0:
            axes.text(
                1.08 * tip[0], 1.08 * tip[1], str(panel.first + k), ha="center", va="center", fontsize=6.5,
                color=theme.INK, family=theme.FONT, zorder=7,
            )  # fmt: skip
