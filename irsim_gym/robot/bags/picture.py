"""The picture of a bag that was replayed through an export."""

from pathlib import Path

import numpy as np

from irsim_gym.evaluation.protocol.tables import write_figure
from irsim_gym.robot.bags.check import BagCheck

RECORDED, REPLAYED, STOP, INK = "#9aa5b1", "#2166ac", "#b2182b", "#1f2933"
COMPONENTS = ("ahead [m/s]", "left [m/s]", "turn [rad/s]")


def draw_check(path: Path, check: BagCheck, title: str) -> None:
    """Draw commands beside the recorded ones, ages of messages, lost beams, and stops with their reasons.

    Args:
        path: PNG file to write.
        check: The replay.
        title: Title.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 8.5), dpi=120, layout="constrained")
    used = np.flatnonzero(np.nan_to_num([check.commands, check.recorded]).any(axis=(0, 1)))
    panels, reasons = figure.subplots(len(used) + 2, 1, sharex=True), dict[str, str]()
    for panel, k in zip(panels, used, strict=False):
        panel.step(check.times, check.recorded[:, k], where="post", color=RECORDED, lw=3.5, label="recorded")
        panel.step(check.times, check.commands[:, k], where="post", color=REPLAYED, lw=1.2, label="export")
        panel.set_ylabel(COMPONENTS[k])
    for name, age, style in zip(("scan", "odometry"), check.ages.T, ("-", "--"), strict=True):
        panels[-2].plot(check.times, np.where(np.isfinite(age), age, np.nan), style, color=INK, lw=1.2, label=name)
    panels[-1].plot(*check.lost.T * [[1.0], [100.0]], color=INK, lw=1.2)
    for panel, label, least in ((panels[-2], "age [s]", 0.1), (panels[-1], "lost beams [%]", 10.0)):
        panel.set(ylabel=label, xlabel="time [s]" * (panel is panels[-1]), ylim=(0.0, max(panel.get_ylim()[1], least)))
    for first, last, reason, words in check.stops():
        reasons.setdefault(words, f"{first:.2f} s: {reason}")
        for panel in panels:
            panel.axvspan(first, last, color=STOP, alpha=0.18, lw=1.0)
    for panel in panels:
        panel.spines[["top", "right"]].set_visible(False)
    for panel in {panels[0], panels[-2]}:
        panel.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=2, fontsize=8, frameon=False)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10, color=INK)
    told = "\n".join(["red: stands still; when each reason came first:", *reasons.values()])
    figure.supxlabel(told if reasons else "", x=0.01, ha="left", fontsize=8, color=STOP)
    write_figure(path, figure)
