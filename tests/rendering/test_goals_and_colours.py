"""Goals are where bodies go, also when that changes; colours are given one by one, by list or by cycle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from irsim_gym.live.world import World, load
from irsim_gym.scenario.specs.plot_spec import CYCLE

WHITE = (255, 255, 255)
ROBOT: dict[str, Any] = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.4, "center": [0.6, 0.0]},
    "state": [2, 2, 0],
    "goal_threshold": 0.5,
    "plot": {"show_goal": True, "goal_color": "red", "show_arrow": False},
}


def colour_at(world: World, x: float, y: float) -> tuple[int, ...]:
    column, row = world._camera._ready().layout.column_row(x, y)
    return tuple(int(level) for level in world.render()[int(row), int(column)])


def is_marked(world: World, x: float, y: float) -> bool:
    """Return whether there is a goal's circle at a point, looked at left of the flag."""
    red, green, blue = colour_at(world, x - 0.25, y)
    return red == 255 and green == blue and green < 240


def test_the_goal_of_a_circle_off_its_centre_is_where_its_origin_goes() -> None:
    with load({"robot": {**ROBOT, "goal": [7, 7]}}) as world:
        assert is_marked(world, 7.0, 7.0)
        assert colour_at(world, 7.6, 7.2) == WHITE
        assert colour_at(world, 2.6, 2.2) != WHITE, "the circle itself is off its origin"


def test_the_mark_follows_a_goal_that_is_changed() -> None:
    with load({"robot": {**ROBOT, "goal": [7, 7]}}) as world:
        world.robot.set_goal([3, 8.3])
        assert is_marked(world, 3.0, 8.3)
        assert not is_marked(world, 7.0, 7.0)
        world.reset()
        assert is_marked(world, 7.0, 7.0)


def test_of_several_goals_the_next_one_has_the_mark_and_the_later_ones_dots() -> None:
    with load({"robot": {**ROBOT, "goal": [[[4, 2], [7, 7], [3, 8]]], "behavior": {"name": "dash"}}}) as world:
        assert is_marked(world, 4.0, 2.0)
        for x, y in ((7.0, 7.0), (3.0, 8.0)):
            assert not is_marked(world, x, y)
            assert colour_at(world, x, y) != WHITE, "a dot"
        while world.robot.goal[0] == 4.0:
            world.step()
        assert is_marked(world, 7.0, 7.0)
        assert not is_marked(world, 4.0, 2.0)


@pytest.mark.parametrize("color", ["cycle", ["red", "#0000FF", [0, 0.5, 0], "0.5", "tab:orange"]])
def test_each_body_of_an_entry_has_its_colour(color: Any) -> None:
    """A list that is shorter than the entry goes on with its last colour; the palette begins again."""
    states = [[1 + (i % 5), 1 + 2 * (i // 5), 0] for i in range(10)]
    shape = {"name": "circle", "radius": 0.3}
    with load({"obstacle": {"number": 10, "state": states, "shape": shape, "color": color}}) as world:
        palette = list(CYCLE) if color == "cycle" else color
        for i, (x, y, _) in enumerate(states):
            wanted = palette[i % len(palette)] if color == "cycle" else palette[min(i, len(palette) - 1)]
            assert np.allclose(colour_at(world, x, y), 255 * np.array(to_rgb(wanted)), atol=1), i


def test_options_for_all_bodies_for_an_entry_and_for_each() -> None:
    robots = {"number": 2, "state": [[2, 2], [5, 2]], "plot": [{"obj_color": "red"}, {"show_text": False}]}
    scenario = {"plot": {"obj_color": "blue", "show_text": True}, "robot": robots, "obstacle": {"state": [8, 2]}}
    with load(scenario) as world:
        assert [colour_at(world, x, 2.0) for x in (2.0, 5.0, 8.0)] == [(255, 0, 0), (0, 0, 255), (0, 0, 255)]
        assert [label.text for label in world._camera._ready().scene().labels] == ["o2", "r0"]


def test_names_of_ones_own_are_written_as_they_are() -> None:
    bodies = [{"name": name, "plot": {"show_text": True}} for name in ("anna", "robot_x", "$5_{a}")]
    with load({"robot": [{**body, "state": [2 + 2 * i, 5]} for i, body in enumerate(bodies)]}) as world:
        assert [label.text for label in world._camera._ready().scene().labels] == ["anna", "robot_x", "$5_{a}"]
        assert world.render().min() < 100
