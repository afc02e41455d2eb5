"""What is installed here, what works, and which command lacks what."""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, packages_distributions, version

from rich.console import Console
from rich.table import Table
from rich.text import Text

from irsim_gym import __version__
from irsim_gym.extras import EXTRAS, missing, pip_command

PACKAGES = (
    *("numpy", "numba", "llvmlite", "gymnasium", "pettingzoo", "pydantic"),
    *("shapely", "matplotlib", "Pillow", "imageio", "moviepy"),
)
"""Packages whose versions a report of a problem should name."""
OPTIONAL = {
    "train": "train, demo, policies export; evaluate and record with a policy.zip",
    "contrib": "train --algorithm tqc, recurrent_ppo",
    "tune": "tune",
    "rllib": "train --engine rllib, sweep",
    "play": "play: keys without the delay of a window",
}
"""Commands that need an extra."""


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Attributes:
        topic: What it is.
        found: What was found.
        advice: What to do about it; empty where all is well.
        is_wrong: Something that everybody needs does not work.
    """

    topic: str
    found: str
    advice: str = ""
    is_wrong: bool = False


def examine() -> list[Finding]:
    """Return what is installed here, and what works. Nothing is changed, and nothing is compiled."""
    return [_python(), *_packages(), _compiler(), _cache(), _threads(), _graphics_card(), _display(), *_optional()]


def print_examination(console: Console | None = None) -> bool:
    """Print what is found as a table, and return whether all that everybody needs works."""
    findings = examine()
    table = Table()
    for head in ("", "found", "what to do"):
        table.add_column(head, overflow="fold")
    for one in findings:
        table.add_row(*map(Text, (one.topic, one.found, one.advice)), style="red" if one.is_wrong else "")
    (console or Console()).print(table)
    return not any(one.is_wrong for one in findings)


def _python() -> Finding:
    return Finding("irsim_gym", f"{__version__}, Python {platform.python_version()}, {platform.platform()}")


def _packages() -> list[Finding]:
    found = []
    for name in PACKAGES:
        try:
            found.append(Finding(name, version(name)))
        except PackageNotFoundError:
            found.append(Finding(name, "not installed", f"pip install {name}", is_wrong=True))
    return found


def _compiler() -> Finding:
    from irsim_gym.jit import hooks

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return Finding("compiled kernels", "off: NUMBA_DISABLE_JIT is set", "unset it: plain Python is far slower")
    if hooks.is_plain():
        return Finding("compiled kernels", f"Numba's plain way: {hooks.SWITCH} is set", "unset it for faster starts")
    gone = hooks.missing()
    if gone:
        return Finding("compiled kernels", f"Numba's plain way: this Numba lacks {', '.join(gone)}")
    return Finding("compiled kernels", "on")


def _cache() -> Finding:
    from irsim_gym.jit.folder import cache_folder

    folder = cache_folder()
    if folder is None:
        advice = "set NUMBA_CACHE_DIR to a folder that you may write, or every process compiles anew"
        return Finding("cache of kernels", "no folder can be written", advice)
    files = [file.stat().st_size for file in folder.glob("*.nbc")]
    advice = "" if files else "irsim-gym warmup compiles beforehand"
    return Finding("cache of kernels", f"{folder}: {len(files)} files, {sum(files) / 1e6:.0f} MB", advice)


def _threads() -> Finding:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Finding("processors", f"{usable} of {os.cpu_count()}: num_threads=0 uses {usable}")


def _graphics_card() -> Finding:
    if importlib.util.find_spec("torch") is None:
        return Finding("graphics card", "unknown without torch")
    import torch

    if not torch.cuda.is_available():
        return Finding("graphics card", "none for PyTorch; nothing needs one")
    return Finding("graphics card", f"{torch.cuda.get_device_name(0)}: train --device cuda uses it")


def _display() -> Finding:
    if not sys.platform.startswith("linux") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        return Finding("display", "there is one for windows")
    advice = 'play and render_mode="human" need one; films, pictures and pages do not'
    return Finding("display", "DISPLAY and WAYLAND_DISPLAY are not set", advice)


def _optional() -> list[Finding]:
    found = []
    for extra, commands in OPTIONAL.items():
        absent = missing(extra)
        told = f"{', '.join(absent)} not found" if absent else _versions(EXTRAS[extra])
        found.append(Finding(f"{extra}: {commands}", told, pip_command(extra) if absent else ""))
    return found


def _versions(modules: Sequence[str]) -> str:
    """Return modules with the versions of their packages, where they are known."""
    packages = packages_distributions()
    names = [packages.get(module, [module])[0] for module in modules]
    return ", ".join(f"{name} {version(name)}" for name in names)
