"""What a scenario gives is drawn as given, also where it equals a default of IR-SIM's or of the theme."""

from __future__ import annotations

from typing import Any

import pytest

from irsim_gym.live.world import load
from irsim_gym.rendering.scene.scene import Scene
from irsim_gym.scenario.reference.option_tables import option_rows
from irsim_gym.scenario.specs.plot_spec import ObjectPlot

ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}, "state": [5, 5, 0], "goal": [9, 9]}


def scene(plot: dict[str, Any] | None = None, *, role: str = "robot", **entry: Any) -> Scene:
    world = load({role: {**ROBOT, **entry, "plot": plot or {}}})
    return world._camera._ready().scene()


@pytest.mark.parametrize("pixels", [[1000, 800], [1001, 801], [600, 600]])
def test_pictures_have_the_size_that_is_given(pixels: list[int]) -> None:
    with load({"world": {"plot": {"figure_pixels": pixels}}, "robot": ROBOT}) as world:
        height, width = world.render().shape[:2]
    assert abs(width - pixels[0]) <= 1
    assert abs(height - pixels[1]) <= 1


@pytest.mark.parametrize("kind", ["lidar2d", "fmcw_lidar2d"])
def test_beams_have_the_colour_that_is_given(kind: str) -> None:
    given = scene(sensors=[{"name": kind, "color": "#CC3311"}]).scans[0].style.colour
    assert given == "#CC3311"
    assert scene(sensors=[{"name": kind}]).scans[0].style.colour != given


def test_arrows_are_those_that_are_given() -> None:
    style = scene({"arrow_color": "#F0E442", "arrow_length": 0.4, "arrow_alpha": 1.0}).moving[0].style
    assert (style.arrow_colour, style.arrow, style.arrow_alpha) == ("#F0E442", (0.4, 0.6), 1.0)
    assert scene({"arrow_width": 0.6}).moving[0].style.arrow == (0.4, 0.6)
    assert scene().moving[0].style.arrow is None
    heading = scene({"arrow_length": 0.4}).moving[0].heading
    assert heading[:, 0].max() == pytest.approx(5.4), "an arrow begins at the origin"


@pytest.mark.parametrize(
    ("option", "value", "attribute"),
    [
        ("goal_alpha", 0.5, "goal_alpha"),
        ("goal_zorder", 1, "goal_order"),
        ("text_color", "k", "label_colour"),
        ("text_size", 10.0, "label_size"),
        ("text_zorder", 2, "label_order"),
        ("arrow_zorder", 3, "arrow_order"),
        ("traj_alpha", 0.5, "trajectory_alpha"),
        ("traj_zorder", 0, "trajectory_order"),
        ("obj_linewidth", 1.0, "wall_width"),
        ("fov_alpha", 0.5, "field_alpha"),
        ("fov_zorder", 1, "field_order"),
    ],
)
def test_defaults_of_irsim_are_drawn_as_given(option: str, value: Any, attribute: str) -> None:
    assert getattr(scene({option: value}).moving[0].style, attribute) == value


def test_a_black_obstacle_is_black() -> None:
    assert scene(role="obstacle", color="k").moving[0].style.colour == "k"


def test_the_table_tells_what_is_drawn() -> None:
    """An option without a default says in its meaning what is drawn, or is a colour: then it is the body's own."""
    for row in option_rows(ObjectPlot):
        assert row.default or "efault" in row.meaning or row.key.endswith("color"), row.key
