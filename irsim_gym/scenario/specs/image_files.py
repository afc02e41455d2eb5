"""Finds and checks the image files of bodies."""

from pathlib import Path

from irsim_gym.base.errors import UnreadableFileError, suggestion
from irsim_gym.base.outside_files import reading
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.text.messages import show

DEFAULT_CAR = "car_green.png"
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".webp")


def image_problem(name: str, scenario_file: str) -> str:
    """Return what is wrong with a ``description``; empty for a shipped image or a readable image file.

    Args:
        name: Name of a shipped image, or a path: absolute, or relative to the scenario file.
        scenario_file: Path of the scenario file; empty for a mapping, whose paths start at the working directory.
    """
    shipped, file = library.assets("images"), library.asset("images", name, scenario_file)
    try:
        is_there = file.is_file()
    except (OSError, ValueError):  # too long a name, or one with a null character
        is_there = False
    if not is_there:
        known = f"; shipped: {', '.join(shipped)}; or name a file beside the scenario"
        return f"no image {show(name)}{suggestion(name[:40], shipped) or known}"
    if file.suffix.lower() not in SUFFIXES:
        return f"must be an image ({', '.join(SUFFIXES)}), got {show(name)}"
    return "" if name in shipped else _unreadable(file, name)


def _unreadable(file: Path, name: str) -> str:
    """Return why a file cannot be read as an image; empty if it can."""
    from PIL import Image

    try:
        with reading(file, "image"), Image.open(file):
            return ""
    except UnreadableFileError:
        return f"{show(name)} cannot be read as an image"
