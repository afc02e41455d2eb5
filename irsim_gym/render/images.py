"""Images of bodies: from a file to pixels."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from irsim_gym.arraytypes import Bytes
from irsim_gym.errors import IrsimGymError

LONGEST_SIDE = 512
"""Larger images are reduced to this many pixels: nobody sees more of them on a frame."""
REMEMBERED = 32


def load_image(file: Path) -> Bytes:
    """Return an image file's colours and opacity, uint8, shape ``(height, width, 4)``, row 0 at the top; read-only.

    Raises:
        IrsimGymError: If the file cannot be read as an image.
    """
    try:
        return _read(file, file.stat().st_mtime_ns)
    except (OSError, ValueError, SyntaxError) as error:
        raise IrsimGymError(f"'{file}' cannot be read as an image: {error}") from None


@functools.lru_cache(maxsize=REMEMBERED)
def _read(file: Path, changed: int) -> Bytes:
    """Read a file; another time of its last change makes it be read anew."""
    from PIL import Image

    with Image.open(file) as found:
        image = found.convert("RGBA")
    share = LONGEST_SIDE / max(image.size)
    if share < 1.0:
        size = max(round(share * image.width), 1), max(round(share * image.height), 1)
        image = image.convert("RGBa").resize(size, Image.Resampling.BOX).convert("RGBA")
    pixels = np.array(image, np.uint8)
    pixels.setflags(write=False)
    return pixels
