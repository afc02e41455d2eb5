"""Draws paths and their ends in pictures of evaluations."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from irsim_gym.base.arraytypes import Floats, Rays
from irsim_gym.rendering.looks import theme

MARKS = {"collision": "X", "timeout": "s", "left_world": "D", "deadlock": "P", "misplaced": "v"}
ORDER = ("success", "timeout", "deadlock", "misplaced", "left_world", "collision")
"""Drawing order of paths, so that rare and important outcomes are on top."""
OTHER = "#7B8794"
BEYOND = 0.045
"""Margin around the world as a share of its longer side, since paths may leave the world."""


@dataclass(frozen=True)
class DrawnWay:
    """A path in the picture.

    Attributes:
        points: Positions [m], ``(n, 2)``; a single one if only the end is known.
        goal: The goal [m], ``(2,)``, or NaN.
        outcome: The outcome, e.g. ``"collision"``.
    """

    points: Rays
    goal: Floats
    outcome: str


def colour_of(outcome: str) -> str:
    """Return the colour of an outcome."""
    return theme.OUTCOMES.get(outcome, OTHER)


def words_of(outcome: str) -> str:
    """Return an outcome as text: ``left_world`` becomes "left world"."""
    return outcome.replace("_", " ")


def rank_of(outcome: str) -> int:
    """Return the index of an outcome in ``ORDER``."""
    return ORDER.index(outcome) if outcome in ORDER else 0


def draw_lines(axes: Axes, ways: Sequence[DrawnWay], opacity: float, width: float = 1.0) -> None:
    """Draw paths, the successful ones paler and below the others."""
    ordered = sorted(ways, key=lambda way: rank_of(way.outcome))
    pale = {outcome: (0.75 if outcome == "success" else 0.95) * opacity for outcome in ORDER}
    lines: Any = LineCollection([way.points for way in ordered], linewidths=width, capstyle="round", zorder=2)
    lines.set_color([to_rgba(colour_of(way.outcome), pale.get(way.outcome, opacity)) for way in ordered])
    axes.add_collection(lines, autolim=False)


def draw_starts_and_goals(axes: Axes, ways: Sequence[DrawnWay], size: float) -> None:
    """Mark the starts and goals of paths."""
    draw_dots(axes, (way.points[0] for way in ways), theme.INK_LIGHT, "o", size, hollow=True)
    draw_dots(axes, (way.goal for way in ways), theme.INK, "^", size)


def draw_ends(axes: Axes, ways: Sequence[DrawnWay], size: float) -> None:
    """Mark the ends of failed paths."""
    for outcome in ORDER[1:]:
        ends = (way.points[-1] for way in ways if way.outcome == outcome)
        draw_dots(axes, ends, colour_of(outcome), MARKS[outcome], size, order=4.0)


def draw_dots(
    axes: Axes,
    places: Iterable[object],
    colour: str,
    marker: str,
    size: float,
    *,
    hollow: bool = False,
    order: float = 3.0,
) -> None:
    """Draw a marker at each known place [m]."""
    points = np.array(list(places), np.float64).reshape(-1, 2)
    points = points[~np.isnan(points).any(axis=1)]
    face = "none" if hollow else to_rgba(colour, 0.85)
    axes.scatter(
        points[:, 0], points[:, 1], s=size, marker=marker, facecolors=face,
        edgecolors=colour if hollow else theme.CARD, linewidths=0.7 if hollow else 0.5, zorder=order,
    )  # fmt: skip


def show_world(axes: Axes, bounds: Sequence[float]) -> None:
    """Draw a world's rectangle [m], x_min, y_min, x_max, y_max, with a border and without ticks."""
    x_min, y_min, x_max, y_max = bounds
    beyond = BEYOND * max(x_max - x_min, y_max - y_min)
    axes.set(xlim=(x_min - beyond, x_max + beyond), ylim=(y_min - beyond, y_max + beyond), aspect="equal")
    place = (x_min, y_min), x_max - x_min, y_max - y_min
    axes.add_patch(Rectangle(*place, fc=theme.CARD, ec="none", zorder=-1.0))
    axes.add_patch(Rectangle(*place, fill=False, ec=theme.RULE, lw=0.8))
    axes.set(xticks=[], yticks=[], facecolor=theme.PAPER)
    axes.spines[:].set_visible(False)


def legend(outcomes: Iterable[str]) -> list[Line2D]:
    """Return the legend's entries for outcomes, starts and goals."""
    common: dict[str, Any] = {"markersize": 5, "markeredgewidth": 0.7}
    found = set(outcomes)
    handles = [
        Line2D([], [], color=colour_of(outcome), marker=MARKS.get(outcome, ""), label=words_of(outcome), **common)
        for outcome in ORDER
        if outcome in found
    ]
    start = Line2D([], [], ls="", marker="o", mfc="none", mec=theme.INK_LIGHT, label="start", **common)
    goal = Line2D([], [], ls="", marker="^", mfc=theme.INK, mec=theme.CARD, label="goal", **common)
    return [*handles, start, goal]


def paler(count: int) -> float:
    """Return an opacity for ``count`` paths, or a scale factor for ``count`` marks."""
    return min(1.0, math.sqrt(40.0 / max(count, 1)))
