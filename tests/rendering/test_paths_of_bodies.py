"""``show_trajectory`` in both renderers: dashes are regular all along, a width is metres of the world."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pixels import WAYS, of_world

from irsim_gym.base.arraytypes import Floats
from irsim_gym.live.world import load

STEPS = 70
POINT = 100.0 / 72.0
"""A point of a picture of 600 x 600 pixels [pixel]."""


def greenness(how: str, y: float = 5.0, **plot: Any) -> tuple[Floats, Floats, Any]:
    """Return how green the row and a column of pixels are that a robot came along, and the layout."""
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [1, y, 0],
        "color": "#00FF00",
        "plot": {"show_trajectory": True, "show_arrow": False, "obj_alpha": 0, **plot},
    }
    plain = {"plot": {"figure_pixels": [600, 600], "no_axis": True}}
    with load({"world": plain, "robot": robot}) as world:
        for _ in range(STEPS):
            world.step([1.0, 0.0])
        frame, layout = of_world(world, how).astype(float), world._camera._ready().layout
    column, row = layout.column_row(4.53, y)
    start, end = layout.column_row(1.0, y)[0], layout.column_row(8.0, y)[0]
    green = frame[..., 1] - frame[..., 0]
    return green[int(row), int(start) : int(end) - 4], green[:, int(column)], layout


def starts(row: Floats) -> Any:
    """Return where dashes begin [pixel]: half of what the line is there, which fades towards its beginning."""
    peak = np.array([row[max(k - 14, 0) : k + 15].max() for k in range(len(row))])
    inside = row > 0.5 * peak
    return np.flatnonzero(inside[1:] & ~inside[:-1])


@pytest.mark.parametrize("how", WAYS)
@pytest.mark.parametrize(("style", "period", "dashes"), [("--", 3.7 + 1.6, 1), ("-.", 6.4 + 1.6 + 1.0 + 1.6, 2)])
def test_the_dashes_of_a_thin_path_are_those_of_its_style(how: str, style: str, period: float, dashes: int) -> None:
    """matplotlib's pattern in widths of the line, which is 1.9 points wide, once along the whole path."""
    row, _, _ = greenness(how, traj_style=style)
    found = starts(row)
    spacing = period * 1.9 * POINT
    assert len(found) == pytest.approx(dashes * len(row) / spacing, abs=1)
    assert found[dashes:] - found[:-dashes] == pytest.approx(spacing, abs=1.5)


@pytest.mark.parametrize("how", WAYS)
@pytest.mark.parametrize("width", [0.1, 0.4, 1.0])
def test_a_width_is_metres_of_the_world(how: str, width: float) -> None:
    _, column, layout = greenness(how, traj_width=width, traj_alpha=1.0)
    assert (column / 255.0).sum() == pytest.approx(width * layout.scale, abs=0.7)
