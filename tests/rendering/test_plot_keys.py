"""Each drawing option changes the right pixels and no others, and its picture is the committed one; figures likewise.

``references/*.png`` were looked at when they were committed. A picture agrees with its reference when no more than 1 %
of its pixels differ by more than 48 levels and the mean difference is at most 2 levels: other versions of matplotlib
and FreeType, and matplotlib, which draws figures, smooth edges and letters a little differently. References are frames.
After a change on purpose write them anew, and look at them::

    RENEW_REFERENCES=1 make test ARGS=tests/rendering/test_plot_keys.py
"""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pixels import WAYS, of_world
from plot_cases import BOX, CASES, GOAL, RADIUS, START, TOLERANCE, Case, Moment

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.live.world import load
from irsim_gym.rendering.scene.frame_layout import Layout
from irsim_gym.scenario.specs.plot_spec import ObjectPlot, WorldPlot

FOLDER = Path(__file__).parent / "references"
CHANGED, LEAST = 12, 12
"""A pixel has changed by more than so many levels; a change has at least so many pixels."""
FAR_OFF, MOST_FAR_OFF, MEAN_OFF = 48, 0.01, 2.0
NOT_IN_A_PICTURE = {"saved_figure"}
COMMAND = (1.0, 0.9)

WORLD: dict[str, Any] = {
    "world": {"width": 4, "height": 4, "plot": {"figure_pixels": [160, 160], "no_axis": True, "show_title": False}},
    "robot": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": RADIUS},
        "state": [*START],
        "goal": [*GOAL],
        "goal_threshold": TOLERANCE,
        "plot": {"show_arrow": False},
    },
    "obstacle": {"shape": {"name": "rectangle", "length": 0.8, "width": 0.5}, "state": [*BOX, 0.5]},
}


@dataclass(frozen=True)
class Picture:
    """A picture, where things are on it, and which places were driven through."""

    pixels: Bytes
    layout: Layout
    poses: Any

    def moment(self) -> Moment:
        height, width = self.pixels.shape[:2]
        x0, y0 = self.layout.limits[:2]
        columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        x = x0 + (columns - self.layout.left) / self.layout.scale
        y = y0 + (height - rows - self.layout.bottom) / self.layout.scale
        return Moment(x, y, self.poses)


def drawn(options: Mapping[str, Any], steps: int, how: str) -> Picture:
    data = copy.deepcopy(WORLD)
    for key, value in options.items():
        *sections, last = key.split(".")
        place = data
        for section in sections:
            place = place.setdefault(section, {})
        place[last] = value
    with load(data) as world:
        poses = [world.simulation.state.pose[0, 0].copy()]
        for _ in range(steps):
            world.step(COMMAND)
            poses.append(world.simulation.state.pose[0, 0].copy())
        pixels = of_world(world, how)
        return Picture(pixels, world._camera._ready().layout, np.array(poses))


@cache
def picture(key: str, how: str) -> tuple[Picture, Picture]:
    """Return the pictures of a case, before and after."""
    case = next(case for case in CASES if case.label == key)
    return drawn(case.given, case.steps, how), drawn({**case.given, **case.change}, case.steps, how)


cases = pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
hows = pytest.mark.parametrize("how", WAYS)


@cases
@hows
def test_the_right_pixels_change(case: Case, how: str) -> None:
    before, after = picture(case.label, how)
    if before.pixels.shape != after.pixels.shape:
        return
    changed = np.abs(after.pixels.astype(int) - before.pixels).max(axis=2) > CHANGED
    area = case.area(after.moment())
    assert changed.sum() >= LEAST, "nothing changes"
    outside = np.argwhere(changed & ~area)
    assert not len(outside), f"{len(outside)} pixels change elsewhere, such as row, column {outside[0].tolist()}"


@pytest.mark.parametrize("case", [case for case in CASES if case.shows], ids=lambda case: case.label)
@hows
def test_points_have_the_colours_that_are_asked_for(case: Case, how: str) -> None:
    after = picture(case.label, how)[1]
    for point, colour in case.shows.items():
        column, row = after.layout.column_row(*point)
        assert np.allclose(after.pixels[int(row), int(column)], colour, atol=3), point


@cases
@hows
def test_pictures_are_the_committed_ones(case: Case, how: str) -> None:
    pixels, file = picture(case.label, how)[1].pixels, FOLDER / f"{case.label}.png"
    if os.environ.get("RENEW_REFERENCES") and how == "frame":
        Image.fromarray(pixels).save(file, optimize=True)
    with Image.open(file) as reference:
        off = np.abs(np.asarray(reference.convert("RGB")).astype(int) - pixels)
    assert (off.max(axis=2) > FAR_OFF).mean() <= MOST_FAR_OFF
    assert off.mean() <= MEAN_OFF


def test_every_option_has_a_case_and_every_reference_a_use() -> None:
    changed = {key.rpartition(".")[2] for case in CASES for key in case.change}
    assert {*ObjectPlot.__annotations__, *WorldPlot.__annotations__} - changed == NOT_IN_A_PICTURE
    assert {file.stem for file in FOLDER.glob("*.png")} == {case.label for case in CASES}
    assert len({case.label for case in CASES}) == len(CASES)
