"""What a measurement was made with: it stands in every result."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from typing import Any

from c_twin import compiler

from irsim_gym.evaluation import machine


def describe() -> dict[str, Any]:
    """Return machine, versions, C compiler, load, commit and date."""
    return {
        **machine(),
        "c_compiler": _compiler(),
        "load": os.getloadavg()[0],
        "commit": _commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _compiler() -> str | None:
    command = compiler()
    if command is None:
        return None
    said = subprocess.run([command, "--version"], capture_output=True, text=True, check=False).stdout
    return said.partition("\n")[0] or command


def _commit() -> str:
    asked = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    return asked.stdout.strip() if asked.returncode == 0 else "unknown"
