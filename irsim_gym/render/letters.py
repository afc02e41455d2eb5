"""Words and marks as masks, each drawn once and then only copied."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from irsim_gym.arraytypes import Bytes, Ints, Rays
from irsim_gym.errors import IrsimGymError
from irsim_gym.raster.sheets import new_sheet


@dataclass(frozen=True)
class Word:
    """A text as a mask, with its origin at the left end of its base line.

    Attributes:
        mask: Number of the mask.
        width: Width of what is seen of the text [pixel].
        advance: How far on the next text begins.
        height: Height of the line, at least that of "lp".
        foot: How far the line reaches below the base line.
    """

    mask: int
    width: float
    advance: float
    height: float
    foot: float


class Masks:
    """Opacities of words and marks, one after the other in one array.

    Attributes:
        levels: All opacities [0, 255], shape ``(n,)``.
        rows: First entry, width, height and place of the upper left corner of each, shape ``(n_masks, 5)``.
    """

    def __init__(self) -> None:
        self.levels: Bytes = np.zeros(0, np.uint8)
        self.rows: Ints = np.zeros((0, 5), np.int64)
        self._words: dict[tuple[str, float, bool], Word] = {}
        self._fonts: dict[tuple[float, bool], ImageFont.FreeTypeFont] = {}

    def add(self, mask: Bytes, left: int, top: int) -> int:
        """Add a mask ``(height, width)`` whose upper left corner is at ``left``, ``top``; return its number."""
        height, width = mask.shape
        self.rows = np.vstack([self.rows, np.array([[len(self.levels), width, height, left, top]])])
        self.levels = np.concatenate([self.levels, np.ascontiguousarray(mask).ravel()])
        return len(self.rows) - 1

    def drawn(self, reach: float, draw: Callable[[Bytes, Rays, Ints, float], None]) -> int:
        """Add what a function draws in white on a picture ``(side, side, 1)`` around its middle; return its number.

        Args:
            reach: How far it reaches from the middle [pixel].
            draw: It gets the picture, a sheet, a box and the place of the middle.
        """
        half = int(np.ceil(reach)) + 1
        picture, box = np.zeros((2 * half, 2 * half, 1), np.uint8), np.array([0, 0, 2 * half, 2 * half])
        draw(picture, new_sheet(2 * half, 2 * half), box, float(half))
        return self.add(picture[:, :, 0], -half, -half)

    def word(self, text: str, size: float, *, bold: bool = False) -> Word:
        """Return a text of a size [pixel] as a mask."""
        key = (text, size, bold)
        known = self._words.get(key)
        if known is None:
            known = self._words[key] = self._make(text, size, bold)
        return known

    def _make(self, text: str, size: float, bold: bool) -> Word:
        font = self._font(size, bold)
        _, low_top, _, low_foot = font.getbbox("lp", anchor="ls")
        left, top, right, foot = (round(value) for value in font.getbbox(text, anchor="ls"))
        image = Image.new("L", (max(right - left, 1), max(foot - top, 1)))
        ImageDraw.Draw(image).text((-left, -top), text, fill=255, font=font, anchor="ls")
        mask = self.add(np.asarray(image), left, top)
        lowest = max(float(low_foot), float(foot))
        advance = float(font.getlength(text))
        return Word(mask, float(right), advance, max(-float(low_top), -float(top)) + lowest, lowest)

    def _font(self, size: float, bold: bool) -> ImageFont.FreeTypeFont:
        key = (size, bold)
        if key not in self._fonts:
            file = font_file("DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf")
            self._fonts[key] = ImageFont.truetype(str(file), size, layout_engine=ImageFont.Layout.BASIC)
        return self._fonts[key]


def font_file(name: str) -> Path:
    """Return a font that comes with matplotlib, which need not be loaded for that.

    Raises:
        IrsimGymError: It is not there.
    """
    found = find_spec("matplotlib")
    for folder in (found.submodule_search_locations or ()) if found is not None else ():
        file = Path(folder) / "mpl-data" / "fonts" / "ttf" / name
        if file.is_file():
            return file
    raise IrsimGymError(f"no font {name!r}: it comes with matplotlib, which is not installed as a folder of files")
