"""The pictures of the pages are what their scripts draw."""

from __future__ import annotations

import runpy
from pathlib import Path

import imageio.v3 as iio
import numpy as np

DOCS = Path(__file__).parents[1] / "docs"
LARGEST_DIFFERENCE = 4.0


def test_what_a_robot_sees(tmp_path: Path) -> None:
    made = tmp_path / "made.png"
    runpy.run_path(str(DOCS / "what_a_robot_sees.py"))["main"](made)
    drawn, shown = (iio.imread(file)[..., :3].astype(np.float64) for file in (made, DOCS / "what_a_robot_sees.png"))
    assert drawn.shape == shown.shape
    assert np.abs(drawn - shown).mean() < LARGEST_DIFFERENCE
