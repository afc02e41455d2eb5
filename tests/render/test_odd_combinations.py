"""Drawing options that are allowed, but that hardly anybody combines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.engine import Simulation
from irsim_gym.engine import compile as compile_scenario
from irsim_gym.render import Renderer
from irsim_gym.scenario import load_scenario


def drawn(world: dict[str, Any], **robot: Any) -> tuple[Renderer, Simulation]:
    """Return the renderer of a world of 4 x 4 m with one robot in its middle."""
    body = {"kinematics": {"name": "diff"}, "state": [2, 2, 0], "goal": [3, 3], **robot}
    scenario = load_scenario({"world": {"height": 4, "width": 4, "plot": world}, "robot": body}, warn=False)
    simulation = compile_scenario(scenario)
    simulation.reset(0)
    return Renderer(scenario, simulation.model, simulation.state, simulation.sensors), simulation


def test_an_image_may_be_seen_by_one_row_of_pixels() -> None:
    renderer, simulation = drawn({"figure_pixels": [200, 200]}, description="car_red.png")
    layout = renderer.layout
    rows = np.array([layout.column_row(2.0, y)[1] for y in (0.0, 1.0)])
    below = (layout.height - rows[0]) / (rows[1] - rows[0])  # the ordinate of the picture's lower edge [m]
    simulation.state.pose[0, 0] = 2.0, below, 0.0
    simulation.state.pose[0, 0, 1] -= simulation.model.local_discs[0, 0, 2] + 0.2 / layout.scale
    assert renderer.frame().shape == (200, 200, 3)


@pytest.mark.parametrize(
    "shape", [{"name": "circle", "radius": 1.0}, {"name": "linestring", "vertices": [[0, 0], [1, 1]]}]
)
def test_an_outline_without_width_has_no_dashes(shape: dict[str, Any]) -> None:
    plain, dashed = (
        drawn({"figure_pixels": [160, 160]}, shape=shape, plot={"obj_linewidth": 0, "obj_linestyle": style})[0].frame()
        for style in ("-", "--")
    )
    assert np.array_equal(plain, dashed)
