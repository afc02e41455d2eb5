"""A world of IR-SIM beside ours: silent, without pictures, its own warnings ignored."""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml


@contextlib.contextmanager
def ir_sim_world(data: dict[str, Any], folder: Path, seed: int = 0) -> Iterator[Any]:
    """Give an environment of ir-sim made from a scenario."""
    path = folder / "scene.yaml"
    path.write_text(yaml.safe_dump(data))
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        import irsim

        world = irsim.make(str(path), headless=True, log_level="ERROR", seed=seed)
        try:
            yield world
        finally:
            world.end()
            logging.getLogger("irsim").handlers.clear()
