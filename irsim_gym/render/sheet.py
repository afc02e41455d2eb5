"""A whole episode in one picture: a sheet of its moments, or one picture with the ways that bodies went."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.colors import to_hex, to_rgb
from PIL import Image

from irsim_gym.arraytypes import Bytes, Ints
from irsim_gym.render import theme
from irsim_gym.render.files import whole_file
from irsim_gym.render.film import caption_strip
from irsim_gym.render.layout import REFERENCE_SIDE, Layout
from irsim_gym.render.outlines import NOTHING
from irsim_gym.render.packing import PackedFrame
from irsim_gym.render.replay import Recording
from irsim_gym.render.scene import BodyView, LabelView, Scene, TrailView
from irsim_gym.render.stage import Stage
from irsim_gym.render.styles import TOP, BodyStyle
from irsim_gym.render.tiles import grid

MOMENTS = 12
FINENESS = 8
WIDEST = 1800
"""A sheet is reduced to so many pixels."""
READABLE = 0.8
"""Frames stand side by side as long as none becomes smaller than this share of one that is about 600 x 600."""
GHOSTS = 8
COLOURS = "viridis"
WAY_WIDTH = 2.4
"""Width of a way [pixels of a frame of 600 x 600]."""
PIECES = 60
LABEL_ROOM = 24.0
"""How far apart two times have to be so that both are written [pixels of a frame of 600 x 600]."""
OTHERS = 0.12
"""Opacity of bodies that are nobody's."""


class Moments:
    """Frames of evenly spaced moments of an episode whose length is not known beforehand.

    Only few are drawn: those at multiples of a stride that doubles whenever there are ``FINENESS`` times as many as are
    wanted, so that each is off by an eighth of their distance at most.

    Args:
        count: How many are wanted, at least 2.

    Raises:
        ValueError: Fewer are wanted.
    """

    def __init__(self, count: int = MOMENTS) -> None:
        if count < 2:
            raise ValueError(f"a sheet shows at least 2 moments, got {count}")
        self._count, self._stride, self._number = count, 1, 0
        self._kept: list[tuple[int, PackedFrame]] = []
        self._latest: Callable[[], Bytes] | None = None

    def offer(self, draw: Callable[[], Bytes]) -> None:
        """Offer the frame of the next moment, to be drawn now or, if it is the last one, at the end."""
        self._latest = draw
        if self._number % self._stride == 0:
            self._kept.append((self._number, PackedFrame.of(draw())))
            self._latest = None
            if len(self._kept) > FINENESS * self._count:
                self._kept = self._kept[::2]
                self._stride *= 2
        self._number += 1

    def frames(self) -> list[Bytes]:
        """Return the frames, the first and the last moment among them; all where there are fewer than wanted.

        Raises:
            ValueError: None was offered.
        """
        if not self._number:
            raise ValueError("an episode needs at least one frame")
        if self._latest is not None:
            self._kept.append((self._number - 1, PackedFrame.of(self._latest())))
            self._latest = None
        moments = np.array([moment for moment, _ in self._kept])
        return [self._kept[k][1].frame() for k in nearest(moments, spaced(self._number, self._count))]


def spaced(number: int, count: int) -> Ints:
    """Return ``count`` of the moments 0 to ``number - 1``, evenly spaced, or all where there are not so many."""
    return np.unique(np.rint(np.linspace(0, number - 1, min(number, count))).astype(np.int64))


def nearest(known: Ints, wanted: Ints) -> list[int]:
    """Return the places of those ascending numbers that are nearest to others, each once."""
    places: list[int] = np.unique(np.abs(known[:, None] - wanted[None]).argmin(axis=0)).tolist()
    return places


def contact_sheet(episodes: Sequence[Sequence[Bytes]], captions: Sequence[str], columns: int | None = None) -> Bytes:
    """Put the frames of episodes below each other, in rows.

    Args:
        episodes: Frames of each, uint8 ``(height, width, 3)``, all of one shape.
        captions: Text above each episode; an empty one leaves no room.
        columns: Frames in a row; None for as many as can be read, so that the rows are full.

    Returns:
        The sheet, uint8, at most ``WIDEST`` pixels wide.
    """
    most = max(len(frames) for frames in episodes)
    wide = min(columns or _columns(most, episodes[0][0].shape[:2]), most)
    parts = []
    for frames, caption in zip(episodes, captions, strict=True):
        picture = grid([_reduced(frame, WIDEST // wide) for frame in frames], wide)
        strip = (
            caption_strip(caption, picture.shape[1], picture.shape[1] / len(frames[:wide])) if caption else picture[:0]
        )
        parts.append(np.vstack([strip, picture]))
    width = max(part.shape[1] for part in parts)
    paper = np.round(np.multiply(to_rgb(theme.PAPER), 255.0)).astype(np.uint8)
    rows = []
    for part in parts:
        row = np.empty((part.shape[0], width, 3), np.uint8)
        row[:], row[:, : part.shape[1]] = paper, part
        rows.append(row)
    return np.vstack(rows)


def strobe(recording: Recording, layout: Layout, count: int = GHOSTS) -> Scene:
    """Return the last scene of an episode with the ways of its agents, and where bodies stood on the way.

    A way is coloured by time, from dark to light, and the first agent's outlines bear the time.

    Args:
        recording: The episode; its agents' ways are drawn, or those of all robots where nobody is named.
        layout: Where the picture shows the world.
        count: At how many moments bodies are drawn.
    """
    moments = spaced(len(recording), count)
    last = recording.last
    ways = [way for name in recording.agents for way in _way(recording, name, layout)]
    ghosts: list[BodyView] = []
    told: list[tuple[BodyView, float]] = []
    for moment in moments[:-1].tolist():
        for name, view in recording.moving(moment).items():
            is_agent = name in recording.agents
            faint = 0.18 + 0.42 * moment / max(len(recording) - 1, 1) if is_agent else OTHERS
            ghosts.append(replace(view, style=replace(view.style, alpha=faint * view.style.alpha), heading=NOTHING))
            if name == recording.agents[0]:
                told.append((view, recording.times[moment]))
    labels = (*last.labels, *_time_labels(told, LABEL_ROOM * layout.enlargement / layout.scale))
    return replace(last, scans=(), fields=(), trails=tuple(ways), ghosts=tuple(ghosts), labels=labels)


def _way(recording: Recording, name: str, layout: Layout) -> Iterator[TrailView]:
    """Yield the pieces of a body's way, each in the colour of its time."""
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


def _time_labels(told: Sequence[tuple[BodyView, float]], room: float) -> Iterator[LabelView]:
    """Yield the times beside a body; where it stood for longer, the first and the last of them.

    Args:
        told: The body, and the time [s], in order.
        room: How far apart two labels have to be [m].
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


def _stage(recording: Recording, layout: Layout, scene: Scene) -> Stage:
    look = recording.look
    return Stage(
        layout, titled=look["titled"], axis=look["axis"], show_title=look["title"], clipped=scene.center is None
    )


def _reduced(frame: Bytes, width: int) -> Bytes:
    """Return a frame that is not wider than so many pixels."""
    if frame.shape[1] <= width:
        return frame
    size = width, round(width * frame.shape[0] / frame.shape[1])
    return np.asarray(Image.fromarray(frame).resize(size, Image.Resampling.LANCZOS))


def _columns(count: int, shape: tuple[int, ...]) -> int:
    """Return a number of columns that lets frames ``(height, width)`` be read and leaves few cells of the last row."""
    height, width = shape
    least = READABLE * REFERENCE_SIDE * math.sqrt(width / height)
    most = max(int(WIDEST / min(width, least)), 1)
    return count if count <= most else min(range(max(most - 1, 1), most + 1), key=lambda k: (-count % k, -k))


def draw_strobe(recording: Recording, layout: Layout, count: int = GHOSTS) -> Bytes:
    """Return the picture of ``strobe``, uint8 ``(height, width, 3)``."""
    scene = strobe(recording, layout, count)
    return _stage(recording, layout, scene).draw(scene)


def save_strobe(
    recording: Recording, path: Path, layout: Layout, count: int = GHOSTS, dots_per_inch: float = 200.0
) -> Path:
    """Write the picture of ``strobe`` to a file, ``.png``, ``.pdf``, ``.svg`` or another that matplotlib writes."""
    scene = strobe(recording, layout, count)
    _stage(recording, layout, scene).save(
        scene, path, dots_per_inch, replace(recording.saved_figure, bbox_inches="standard")
    )
    return path


def save_sheet(picture: Bytes, path: Path) -> Path:
    """Write a picture to a file, in the format of its suffix, such as ``.png``; it is there only when it is whole."""
    with whole_file(path) as part:
        Image.fromarray(picture).save(part)
    return path
