"""The figure of a learning curve."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from irsim_gym.evaluation.protocol.tables import write_figure

INK, ACCENT, FAILURE, GRID = "#1f2933", "#2166ac", "#b2182b", "#d9dee3"
LINE = 88
"""Characters in a line of the title."""


def draw_curve(path: Path, points: Sequence[dict[str, float]], title: str) -> None:
    """Draw success and collisions over the training time, with the score of the last checkpoint.

    Args:
        path: PNG file to write.
        points: Rows with ``training_seconds``, ``steps``, ``success``, ``success_low``, ``success_high`` and
            ``collision``; for teams also ``individual_success``.
        title: Title: what was trained, and on which levels it was scored.
    """
    from irsim_gym.rendering.looks import fonts

    figure = Figure(figsize=(7.2, 4.6), dpi=120, layout="constrained")
    axes = figure.add_subplot()
    seconds = [point["training_seconds"] for point in points]
    axes.fill_between(
        seconds,
        [100.0 * point["success_low"] for point in points],
        [100.0 * point["success_high"] for point in points],
        color=ACCENT, alpha=0.18, linewidth=0.0, label="95 % interval",
    )  # fmt: skip
    success, collision = ([100.0 * point[name] for point in points] for name in ("success", "collision"))
    is_team = "individual_success" in points[0]
    axes.plot(seconds, success, color=ACCENT, marker="o", ms=3.5, label="all arrive" if is_team else "success")
    if is_team:
        each = [100.0 * point["individual_success"] for point in points]
        axes.plot(seconds, each, color=ACCENT, lw=1.2, ls=":", label="robots that arrive")
    for name in successes(points[0]):
        curve = [100.0 * point[f"{name}/success"] for point in points]
        axes.plot(seconds, curve, lw=0.9, marker=".", ms=3.0, zorder=1, label=fonts.label(name))
    label = "robots that collide" if is_team else "collision"
    axes.plot(seconds, collision, color=FAILURE, lw=1.2, ls="--", label=label)
    for mark, side in ((95.0, "top"), (98.0, "bottom")):
        place = (1.005, mark)
        axes.annotate(f"{mark:.0f} %", place, xycoords=("axes fraction", "data"), fontsize=7, color=INK, va=side)
    _set_axes(axes, "levels, robots [%]" if is_team else "levels [%]", 0.0)
    words, face = fonts.families("\n".join(textwrap.wrap(title, LINE)), bold=True)
    figure.suptitle(words, x=0.01, ha="left", fontsize=10, color=INK, **face)
    axes.set_title(_last(points[-1]), loc="left", fontsize=8.5, color=INK)
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    write_figure(path, figure)


def draw_curves(path: Path, title: str, seeds: Sequence[dict[str, Any]], success: str) -> None:
    """Draw the learning curves of all seeds over the training time.

    Args:
        path: PNG file to write.
        seeds: Name of each ``run``, and its ``curve``, as ``draw_curve`` takes the points of one.
        success: What the success is that of.
    """
    from irsim_gym.rendering.looks import fonts

    figure = Figure(figsize=(7.2, 4.0), dpi=120, layout="constrained")
    axes = figure.add_subplot()
    for seed in seeds:
        seconds = [point["training_seconds"] for point in seed["curve"]]
        shares = [100 * point["success"] for point in seed["curve"]]
        axes.plot(seconds, shares, lw=1.4, marker="o", ms=2.5, label=fonts.label(seed["run"]))
    worst = 100 * min(point["success"] for seed in seeds for point in seed["curve"])
    levels = seeds[0]["curve"][-1]["levels"]
    _set_axes(axes, f"{success} on {levels:,.0f} dev levels [%]", max(0.0, worst // 10 * 10 - 10))
    axes.set_title(title, loc="left", fontsize=10, parse_math=False)
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    write_figure(path, figure)


def _set_axes(axes: Axes, shares: str, lowest: float) -> None:
    """Name the axes of training time and of shares, and mark 95 % and 98 %."""
    for mark in (95, 98):
        axes.axhline(mark, color=GRID, lw=1.0, zorder=0)
    axes.set(xlabel="training time [s]", ylabel=shares, ylim=(lowest, 100.5), xlim=(0.0, None))
    axes.spines[["top", "right"]].set_visible(False)


def successes(point: dict[str, float]) -> dict[str, float]:
    """Return the success in each scenario of a mixture, by name; an empty dict for a single scenario."""
    return {key.removesuffix("/success"): value for key, value in point.items() if key.endswith("/success")}


def _last(point: dict[str, float]) -> str:
    """Return a line about the last checkpoint and its score."""
    whose = "of teams arrive whole" if "individual_success" in point else "success"
    low, high = 100.0 * point["success_low"], 100.0 * point["success_high"]
    after = f"after {point['steps']:,.0f} steps, {point['training_seconds']:,.0f} s of training"
    return f"{after}: {100.0 * point['success']:.1f} % {whose} ({low:.1f}\N{EN DASH}{high:.1f})"
