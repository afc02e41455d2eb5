"""The command ``irsim-gym doctor``: report what is installed, what works, and what commands still need."""

import importlib
import importlib.util
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path

from rich.console import Console
from rich.text import Text

from irsim_gym.base.extras import EXTRAS, missing, pip_command
from irsim_gym.base.version import __version__

PACKAGES = (
    *("numpy", "numba", "llvmlite", "gymnasium", "pettingzoo", "pydantic"),
    *("scipy", "shapely", "matplotlib", "Pillow", "imageio", "moviepy"),
)
"""Packages whose versions a bug report should name."""
OPTIONAL = {
    "train": "train, demo, policies export; evaluate and record with a policy.zip",
    "contrib": "train --algorithm tqc",
    "tune": "tune",
    "rllib": "train --engine rllib, tune --address",
    "robot": "export",
    "play": "play, faster keys",
}
"""Commands that need an extra, by extra."""
TOOLKITS = ("tkinter", "PySide6", "PyQt6", "PySide2", "PyQt5", "gi", "wx")
"""Modules that matplotlib can open windows with."""


@dataclass(frozen=True)
class Finding:
    """The result of one check.

    Attributes:
        topic: What was checked.
        found: Result of the check.
        advice: What to do about it; empty if there is nothing to do.
        is_wrong: Whether something does not work that every command needs.
    """

    topic: str
    found: str
    advice: str = ""
    is_wrong: bool = False


def examine() -> list[Finding]:
    """Check the installation and return the results. Nothing is changed, and nothing is compiled."""
    machine = [_compiler(), _cache(), _threads(), _graphics_card(), _display(), _films()]
    return [*_versions(), *_packages(), *machine, *_optional()]


def print_examination() -> bool:
    """Print a line for each check, with advice below it, and return whether everything required works."""
    findings, screen = examine(), Console(highlight=False)
    width = max(len(one.topic) for one in findings)
    for one in findings:
        lines = [f"{one.topic:<{width}}  {one.found}"] + [f"{'':<{width}}  -> {one.advice}"] * bool(one.advice)
        screen.print(Text("\n".join(lines), style="red" if one.is_wrong else ""), soft_wrap=True)
    return not any(one.is_wrong for one in findings)


def _versions() -> list[Finding]:
    place = Path(__file__).parents[2]
    return [
        Finding("irsim_gym", f"{__version__}, in {place}"),
        Finding("Python", f"{platform.python_version()}, {sys.executable}"),
        Finding("system", platform.platform()),
    ]


def _packages() -> list[Finding]:
    found = []
    for name in PACKAGES:
        try:
            found.append(Finding(name, version(name)))
        except PackageNotFoundError:
            found.append(Finding(name, "not installed", f"pip install {name}", is_wrong=True))
    return found


def _compiler() -> Finding:
    from irsim_gym.base.kernels import hooks

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return Finding("compiled kernels", "off: NUMBA_DISABLE_JIT is set", "unset it: plain Python is far slower")
    if hooks.is_plain():
        return Finding("compiled kernels", f"Numba's plain way: {hooks.SWITCH} is set", "unset it for faster starts")
    gone = hooks.missing()
    if gone:
        return Finding("compiled kernels", f"Numba's plain way: this Numba lacks {', '.join(gone)}")
    return Finding("compiled kernels", "on")


def _cache() -> Finding:
    from irsim_gym.base.compiled.folder import cache_folder

    folder = cache_folder()
    if folder is None:
        advice = "set NUMBA_CACHE_DIR to a folder that you may write, or every process compiles anew"
        return Finding("cache of kernels", "no folder can be written", advice)
    files = [file.stat().st_size for file in folder.glob("*.nbc")]
    advice = "" if files else "irsim-gym warmup compiles beforehand"
    return Finding("cache of kernels", f"{folder}: {len(files)} files, {sum(files) / 1e6:.1f} MB", advice)


def _threads() -> Finding:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    share = f"; num_threads={usable} shares worlds among them" if usable > 1 else ""
    return Finding("processors", f"{usable} of {os.cpu_count()}{share}")


def _graphics_card() -> Finding:
    if importlib.util.find_spec("torch") is None:
        return Finding("graphics card", "unknown without torch")
    import torch

    if torch.cuda.is_available():
        return Finding("graphics card", torch.cuda.get_device_name(0), "train --device cuda uses it")
    if torch.backends.mps.is_available():
        return Finding("graphics card", "Apple's, through Metal", "train --device mps uses it")
    return Finding("graphics card", "none for PyTorch; nothing needs one")


def _display() -> Finding:
    shown = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.platform.startswith("linux") and not shown:
        advice = 'play and render_mode="human" need one; films, pictures and pages do not'
        return Finding("display", "none: DISPLAY and WAYLAND_DISPLAY are not set", advice)
    found = [name for name in TOOLKITS if importlib.util.find_spec(name) is not None]
    if not found and sys.platform != "darwin":
        advice = 'play and render_mode="human" need one: python3-tk of the system, or pip install pyside6'
        return Finding("display", f"{shown or 'there is one'}, but no toolkit for windows", advice)
    return Finding("display", f"{shown or 'there is one'}, with {found[0] if found else 'macosx'}")


def _films() -> Finding:
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        return Finding("films", "no ffmpeg", "pip install imageio-ffmpeg")
    imageio_ffmpeg = importlib.import_module("imageio_ffmpeg")  # it has no types
    try:
        return Finding("films", f"ffmpeg {imageio_ffmpeg.get_ffmpeg_version()}")
    except (RuntimeError, OSError) as error:
        advice = "record --out film.gif needs none; for .mp4 install ffmpeg, or name it in IMAGEIO_FFMPEG_EXE"
        return Finding("films", f"no ffmpeg: {str(error).splitlines()[0]}", advice)


def _optional() -> list[Finding]:
    found = []
    for extra, commands in OPTIONAL.items():
        absent = missing(extra)
        result = f"{', '.join(absent)} not found" if absent else _packages_of(EXTRAS[extra])
        found.append(Finding(f"{extra}: {commands}", result, pip_command(extra) if absent else ""))
    return found


def _packages_of(modules: Sequence[str]) -> str:
    """Return the packages of modules with their versions, separated by commas."""
    packages = packages_distributions()
    names = [packages.get(module, [module])[0] for module in modules]
    return ", ".join(f"{name} {version(name)}" for name in names)
