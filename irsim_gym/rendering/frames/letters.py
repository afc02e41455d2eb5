"""Words and marks as masks, which are drawn once and then copied."""

import unicodedata
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont, features

from irsim_gym.base.arraytypes import Bytes, Ints
from irsim_gym.rendering.looks import fonts
from irsim_gym.rendering.raster.records import RasterCanvas
from irsim_gym.rendering.raster.sheets import new_sheet


@dataclass(frozen=True)
class Word:
    """A text as a mask, with its origin at the left end of its baseline.

    Attributes:
        mask: Number of the mask.
        width: Visible width of the text [pixel].
        advance: Distance to the origin of the next text [pixel].
        height: Height of the line, at least that of "lp" [pixel].
        foot: Depth of the line below the baseline [pixel].
    """

    mask: int
    width: float
    advance: float
    height: float
    foot: float


class Masks:
    """Opacities of words and marks, concatenated in one array.

    Attributes:
        levels: All opacities [0, 255], shape ``(n,)``.
        rows: First entry, width, height and upper left corner of each mask, shape ``(n_masks, 5)``.
    """

    def __init__(self) -> None:
        self.levels: Bytes = np.zeros(0, np.uint8)
        self.rows: Ints = np.zeros((0, 5), np.int64)
        self._words: dict[tuple[str, float, bool], Word] = {}
        self._fonts: dict[tuple[Path, float, ImageFont.Layout], ImageFont.FreeTypeFont] = {}

    def add(self, mask: Bytes, left: int, top: int) -> int:
        """Add a mask ``(height, width)`` with its upper left corner at ``left``, ``top``, and return its number."""
        height, width = mask.shape
        # The mask begins where the opacities so far end.
        self.rows = np.vstack([self.rows, np.array([[len(self.levels), width, height, left, top]])])
        self.levels = np.concatenate([self.levels, np.ascontiguousarray(mask).ravel()])
        return len(self.rows) - 1

    def drawn(self, reach: float, draw: Callable[[RasterCanvas, float], None]) -> int:
        """Add a mask that a function draws in white on a picture ``(side, side, 1)``, and return its number.

        Args:
            reach: Extent of the mask from the middle [pixel].
            draw: Draws the mask; gets what to paint on and the coordinate of the middle.
        """
        half = int(np.ceil(reach)) + 1
        picture, box = np.zeros((2 * half, 2 * half, 1), np.uint8), np.array([0, 0, 2 * half, 2 * half])
        draw(RasterCanvas(picture, new_sheet(2 * half, 2 * half), box), float(half))
        return self.add(picture[:, :, 0], -half, -half)

    def word(self, text: str, size: float, *, bold: bool = False) -> Word:
        """Return a text of a size [pixel] as a mask."""
        key = (text, size, bold)
        mask = self._words.get(key)
        if mask is None:
            mask = self._words[key] = self._make(text, size, bold)
        return mask

    def _make(self, text: str, size: float, bold: bool) -> Word:
        usual_font = fonts.usual(bold=bold)
        _, low_top, _, low_foot = self._font(usual_font, size).getbbox("lp", anchor="ls")
        written = ImageFont.Layout.RAQM if _runs_left(text) and features.check("raqm") else ImageFont.Layout.BASIC
        placed, advance = list[tuple[float, str, ImageFont.FreeTypeFont]](), 0.0
        for part, file in fonts.runs(text, bold=bold) or (("", usual_font),):
            font = self._font(file, size, written)
            placed.append((advance, part, font))
            advance += float(font.getlength(part))
        # Boxes relative to the left end of the baseline: columns to the right, rows downwards.
        boxes = [np.add(font.getbbox(part, anchor="ls"), (x, 0, x, 0)) for x, part, font in placed]
        left, top = (round(value) for value in np.min(boxes, axis=0)[:2].tolist())
        right, foot = (round(value) for value in np.max(boxes, axis=0)[2:].tolist())
        image = Image.new("L", (max(right - left, 1), max(foot - top, 1)))
        for x, part, font in placed:
            ImageDraw.Draw(image).text((x - left, -top), part, fill=255, font=font, anchor="ls")
        mask = self.add(np.asarray(image), left, top)
        lowest = max(float(low_foot), float(foot))
        return Word(mask, float(right), advance, max(-float(low_top), -float(top)) + lowest, lowest)

    def _font(
        self, file: Path, size: float, layout: ImageFont.Layout = ImageFont.Layout.BASIC
    ) -> ImageFont.FreeTypeFont:
        key = file, size, layout
        if key not in self._fonts:
            self._fonts[key] = ImageFont.truetype(str(file), size, layout_engine=layout)
        return self._fonts[key]


def _runs_left(text: str) -> bool:
    """Return whether a text has letters of a right-to-left script."""
    return not text.isascii() and any(unicodedata.bidirectional(letter) in ("R", "AL") for letter in text)
