"""What a measurement was made with: it stands in every result."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from typing import Any

from irsim_gym.training.run import machine


def describe() -> dict[str, Any]:
    """Return machine, versions, load, commit and date."""
    return {
        **machine(),
        "load": os.getloadavg()[0],
        "commit": _commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _commit() -> str:
    asked = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
    return asked.stdout.strip() if asked.returncode == 0 else "unknown"
