"""Plots the paths of evaluated policies: where they succeed, and where and how they fail."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from matplotlib.figure import Figure

from irsim_gym.rendering.figures import ways_marks
from irsim_gym.rendering.figures.figure import READABLE
from irsim_gym.rendering.figures.ways_density import Density
from irsim_gym.rendering.figures.ways_marks import BEYOND, ORDER, DrawnWay
from irsim_gym.rendering.frames.card import number_text
from irsim_gym.rendering.looks import fonts, theme
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.looks.tiles import few_columns
from irsim_gym.rendering.scene.frame_layout import DOTS_PER_INCH, tick_positions

PANEL = 4.6
"""Longer side of a panel [inch]."""
LEFT, RIGHT, TITLE, ABOVE, BELOW = 0.45, 0.2, 0.35, 0.55, 0.6
"""Margins on the left and right, height of the heading, and room above and below each panel [inch]."""
LETTER, LINE, ENTRY = 0.064, 0.17, 1.0
"""Width of a letter and height of a line of the note, and width of an entry of the legend [inch]."""
FEW = 40
"""Maximum number of whole successful paths in a panel, and of failed ones; more would be indistinguishable."""


@dataclass(frozen=True)
class WaysPanel:
    """The results of one policy.

    Attributes:
        title: Name of the policy.
        success: Text about its success.
        ways: Whole paths, and the ends of others.
        counts: Number of times each outcome occurred, over all levels.
    """

    title: str
    success: str
    ways: Sequence[DrawnWay]
    counts: Mapping[str, int]


Place = tuple[float, float, float, float]
"""Left edge, upper edge, width and height of a panel [inch], from the upper left corner of the picture."""


class WaysPlan:
    """The positions of panels.

    Args:
        bounds: The world's rectangle [m].
        count: Number of panels.

    Attributes:
        width: Width of the picture [inch].
        height: Its height [inch].
    """

    def __init__(self, bounds: Sequence[float], count: int) -> None:
        x_min, y_min, x_max, y_max = bounds
        around = 2.0 * BEYOND * max(x_max - x_min, y_max - y_min)
        share = (y_max - y_min + around) / (x_max - x_min + around)
        wide = PANEL * min(1.0, 1.0 / share)
        self._panel = wide, wide * share
        self._columns = few_columns(count)
        self.width = LEFT + self._columns * (wide + LEFT) - LEFT + RIGHT
        self.height = TITLE + math.ceil(count / self._columns) * (ABOVE + self._panel[1] + BELOW)

    def panel(self, k: int) -> Place:
        """Return the position of a panel."""
        row, column = divmod(k, self._columns)
        wide, high = self._panel
        return LEFT + column * (wide + LEFT), TITLE + ABOVE + row * (ABOVE + high + BELOW), wide, high


def draw_ways(
    paths: Sequence[Path],
    panels: Sequence[WaysPanel],
    density: Density,
    title: str,
    note: str,
    *,
    dots_per_inch: int = 120,
) -> None:
    """Draw the paths of policies into files, with a panel for each policy.

    Green paths have arrived; marks show the ends of the others. Grey areas are occupied, darker ones in more levels.

    Args:
        paths: Files to write, ``.png``, ``.pdf``, ``.svg``.
        panels: The policies.
        density: Density of obstacles.
        title: Heading of the figure.
        note: Explanation below the panels.
        dots_per_inch: Resolution.
    """
    figure = plot_ways(panels, density, title, note)
    for path in paths:
        with whole_file(path) as part, matplotlib.rc_context(READABLE):
            figure.savefig(part, dpi=dots_per_inch, facecolor=theme.PAPER)


def plot_ways(panels: Sequence[WaysPanel], density: Density, title: str, note: str) -> Figure:
    """Return the figure of ``draw_ways``."""
    plan = WaysPlan(density.bounds, len(panels))
    entries = ways_marks.legend(outcome for panel in panels for outcome in panel.counts)
    room = plan.width - LEFT - RIGHT
    lines = textwrap.wrap(note, max(int(room / LETTER), 20))
    columns = max(min(len(entries), int(room / ENTRY)), 1)
    foot = LINE * (len(lines) + 1.5 * math.ceil(len(entries) / columns))
    width, height = plan.width, plan.height + foot
    figure = Figure(figsize=(width, height), facecolor=theme.PAPER)
    FigureCanvasAgg(figure)

    def axes(place: Place) -> Axes:
        left, top, wide, high = place
        return figure.add_axes((left / width, 1.0 - (top + high) / height, wide / width, high / height))

    words, face = fonts.families(title, bold=True)
    figure.text(LEFT / width, 1.0 - 0.2 / height, words, va="center", fontsize=11, color=theme.INK, **face)
    for k, panel in enumerate(panels):
        _draw_panel(axes(plan.panel(k)), panel, density)
    figure.legend(handles=entries, loc="lower left", bbox_to_anchor=(LEFT / width, 0.0), borderaxespad=0.3,
                  borderpad=0.0, ncols=columns, frameon=False, fontsize=8, title=fonts.label("\n".join(lines)),
                  title_fontsize=8, alignment="left", labelcolor=theme.INK)  # fmt: skip
    return figure


def _draw_panel(axes: Axes, panel: WaysPanel, density: Density) -> None:
    x_min, y_min, x_max, y_max = density.bounds
    dark = ["#DDE2E7", "#9DA9B5"] if density.differs else ["#B8C0CA", "#5B6774"]
    grey = LinearSegmentedColormap.from_list("occupied", [theme.CARD, *dark])
    shades = PowerNorm(0.5, vmin=0.0, vmax=1.0)  # makes obstacles of few levels visible
    axes.imshow(density.shares(), cmap=grey, norm=shades, extent=(x_min, x_max, y_min, y_max), zorder=0)
    whole = [way for way in panel.ways if len(way.points) > 1]
    shown = [way for way in whole if way.outcome == "success"][:FEW]
    shown += [way for way in whole if way.outcome != "success"][:FEW]
    failed = [way for way in panel.ways if way.outcome != "success"]
    ways_marks.draw_lines(axes, shown, 0.8)
    ways_marks.draw_starts_and_goals(axes, shown, 12.0)
    ways_marks.draw_ends(axes, failed, 26.0 * max(ways_marks.paler(len(failed)), 0.5))
    ways_marks.show_world(axes, density.bounds)
    _write(axes, panel)
    _add_ticks(axes, density.bounds)


def _write(axes: Axes, panel: WaysPanel) -> None:
    """Write a panel's name and success above it, and the outcomes below."""
    title, face = fonts.families(panel.title, bold=True)
    axes.set_title(title, loc="left", fontsize=9, color=theme.INK, pad=15, **face)
    axes.text(0.0, 1.012, panel.success, transform=axes.transAxes, fontsize=8, color=theme.INK, family=theme.FONT)
    counts = ", ".join(
        f"{ways_marks.words_of(outcome)} {panel.counts[outcome]:,}" for outcome in ORDER if panel.counts.get(outcome)
    )
    axes.set_xlabel(counts, fontsize=7.5, color=theme.INK, family=theme.FONT, loc="left")


def _add_ticks(axes: Axes, bounds: Sequence[float]) -> None:
    """Add coordinates; the last one along the x axis has the unit."""
    x_min, y_min, x_max, y_max = bounds
    box, scale = axes.get_window_extent(), DOTS_PER_INCH / axes.figure.dpi
    wide, high = box.width * scale, box.height * scale
    columns, rows = tick_positions(x_min, x_max, wide).tolist(), tick_positions(y_min, y_max, high).tolist()
    axes.set_xticks(columns, [number_text(x) + (" m" if x == columns[-1] else "") for x in columns])
    axes.set_yticks(rows, [number_text(y) for y in rows])
    axes.tick_params(labelsize=7, colors=theme.INK_LIGHT, length=0, pad=1.0)
