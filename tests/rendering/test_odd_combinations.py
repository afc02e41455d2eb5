"""Drawing options that are allowed, but that hardly anybody combines, and what renderers keep from frame to frame."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.engine import compile as compile_scenario


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
    assert np.abs(plain.astype(int) - dashed).mean() < 0.2  # another hand may draw it: edges differ a little


FULL: dict[str, Any] = {
    "world": {"height": 6, "width": 8, "fog_map": True, "plot": {"figure_pixels": [240, 200]}},
    "plot": {"show_text": True, "show_goal": True, "show_trail": True, "trail_fill": True, "show_fov": True},
    "robot": {
        "number": 2,
        "kinematics": {"name": "diff"},
        "distribution": {"name": "random"},
        "behavior": {"name": "dash"},
        "sensors": [{"name": "lidar2d", "number": 12, "range_max": 2}],
        "fov": 1.5,
        "fov_radius": 2,
        "plot": {"trail_freq": 1, "keep_traj_length": 3, "traj_style": "--"},
    },
    "obstacle": [
        {"shape": {"name": name, "random_shape": True}, "distribution": {"name": "random"}, "plot": plot, **rest}
        for name, plot, rest in (
            ("polygon", {"obj_zorder": 4, "obj_alpha": 0.4}, {}),
            ("circle", {"obj_zorder": 5}, {"description": "car_blue.png"}),
            ("linestring", {"obj_linestyle": "--"}, {"kinematics": {"name": "omni"}, "behavior": {"name": "dash"}}),
        )
    ],
}


def test_who_has_drawn_much_draws_as_one_who_is_new() -> None:
    scenario = load_scenario(FULL, warn=False)
    simulation = compile_scenario(scenario, 3)
    parts = scenario, simulation.model, simulation.state, simulation.sensors
    simulation.reset(0)
    old = Renderer(*parts, explored=simulation.explored)

    def compare(world: int, status: str = "", limits: tuple[float, float, float, float] | None = None) -> None:
        new = Renderer(*parts, explored=simulation.explored, trails=old.trails)
        new.look_at(limits)
        assert np.array_equal(old.frame(world, status), new.frame(world, status))

    for world, status in ((0, ""), (2, "success"), (0, "collision"), (1, "my own words")):
        simulation.step()
        compare(world, status)
    half = 0.0, 0.0, 4.0, 3.0
    old.look_at(half)
    compare(0, limits=half)
    simulation.reset(1)
    compare(0, limits=half)
    old.look_at(None)
    compare(0)
    simulation.reset(2)
    for world in (0, 2):
        simulation.model.present[world, 3] = False
        simulation.state.collided[world, 0] = True
        compare(world)
        simulation.model.present[world, 3] = True
        compare(world)
    old.clear(0)
    old.close()
    compare(0)


def test_texts_are_whole_after_a_small_figure_was_saved(tmp_path: Path) -> None:
    old, new = (drawn({"figure_pixels": [16, 16]})[0] for _ in range(2))
    old.save(tmp_path / "first.png", dots_per_inch=50)
    assert np.array_equal(old.frame(0, "my status"), new.frame(0, "my status"))
    assert not np.array_equal(old.frame(0, "my status"), old.frame(0, "status of mine"))  # it is seen


def test_one_may_look_anywhere_and_as_closely_as_one_likes() -> None:
    scenario = load_scenario(FULL, warn=False)
    simulation = compile_scenario(scenario)
    simulation.reset(0)
    simulation.step()
    parts = scenario, simulation.model, simulation.state, simulation.sensors
    renderer = Renderer(*parts, explored=simulation.explored)
    for limits in ((100.0, 100.0, 101.0, 101.0), (-1e9, -1e9, -1e9 + 1.0, -1e9 + 1.0), (-3.0, -3.0, 0.0, 0.0)):
        renderer.look_at(limits)
        shown = renderer.layout
        area = renderer.frame()[-shown.bottom - shown.plot_height : -shown.bottom, shown.left :][:, : shown.plot_width]
        inside = area[6:-6, 6:-6].reshape(-1, 3)
        assert (inside == inside[0]).all()  # nothing is there, and nothing of the world is drawn at an edge
    x, y, _ = simulation.state.pose[0, 0]
    for size in (1e-9, 1e-6, 1e9, 1e300):  # dashes without number, or a world smaller than a pixel
        renderer.look_at((x, y, x + size, y + size))
        assert renderer.frame().shape == (200, 240, 3)
