"""Strobe figures: an episode in one figure, with paths coloured by time."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.figures.figure import Frame, save_figure, scene_figure
from irsim_gym.rendering.films.sheet import spaced
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.styles import TOP, BodyStyle
from irsim_gym.rendering.replay.replay_data import Recording
from irsim_gym.rendering.scene.frame_layout import Layout
from irsim_gym.rendering.scene.scene import DrawnBody, LabelView, Scene, TrailView
from irsim_gym.rendering.scene.shapes import NOTHING

GHOSTS = 8
COLOURS = "viridis"
WAY_WIDTH = 2.4
"""Width of a path [pixels of a frame of 600 x 600]."""
PIECES = 60
LABEL_ROOM = 24.0
"""Minimum distance between two written times [pixels of a frame of 600 x 600]."""
OTHERS = 0.12
"""Opacity of bodies that are not agents."""


def strobe(recording: Recording, layout: Layout, count: int = GHOSTS) -> Scene:
    """Return the last scene of an episode with the paths of its agents and earlier outlines of bodies.

    Paths are coloured by time, from dark to light, and the outlines of the first agent are labelled with their time.

    Args:
        recording: The episode with its agents.
        layout: Layout of the picture.
        count: Number of moments at which bodies are drawn.
    """
    moments = spaced(len(recording), count)
    last = recording.last
    ways = [way for name in recording.agents for way in _way(recording, name, layout)]
    ghosts: list[DrawnBody] = []
    told: list[tuple[DrawnBody, float]] = []
    for moment in moments[:-1].tolist():
        for name, view in recording.moving(moment).items():
            is_agent = name in recording.agents
            faint = 0.18 + 0.42 * moment / max(len(recording) - 1, 1) if is_agent else OTHERS
            ghosts.append(replace(view, style=replace(view.style, alpha=faint * view.style.alpha), heading=NOTHING))
            if recording.agents[:1] == (name,):
                told.append((view, recording.times[moment]))
    labels = (*last.labels, *_time_labels(told, LABEL_ROOM * layout.enlargement / layout.scale))
    return replace(last, scans=(), fields=(), trails=tuple(ways), ghosts=tuple(ghosts), labels=labels)


def _way(recording: Recording, name: str, layout: Layout) -> Iterator[TrailView]:
    """Yield the pieces of a body's path, each in the colour of its time."""
    views = [recording.moving(moment).get(name) for moment in range(len(recording))]
    points = np.array([(np.nan, np.nan) if view is None else view.anchor for view in views])
    cuts = np.unique(np.rint(np.linspace(0, len(points) - 1, PIECES + 1)).astype(int))
    colours, order = matplotlib.colormaps[COLOURS], max((view.style.order for view in views if view), default=TOP)
    width = WAY_WIDTH * layout.enlargement / layout.scale
    for first, last in pairwise(cuts.tolist()):
        piece = points[first : last + 1]
        piece = piece[~np.isnan(piece[:, 0])]
        if len(piece) > 1:
            colour = to_hex(colours(0.92 * 0.5 * (first + last) / max(len(points) - 1, 1)))
            style = BodyStyle(colour, trajectory_colour=colour, trajectory_width=width, trajectory_alpha=1.0)
            yield TrailView(piece, replace(style, trajectory_order=order))


def _time_labels(told: Sequence[tuple[DrawnBody, float]], room: float) -> Iterator[LabelView]:
    """Yield labels with the times of a body; where it stays for longer, with the first and the last time.

    Args:
        told: The body, and the time [s], in order.
        room: Minimum distance between two labels [m].
    """
    k = 0
    while k < len(told):
        view, begin = told[k]
        stay = k
        while stay + 1 < len(told) and np.hypot(*np.subtract(told[stay + 1][0].anchor, view.anchor)) < room:
            stay += 1
        words = f"{begin:.1f} s" if stay == k else f"{begin:.1f}\N{EN DASH}{told[stay][1]:.1f} s"
        look = replace(view.style, label_size=7.0, label_colour=theme.INK, label_halo=theme.CARD)
        style = replace(look, label_alpha=1.0, label_order=TOP)
        tops = [line[:, 1].max() for line in view.lines] + [y + radius for _, y, radius in view.discs.tolist()]
        yield LabelView(view.anchor[0], max(tops, default=view.anchor[1]) + 0.05, words, style)
        k = stay + 1


def _around(recording: Recording) -> Frame:
    look = recording.look
    return Frame(look["titled"], look["axis"], look["title"])


def _shown(scene: Scene, layout: Layout) -> Layout:
    return layout if scene.center is None else layout.centred(*scene.center)


def draw_strobe(recording: Recording, layout: Layout, count: int = GHOSTS) -> Bytes:
    """Return the picture of ``strobe``, uint8 ``(height, width, 3)``."""
    scene = strobe(recording, layout, count)
    canvas: Any = FigureCanvasAgg(scene_figure(scene, _shown(scene, layout), _around(recording)))
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def save_strobe(
    recording: Recording, path: Path, layout: Layout, count: int = GHOSTS, dots_per_inch: float = 200.0
) -> Path:
    """Write the picture of ``strobe`` to a file, ``.png``, ``.pdf``, ``.svg`` or another that matplotlib writes."""
    scene, options = strobe(recording, layout, count), replace(recording.saved_figure, bbox_inches="standard")
    save_figure(scene, _shown(scene, layout), _around(recording), path, options, dots_per_inch)
    return path
