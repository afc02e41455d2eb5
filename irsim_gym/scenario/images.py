"""Which images a body may be drawn with."""

from __future__ import annotations

from pathlib import Path

from irsim_gym.errors import suggestion
from irsim_gym.scenario.messages import show

DOCUMENTED = ("car_green.png", "car_blue.png", "car_red.png", "diff_robot0.png", "diff_robot1.png")
SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".gif", ".tif", ".tiff", ".webp")


def image_problem(name: str, scenario_file: str) -> str:
    """Return what is wrong with a ``description``; empty for a documented name and for an image file that exists.

    Args:
        name: The documented name, or a path: absolute, or beside the scenario file.
        scenario_file: Path of that file; empty for a mapping, whose paths begin at the working directory.
    """
    if name in DOCUMENTED:
        return ""
    file = Path(scenario_file).parent / name
    try:
        is_there = file.is_file()
    except (OSError, ValueError):  # too long a name, or one with a null character
        is_there = False
    if not is_there:
        known = f"; known: {', '.join(DOCUMENTED)}, or a file beside the scenario"
        return f"no image {show(name)}{suggestion(name[:40], DOCUMENTED) or known}"
    if file.suffix.lower() not in SUFFIXES:
        return f"must be an image ({', '.join(SUFFIXES)}), got {show(name)}"
    return ""
