"""Plots the success of policies over the strength of disturbances, a panel for each disturbance."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irsim_gym.rendering.figures.figure import READABLE
from irsim_gym.rendering.looks import fonts, theme
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.looks.tiles import few_columns

PANEL, AROUND = (2.9, 2.3), 0.9
"""Width and height of a panel, and height of heading and legend [inch]."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Colours of policies, which people can tell apart who do not see all colours (Okabe and Ito 2008)."""
MARKERS = "os^DvPX"
NOTE = "Bands: 95 % intervals. Dotted: the strength at which 5 points are lost."
Curve = tuple[Sequence[tuple[float, float, float, float]], float]
"""By ascending strength: strength, success and both ends of its interval [%]; and the strength at which 5 points are
lost, which need not be finite."""


def draw_strengths(files: Sequence[Path], panels: Mapping[str, Mapping[str, Curve]], title: str) -> None:
    """Draw curves with their intervals; a dotted line leads down from where a policy has lost 5 points.

    Args:
        files: Files to write, ``.png``, ``.pdf`` or another format of matplotlib.
        panels: Curves by disturbance, with the unit of its strength, and by policy; all panels have the same policies.
        title: What was played.
    """
    columns = few_columns(len(panels))
    rows = math.ceil(len(panels) / columns)
    size = max(1.3, columns) * PANEL[0] + 0.4, rows * PANEL[1] + AROUND
    worst = min(low for curves in panels.values() for points, _ in curves.values() for _, _, low, _ in points)
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, **READABLE}):
        figure = Figure(figsize=size, dpi=120, layout="constrained")
        grid = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel()
        for k, (axes, (label, curves)) in enumerate(zip(grid, panels.items(), strict=False)):
            _draw_panel(axes, curves, max(0.0, worst // 10 * 10))
            axes.set_xlabel(label, parse_math=False, fontsize=9)
            axes.set_ylabel("success [%]" if k % columns == 0 else "", fontsize=9)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        words, face = fonts.families(title, bold=True)
        figure.suptitle(words, x=0.01, ha="left", fontsize=10, color=theme.INK, **face)
        look = {"frameon": False, "fontsize": 8, "title_fontsize": 8, "alignment": "left", "ncols": columns}
        figure.legend(*grid[0].get_legend_handles_labels(), loc="outside lower left", title=NOTE, **look)
        for file in files:
            with whole_file(file) as part:
                figure.savefig(part)


def _draw_panel(axes: Axes, curves: Mapping[str, Curve], lowest: float) -> None:
    for k, (name, (points, lost)) in enumerate(curves.items()):
        colour, marker = COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
        strengths, success, low, high = zip(*points, strict=True)
        axes.fill_between(strengths, low, high, color=colour, alpha=0.18, linewidth=0.0)
        (line,) = axes.plot(strengths, success, color=colour, marker=marker, ms=3.5, lw=1.4, label=fonts.label(name))
        line.set_clip_on(False)
        if math.isfinite(lost):
            axes.vlines(lost, lowest, success[0] - 5.0, color=colour, lw=1.0, ls=":")
    axes.set(ylim=(lowest, 100.5), xlim=(0.0, None))
    axes.grid(axis="y", color=theme.RULE, lw=0.6, alpha=0.6)
    axes.tick_params(labelsize=8, color=theme.RULE)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(theme.RULE)
