"""Figures as pixels, to be compared with frames."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.live.world import World
from irsim_gym.rendering import Renderer

WAYS = ("frame", "figure")


def of_renderer(renderer: Renderer, status: str = "", how: str = "figure") -> Bytes:
    """Return a frame, or a figure of a scenario whose ``bbox_inches`` is ``standard``."""
    if how == "frame":
        return renderer.frame(0, status)
    with tempfile.TemporaryDirectory() as folder:
        renderer.save(Path(folder) / "figure.png", status=status)
        return _read(Path(folder) / "figure.png")


def of_world(world: World, how: str) -> Bytes:
    """Return a frame, or a figure that is as large."""
    if how == "frame":
        return world.render()
    with tempfile.TemporaryDirectory() as folder:
        return _read(world.save_figure(Path(folder) / "figure.png", bbox_inches="standard", dpi=100))


def _read(file: Path) -> Bytes:
    with Image.open(file) as image:
        return np.asarray(image.convert("RGB"))
