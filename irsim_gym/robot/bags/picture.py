"""The picture of a bag that was replayed through an export."""

from pathlib import Path

import numpy as np

from irsim_gym.evaluation.protocol.tables import write_figure
from irsim_gym.robot.bags.check import BagCheck, without_numbers

RECORDED, REPLAYED, STOP, INK = "#9aa5b1", "#2166ac", "#b2182b", "#1f2933"


def draw_check(path: Path, found: BagCheck, title: str) -> None:
    """Draw commands beside the recorded ones, ages of messages, lost beams, and stops with their reasons.

    Args:
        path: PNG file to write.
        found: The replay.
        title: Title.
    """
    from matplotlib.figure import Figure

    count = len(found.components)
    figure = Figure(figsize=(9.0, 1.7 * (count + 2)), dpi=120, layout="constrained")
    panels = figure.subplots(count + 2, 1, sharex=True)
    for k, name in enumerate(found.components):
        panels[k].step(found.times, found.recorded[:, k], where="post", color=RECORDED, lw=3.5, label="recorded")
        panels[k].step(found.times, found.commands[:, k], where="post", color=REPLAYED, lw=1.2, label="export")
        panels[k].set_ylabel(name)
    for name, age, style in zip(("scan", "odometry"), found.ages.T, ("-", "--"), strict=True):
        panels[-2].plot(found.times, np.where(np.isfinite(age), age, np.nan), style, color=INK, lw=1.2, label=name)
    panels[-1].plot(found.lost[:, 0], 100.0 * found.lost[:, 1], color=INK, lw=1.2)
    for panel, label, least in ((panels[-2], "age [s]", 0.1), (panels[-1], "lost beams [%]", 10.0)):
        panel.set(ylabel=label, ylim=(0.0, max(panel.get_ylim()[1], least)))
    panels[-1].set_xlabel("time [s]")
    reasons: dict[str, str] = {}
    for first, last, reason in found.stops():
        for panel in panels:
            panel.axvspan(first, last, color=STOP, alpha=0.18, lw=1.0)
        if without_numbers(reason) not in reasons:
            mark = chr(ord("A") + len(reasons))
            reasons[without_numbers(reason)] = f"{mark}  {reason}"
            panels[0].annotate(mark, (first, 1.02), xycoords=("data", "axes fraction"), fontsize=8, color=STOP)
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
    for panel in (panels[0], panels[-2]):
        panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=2, fontsize=8, frameon=False)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, color=INK)
    stops = "\n".join(["stands still (red); a letter stands at the first time:", *reasons.values()]) if reasons else ""
    figure.supxlabel(stops, x=0.01, ha="left", fontsize=8, color=STOP)
    write_figure(path, figure)
