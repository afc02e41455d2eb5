"""A world by hand in a real window, driven with real keys and a real mouse."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from screen import Screen

import irsim_gym
from irsim_gym.errors import NoKeyboardWarning
from irsim_gym.live.world import World

ROBOT = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "vel_max": [2, 2]}
Make = Callable[..., World]


@pytest.fixture
def make(screen: Screen, request: pytest.FixtureRequest) -> Iterator[Make]:
    """Return a function that loads a world of 10 x 10 m with two robots and shows it; its title is that of the test."""
    made: list[World] = []

    def show(robots: Any = None, **sections: Any) -> World:
        title = request.node.name
        keyboard = {"key_lv_max": 1.0, "key_ang_max": 1.5, **sections.pop("keyboard", {})}
        world = {
            "name": title,
            "control_mode": "keyboard",
            "step_time": 0.05,
            "sample_time": 0.05,
            **sections.pop("world", {}),
        }
        places = [[3, 3, 0], [3, 7, 0]]
        others = robots or [{**ROBOT, "state": place, "vel_min": [-2, -2]} for place in places]
        file = {"world": world, "robot": others, "gui": {"keyboard": keyboard}, **sections}
        made.append(irsim_gym.load(file, render_mode="human"))
        screen.move(5, 5)  # without a window manager the window under the mouse has the focus
        made[-1].render()
        screen.focus(title)
        return made[-1]

    yield show
    for world in made:
        world.close()
    assert threading.active_count() == 1


def go(here: World, holds: Callable[[], Any], most: int = 400) -> None:
    """Step and render as a script does, until something holds."""
    for _ in range(most):
        here.step()
        here.render(0.005)
        if holds():
            return
    raise AssertionError(f"it has not come: {here.status}, {here.key_vel}, {[robot.state for robot in here.robots]}")


def steps(here: World, count: int) -> None:
    for _ in range(count):
        here.step()
        here.render(0.005)


def test_keys_drive_while_they_are_held(make: Make, screen: Screen, kept_picture) -> None:
    here = make()
    robot, other = here.robots
    assert here._viewer.driver is not None
    steps(here, 3)
    assert here.status == "Running (keyboard)"
    assert robot.state.tolist() == [3, 3, 0]
    screen.down("w")
    go(here, lambda: robot.velocity[0] == 1.0)
    for _ in range(60):  # longer than it takes a keyboard to begin repeating: the speed stays
        steps(here, 1)
        assert robot.velocity.tolist() == [1.0, 0.0]
    kept_picture(screen.picture())
    screen.down("a")
    go(here, lambda: robot.velocity.tolist() == [1.0, 1.5])
    screen.up("w")
    go(here, lambda: robot.velocity.tolist() == [0.0, 1.5])
    screen.down("d")
    go(here, lambda: robot.velocity.tolist() == [0.0, -1.5])  # the later of two counts
    screen.up("d")
    screen.up("a")
    screen.down("s")
    go(here, lambda: robot.velocity.tolist() == [-1.0, 0.0])
    screen.up("s")
    go(here, lambda: robot.velocity.tolist() == [0.0, 0.0])
    assert robot.state[0] > 4.0
    assert other.state.tolist() == [3, 7, 0]


def test_keys_choose_the_robot_and_the_speeds(make: Make, screen: Screen) -> None:
    here = make()
    assert here._viewer.driver is not None
    keyboard = here._viewer.driver.keyboard
    screen.type("alt+1", "e", "c", "c", "z", "shift+c", "shift+c", "shift+z", "q", "e")
    go(here, lambda: keyboard.key_lv_max == 1.4)
    assert (here.key_id, keyboard.key_lv_max, keyboard.key_ang_max) == (1, 1.4, 1.7)
    screen.down("w")
    go(here, lambda: here.robots[1].velocity[0] == 1.4)
    screen.up("w")
    assert here.robots[0].state.tolist() == [3, 3, 0]
    screen.type("alt+7")  # there is no such robot: nobody is driven
    go(here, lambda: here.key_id == 7)
    screen.down("w")
    go(here, lambda: here.key_vel[0] == 1.4)
    steps(here, 3)
    assert [robot.velocity[0] for robot in here.robots] == [0.0, 0.0]


def test_keys_of_the_world(
    make: Make, screen: Screen, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kept_picture
) -> None:
    monkeypatch.chdir(tmp_path)
    here = make()
    robot = here.robots[0]
    screen.down("w")
    go(here, lambda: robot.state[0] > 3.3)
    screen.up("w")
    screen.type("space")
    go(here, lambda: here.status == "Pause")
    count = here.count
    steps(here, 5)
    assert (here.count, here.status) == (count, "Pause")
    kept_picture(screen.picture())
    screen.type("F5")
    go(here, lambda: here.count == count + 1)
    steps(here, 5)
    assert (here.count, here.status) == (count + 1, "Pause (Debugging)")
    screen.type("space")
    go(here, lambda: here.count > count + 3)
    assert here.status == "Running (keyboard)"
    screen.type("x")
    go(here, lambda: here.control_mode == "auto")
    steps(here, 1)
    assert here.status == "Running"
    screen.type("x")
    go(here, lambda: here.control_mode == "keyboard")
    screen.type("v")
    go(here, lambda: list(tmp_path.glob("*.png")))
    assert "_00" in next(tmp_path.glob("*.png")).name
    screen.type("r")
    go(here, lambda: robot.state.tolist() == [3, 3, 0])
    assert here.count < 5
    screen.type("l")
    go(here, lambda: here.count == 0)
    screen.type("Escape")
    go(here, lambda: here.quit_flag)
    assert (here.status, here.done(), here.done("any"), here.display) == ("Quit", True, True, False)
    assert not screen.has_window(here.name)
    with pytest.raises(SystemExit):  # a loop that does not ask whether it is done ends all the same
        here.render()


def test_keys_count_in_this_window_alone(make: Make, screen: Screen) -> None:
    with pytest.warns(NoKeyboardWarning, match="global_hook: keys count only while the window has focus"):
        here = make(keyboard={"global_hook": True})
    screen.move(1200, 1000)
    screen.focus(None)
    screen.down("w")
    for _ in range(40):
        steps(here, 1)
    assert here.key_vel[0] == 0.0
    screen.up("w")


def test_drives_that_go_sideways(make: Make, screen: Screen) -> None:
    free = {**ROBOT, "vel_max": [2, 2, 2], "vel_min": [-2, -2, -2], "state": [5, 5, 0]}
    robots = [
        {**free, "vel_max": [2, 2], "vel_min": [-2, -2], "kinematics": {"name": "omni"}},
        {**free, "state": [5, 2, 0], "kinematics": {"name": "omni_angular"}},
    ]
    here = make(robots=robots)
    screen.down("a")
    go(here, lambda: here.robot.velocity.tolist() == [0.0, 1.0])  # as fast as ahead, not as it turns
    screen.up("a")
    screen.type("alt+1")
    go(here, lambda: here.key_id == 1)
    screen.down("d")
    screen.down("e")
    go(here, lambda: here.robots[1].velocity.tolist() == [0.0, -1.0, -1.5])
    screen.up("e")
    screen.down("q")
    go(here, lambda: here.robots[1].velocity.tolist() == [0.0, -1.0, 1.5])


def test_the_command_is_cut_by_the_limits_and_others_keep_their_behaviour(make: Make, screen: Screen) -> None:
    slow = {**ROBOT, "vel_max": [0.5, 2], "acce": [2, 100], "state": [3, 3, 0]}
    dashing = {**ROBOT, "state": [3, 7, 0], "goal": [9, 7], "behavior": {"name": "dash"}}
    here = make(robots=[slow, dashing])
    screen.down("w")
    go(here, lambda: here.robot.velocity[0] > 0.0)
    assert here.robot.velocity[0] == pytest.approx(0.1)  # 2 m/s2 for 0.05 s
    go(here, lambda: here.robot.velocity[0] == 0.5)
    steps(here, 3)
    assert here.robot.velocity[0] == 0.5
    assert here.robots[1].state[0] > 3.3


def test_the_wheel_zooms_about_the_cursor(make: Make, screen: Screen, kept_picture) -> None:
    here = make(gui={"mouse": {"zoom_factor": 2.0}})
    layout = here._camera.seen()
    column, row = (round(value) for value in layout.column_row(3.0, 3.0))
    robot_green = np.array([0, 158, 115])

    def shown(at: tuple[int, int]) -> bool:
        return bool(np.abs(screen.picture()[at[1], at[0]] - robot_green.astype(int)).max() < 3)

    side = (column, row - round(0.15 * layout.scale))  # inside of the robot, then outside of what was 0.15 m away
    assert shown(side)
    screen.click("up", column, row)
    go(here, lambda: here._camera.seen().scale == pytest.approx(2.0 * layout.scale))
    steps(here, 2)
    kept_picture(screen.picture())
    zoomed = here._camera.seen()
    assert zoomed.column_row(3.0, 3.0) == pytest.approx(layout.column_row(3.0, 3.0), abs=1.0)
    assert shown((column, row - round(0.15 * zoomed.scale)))
    screen.click("down", column, row)
    go(here, lambda: here._camera.seen().scale == pytest.approx(layout.scale))
    screen.click("up", column + 40, row)
    screen.click("up", column + 40, row)
    go(here, lambda: here._camera.seen().scale == pytest.approx(4.0 * layout.scale))
    screen.click("middle", column, row)
    go(here, lambda: here._camera.seen() == layout)
    steps(here, 1)
    assert shown(side)


def test_where_the_mouse_is_and_was_pressed(make: Make, screen: Screen) -> None:
    here = make()
    layout = here._camera.seen()
    go(here, lambda: here.mouse_pos is None)  # in the margin
    assert (here.mouse_left_pos, here.mouse_right_pos) == (None, None)
    for button, x, y in (("left", 7.0, 2.0), ("right", 1.0, 9.0)):
        screen.click(button, *(round(value) for value in layout.column_row(x, y)))
    go(here, lambda: here.mouse_right_pos is not None)
    pixel = 0.5 / layout.scale + 0.006
    assert here.mouse_left_pos == pytest.approx((7.0, 2.0), abs=pixel)
    assert here.mouse_right_pos == pytest.approx((1.0, 9.0), abs=pixel)
    assert here.mouse_pos == pytest.approx((1.0, 9.0), abs=pixel)
    assert here.mouse_left_pos == tuple(round(value, 2) for value in here.mouse_left_pos)
    screen.move(1200, 1000)
    go(here, lambda: here.mouse_pos is None)
    assert here.mouse_left_pos is not None  # a click is not forgotten


def test_drawing_is_switched_off_and_on(make: Make, screen: Screen) -> None:
    here = make()
    screen.type("y")
    go(here, lambda: not here.display)
    before = screen.picture()
    screen.down("w")
    go(here, lambda: here.robot.state[0] > 4.0)
    screen.up("w")
    assert np.array_equal(screen.picture(), before)
    screen.type("y")
    go(here, lambda: here.display)
    steps(here, 2)
    assert not np.array_equal(screen.picture(), before)


def test_a_closed_window_ends_the_world(make: Make, screen: Screen) -> None:
    here = make()
    steps(here, 2)
    screen.close_window(here.name)
    go(here, lambda: here.quit_flag)
    assert here.done()
    here.reset()
    assert here.done()  # loops around loops end as well
    assert here.end() is None  # at once: there is no window to linger
    assert threading.active_count() == 1


def test_a_window_lingers_at_the_end(make: Make, screen: Screen) -> None:
    here = make()
    screen.focus(here.name)
    ended = threading.Timer(0.3, lambda: screen.close_window(here.name))
    ended.start()
    here.end(20.0)  # until the person closes it
    ended.join()
    assert not screen.has_window(here.name)


def test_pictures_come_as_often_as_samples(make: Make) -> None:
    here = make(world={"sample_time": 0.2})
    shown = [here.render(0.0)]
    for _ in range(8):
        here.step([1.0, 0.0], 1)
        shown.append(here.render(0.0))
    changes = [int(not np.array_equal(a, b)) for a, b in pairwise(shown)]
    assert changes == [0, 0, 0, 1, 0, 0, 0, 1]  # every fourth step of 0.05 s


def test_watching_changes_nothing(make: Make) -> None:
    watched = make(robots=[{**ROBOT, "goal": [9, 9], "behavior": {"name": "dash"}}], world={"control_mode": "auto"})
    alone = irsim_gym.load(watched._levels._source)
    for _ in range(10):
        watched.step()
        watched.render(0.0)
        alone.step()
    for name in ("pose", "velocity", "random"):
        assert np.array_equal(getattr(watched.simulation.state, name), getattr(alone.simulation.state, name))
