"""The picture of a learning curve."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from irsim_gym.evaluation.tables import write_bytes

INK, ACCENT, FAILURE, GRID = "#1f2933", "#2166ac", "#b2182b", "#d9dee3"


def draw_curve(path: Path, points: Sequence[dict[str, float]], title: str) -> None:
    """Draw success and collisions over training seconds.

    Args:
        path: PNG file to write.
        points: Rows with ``training_seconds``, ``steps``, ``success``, its interval and ``collision``; of teams with
            ``individual_success`` too.
        title: Heading.
    """
    figure = Figure(figsize=(7.2, 4.2), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    seconds = [point["training_seconds"] for point in points]
    axes.fill_between(
        seconds,
        [100.0 * point["success_low"] for point in points],
        [100.0 * point["success_high"] for point in points],
        color=ACCENT, alpha=0.18, linewidth=0.0,
    )  # fmt: skip
    success, collision = ([100.0 * point[name] for point in points] for name in ("success", "collision"))
    is_team = "individual_success" in points[0]
    axes.plot(seconds, success, color=ACCENT, marker="o", ms=3.5, label="all arrive" if is_team else "success")
    if is_team:
        each = [100.0 * point["individual_success"] for point in points]
        axes.plot(seconds, each, color=ACCENT, lw=1.2, ls=":", label="robots that arrive")
    label = "robots that collide" if is_team else "collision"
    axes.plot(seconds, collision, color=FAILURE, lw=1.2, ls="--", label=label)
    for mark, side in ((95.0, "top"), (98.0, "bottom")):
        axes.axhline(mark, color=GRID, lw=1.0, zorder=0)
        place = (1.005, mark)
        axes.annotate(f"{mark:.0f} %", place, xycoords=("axes fraction", "data"), fontsize=7, color=INK, va=side)
    axes.set(
        xlabel="training time [s]",
        ylabel="levels, robots [%]" if is_team else "levels [%]",
        ylim=(0.0, 100.5),
        xlim=(0.0, None),
    )
    axes.set_title(title, loc="left", fontsize=10, color=INK)
    axes.legend(loc="center right", frameon=False, fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    last = points[-1]
    axes.annotate(
        f"{last['steps'] / 1e6:.2g} M steps: {100.0 * last['success']:.1f} %",
        (last["training_seconds"], 100.0 * last["success"]), xytext=(-4, -14 if last["success"] > 0.3 else 8),
        textcoords="offset points", ha="right", fontsize=8, color=INK,
    )  # fmt: skip
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_bytes(path, content.getvalue())
