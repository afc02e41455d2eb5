"""Loads images of bodies, and writes pictures."""

import functools
from pathlib import Path

import numpy as np

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.outside_files import reading
from irsim_gym.rendering.looks.files import whole_file

LONGEST_SIDE = 512
"""Maximum side of an image [pixel]; larger ones are reduced, since frames do not show more detail."""
REMEMBERED = 32


def load_image(file: Path) -> Bytes:
    """Return the pixels of an image file, RGBA, uint8, shape ``(height, width, 4)``, row 0 at the top, read-only.

    Raises:
        UnreadableFileError: If the file cannot be read as an image.
    """
    with reading(file, "image"):
        return _read(file, file.stat().st_mtime_ns)


@functools.lru_cache(maxsize=REMEMBERED)
def _read(file: Path, changed: int) -> Bytes:
    """Read a file; ``changed``, the time of its last change, is part of the cache's key."""
    from PIL import Image

    with Image.open(file) as picture:
        image = picture.convert("RGBA")
    share = LONGEST_SIDE / max(image.size)
    if share < 1.0:
        size = max(round(share * image.width), 1), max(round(share * image.height), 1)
        image = image.convert("RGBa").resize(size, Image.Resampling.BOX).convert("RGBA")
    pixels = np.array(image, np.uint8)
    pixels.setflags(write=False)
    return pixels


def save_picture(picture: Bytes, path: Path) -> Path:
    """Write a picture atomically to a file, in the format of its suffix, such as ``.png``."""
    from PIL import Image

    with whole_file(path) as part:
        Image.fromarray(picture).save(part)
    return path
