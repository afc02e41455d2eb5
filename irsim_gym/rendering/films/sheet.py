"""Contact sheets: moments of an episode in one picture."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from irsim_gym.base.arraytypes import Bytes, Ints
from irsim_gym.rendering.films.film import caption_strip
from irsim_gym.rendering.looks import theme
from irsim_gym.rendering.looks.colours import colour
from irsim_gym.rendering.looks.files import whole_file
from irsim_gym.rendering.looks.packing import PackedFrame
from irsim_gym.rendering.looks.tiles import grid
from irsim_gym.rendering.scene.frame_layout import REFERENCE_SIDE

MOMENTS = 12
FINENESS = 8
WIDEST = 1800
"""Maximum width of a sheet [pixels]."""
READABLE = 0.8
"""Minimum size of a frame in a sheet, relative to a frame of about 600 x 600."""


class Moments:
    """Frames of evenly spaced moments of an episode of unknown length.

    Only frames at multiples of a stride are drawn. The stride doubles whenever there are more than ``FINENESS`` times
    ``count`` of them, so that each moment is off by at most an eighth of the spacing.

    Args:
        count: Number of frames, at least 2.

    Raises:
        ValueError: If ``count`` is below 2.
    """

    def __init__(self, count: int = MOMENTS) -> None:
        if count < 2:
            raise ValueError(f"a sheet shows at least 2 moments, got {count}")
        self._count, self._stride, self._number = count, 1, 0
        self._kept: list[tuple[int, PackedFrame]] = []
        self._latest: Callable[[], Bytes] | None = None

    def offer(self, draw: Callable[[], Bytes]) -> None:
        """Offer the frame of the next moment; it is drawn now, at the end if it is the last one, or not at all."""
        self._latest = draw
        if self._number % self._stride == 0:
            self._kept.append((self._number, PackedFrame.of(draw())))
            self._latest = None
            if len(self._kept) > FINENESS * self._count:
                self._kept = self._kept[::2]
                self._stride *= 2
        self._number += 1

    def frames(self) -> list[Bytes]:
        """Return the frames, including the first and last moment; all frames if there are fewer than ``count``.

        Raises:
            ValueError: If no frame was offered.
        """
        if not self._number:
            raise ValueError("an episode needs at least one frame")
        if self._latest is not None:
            self._kept.append((self._number - 1, PackedFrame.of(self._latest())))
            self._latest = None
        moments = np.array([moment for moment, _ in self._kept])
        return [self._kept[k][1].frame() for k in nearest(moments, spaced(self._number, self._count))]


def spaced(number: int, count: int) -> Ints:
    """Return ``count`` evenly spaced moments from 0 to ``number - 1``, or all if there are fewer."""
    return np.unique(np.rint(np.linspace(0, number - 1, min(number, count))).astype(np.int64))


def nearest(known: Ints, wanted: Ints) -> list[int]:
    """Return the indices of the numbers in ``known`` (ascending) that are nearest to those in ``wanted``, each once."""
    places: list[int] = np.unique(np.abs(known[:, None] - wanted[None]).argmin(axis=0)).tolist()
    return places


def contact_sheet(episodes: Sequence[Sequence[Bytes]], captions: Sequence[str], columns: int | None = None) -> Bytes:
    """Arrange the frames of episodes in rows, one episode below the other.

    Args:
        episodes: Frames of each episode, uint8 ``(height, width, 3)``, all of one shape.
        captions: Text above each episode; an empty text takes no room.
        columns: Frames per row; None for as many as stay readable and fill the rows well.

    Returns:
        The sheet, uint8, at most ``WIDEST`` pixels wide.
    """
    most = max(len(frames) for frames in episodes)
    wide = min(columns or _columns(most, episodes[0][0].shape[:2]), most)
    parts = []
    for frames, caption in zip(episodes, captions, strict=True):
        picture = grid([reduced(frame, WIDEST // wide) for frame in frames], wide)
        strip = (
            caption_strip(caption, picture.shape[1], picture.shape[1] / len(frames[:wide])) if caption else picture[:0]
        )
        parts.append(np.vstack([strip, picture]))
    width = max(part.shape[1] for part in parts)
    paper = np.round(colour(theme.PAPER, 1.0)[:3]).astype(np.uint8)
    rows = []
    for part in parts:
        row = np.empty((part.shape[0], width, 3), np.uint8)
        row[:], row[:, : part.shape[1]] = paper, part
        rows.append(row)
    return np.vstack(rows)


def reduced(frame: Bytes, width: int) -> Bytes:
    """Return a frame reduced to at most ``width`` pixels in width."""
    if frame.shape[1] <= width:
        return frame
    size = width, round(width * frame.shape[0] / frame.shape[1])
    return np.asarray(Image.fromarray(frame).resize(size, Image.Resampling.LANCZOS))


def _columns(count: int, shape: tuple[int, ...]) -> int:
    """Return a number of columns that keeps frames ``(height, width)`` readable and the last row full."""
    height, width = shape
    # Of any proportions, a frame has the area of a square of REFERENCE_SIDE: that fixes the width of readable text.
    least = READABLE * REFERENCE_SIDE * math.sqrt(width / height)
    most = max(int(WIDEST / min(width, least)), 1)
    # The fewest empty cells in the last row, then the most columns.
    return count if count <= most else min(range(max(most - 1, 1), most + 1), key=lambda k: (-count % k, -k))


def save_sheet(picture: Bytes, path: Path) -> Path:
    """Write a picture atomically to a file, in the format of its suffix, such as ``.png``."""
    with whole_file(path) as part:
        Image.fromarray(picture).save(part)
    return path
