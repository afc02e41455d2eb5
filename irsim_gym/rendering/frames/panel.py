"""A strip below a picture with status texts and the meaning of keys."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.rendering.looks import fonts, theme

SIZE, GAP, PAD, ROW = 11.5, 12.0, 4.0, 21.0
"""Type size, gap between keys, padding of a key, and row height [pixel], without enlargement."""
Word = tuple[str, str]
"""A text with its colour."""


@dataclass(frozen=True)
class Told:
    """The status texts of the strip.

    Attributes:
        left: Words at the left of the first row.
        right: Words at its right end.
    """

    left: tuple[Word, ...] = ()
    right: tuple[Word, ...] = ()


class Panel:
    """Draws a row of words and rows of keys below pictures of a fixed width.

    Args:
        width: Width of the pictures [pixel].
        keys: Keys with their effects.
        enlargement: Size of the type relative to that for a picture of 600 x 600.
    """

    def __init__(self, width: int, keys: Sequence[tuple[str, str]], enlargement: float = 1.0) -> None:
        self._scale = enlargement
        self._type, self._bold = (
            ImageFont.truetype(fonts.usual(bold=bold), round(SIZE * enlargement)) for bold in (False, True)
        )
        self._width, self._margin = width, round(12 * enlargement)
        rows = self._rows(keys)
        self._base = self._empty(rows)
        self._known: tuple[Told, Bytes] = Told(), np.asarray(self._base)

    def below(self, picture: Bytes, told: Told) -> Bytes:
        """Return a picture ``(height, width, 3)`` with the strip, of even height, below it."""
        if told != self._known[0]:
            self._known = told, np.asarray(self._with_words(told))
        return np.concatenate([picture, self._known[1]])

    def _length(self, text: str) -> float:
        return float(self._type.getlength(text))

    def _rows(self, keys: Sequence[tuple[str, str]]) -> list[list[tuple[str, str]]]:
        """Return the keys in rows, with as many per row as fit."""
        rows: list[list[tuple[str, str]]] = [[]]
        left = 0.0
        for key, effect in keys:
            wide = self._length(key) + self._length(effect) + (2 * PAD + PAD + GAP) * self._scale
            if rows[-1] and left + wide > self._width - 2 * self._margin + GAP * self._scale:
                rows.append([])
                left = 0.0
            rows[-1].append((key, effect))
            left += wide
        return rows

    def _empty(self, rows: list[list[tuple[str, str]]]) -> Image.Image:
        """Return the strip with keys but without words."""
        scale = self._scale
        height = round((ROW * (len(rows) + 1) + 14) * scale)
        image = Image.new("RGB", (self._width, height + height % 2), theme.PAPER)
        draw = ImageDraw.Draw(image)
        draw.line([(self._margin, 0), (self._width - self._margin, 0)], fill=theme.RULE)
        for i, row in enumerate(rows):
            x, y = float(self._margin), (ROW * (i + 1.5) + 8) * scale
            for key, effect in row:
                wide = self._length(key) + 2 * PAD * scale
                box = (x, y - 0.40 * ROW * scale, x + wide, y + 0.40 * ROW * scale)
                draw.rounded_rectangle(box, radius=3 * scale, fill=theme.CARD, outline=theme.RULE)
                draw.text((x + PAD * scale, y), key, font=self._type, fill=theme.INK, anchor="lm")
                x += wide + PAD * scale
                draw.text((x, y), effect, font=self._type, fill=theme.INK_LIGHT, anchor="lm")
                x += self._length(effect) + GAP * scale
        return image

    def _with_words(self, told: Told) -> Image.Image:
        image = self._base.copy()
        draw = ImageDraw.Draw(image)
        x, y = float(self._margin), (0.5 * ROW + 6) * self._scale
        for i, (text, colour) in enumerate(told.left):
            font = self._bold if i == 0 else self._type
            draw.text((x, y), text, font=font, fill=colour, anchor="lm")
            x += float(font.getlength(text)) + GAP * self._scale
        x = self._width - self._margin
        for text, colour in reversed(told.right):
            draw.text((x, y), text, font=self._type, fill=colour, anchor="rm")
            x -= self._length(text) + GAP * self._scale
        return image
