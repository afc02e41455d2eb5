"""image: a map from an image, whose dark pixels are occupied."""

from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np

from irsim_gym.base.errors import OptionError, UnreadableFileError
from irsim_gym.base.outside_files import reading
from irsim_gym.bodies.maps.level import CellsKind
from irsim_gym.simulator.world.names import Flags, Floats, kind, option

GRAY = (0.2989, 0.5870, 0.1140)
"""Weights of red, green and blue, as in IR-SIM."""
OCCUPIED_BELOW = 0.5
"""Brightness (0 to 1) below which a pixel is occupied."""
STRIP = 256
"""Number of image rows whose brightness is computed at a time."""


@kind
class ImageMap(CellsKind):
    """Each pixel is a cell, at most 4,000,000 after ``mdownsample``; the image is stretched over the world."""

    is_random: ClassVar[bool] = False

    path: str = option(
        min_length=1,
        meaning="Image file (PNG, JPEG, ...). It is looked for as given, beside the scenario, among the shipped maps, "
        "then among those of an installed ir-sim.",
    )

    def occupied(self, width: float, height: float, name: str, find: Callable[[str], Path]) -> Flags:
        """Return which cells are occupied, shape ``(columns, rows)``: those darker than half.

        Raises:
            OptionError: If the file does not exist or is not an image.
        """
        # Images have rows from the top, maps columns from the left with rows from the bottom.
        return np.ascontiguousarray(np.fliplr(read_dark(find(self.path)).T))


def read_dark(file: Path) -> Flags:
    """Return which pixels of an image are darker than half, row by row from the top; transparency is ignored.

    Raises:
        OptionError: If the file cannot be read.
    """
    from PIL import Image

    try:
        with reading(file, "image"), Image.open(file) as picture:
            if picture.mode in ("1", "L", "I", "F") or picture.mode.startswith("I;16"):
                return _single_channel(np.array(picture)) < OCCUPIED_BELOW
            pixels = np.asarray(picture.convert("RGB"))
    except UnreadableFileError as error:
        raise OptionError("path", f"'{file}' cannot be read as an image: {error.reason}") from None
    dark = np.zeros(pixels.shape[:2], np.bool_)
    # In strips, because brightness takes 32 bytes a pixel: gigabytes for all of a large picture.
    for row in range(0, len(pixels), STRIP):
        dark[row : row + STRIP] = pixels[row : row + STRIP] / 255.0 @ np.array(GRAY) < OCCUPIED_BELOW
    return dark


def _single_channel(pixels: Floats) -> Floats:
    if pixels.dtype == np.bool_:
        return pixels.astype(np.float64)
    # Images of 16 and 32 bits count up to 65535.
    greatest = 255.0 if pixels.dtype == np.uint8 else 65535.0
    return np.asarray(pixels / greatest, np.float64)
