"""A result on disk: machine, figures and their noise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rich.console import Console

FOLDER = Path(__file__).parent / "results"
WIDTH = 140
SCHEMA = Path(__file__).parent / "result.schema.json"


def console() -> Console:
    """Return where tables are shown: wide enough for names where the output goes to a file."""
    found = Console()
    if not found.is_terminal:
        found.width = WIDTH
    return found


def write(file: Path, result: dict[str, Any]) -> None:
    """Write a result, whole or not at all."""
    draft = file.with_suffix(".tmp")
    draft.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    draft.replace(file)


def read(file: Path) -> dict[str, Any]:
    """Return a result."""
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return found
