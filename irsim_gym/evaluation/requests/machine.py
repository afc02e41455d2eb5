"""The machine and the versions of packages, which results have to name."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from irsim_gym.base.version import __version__


def machine() -> dict[str, Any]:
    """Return the machine and the versions of packages, on which results depend besides the settings."""
    names = ("numpy", "numba", "gymnasium", "stable-baselines3", "torch", "ray")
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "versions": {"irsim_gym": __version__, **{name: version for name in names if (version := _installed(name))}},
    }


def _installed(name: str) -> str:
    """Return the version of a package; an empty string if it is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
