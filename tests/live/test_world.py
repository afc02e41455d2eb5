"""Stepping, status, done and resets of a world that is run by hand."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_world import DIFF, SCENARIO, WALL, world

import irsim_gym
from irsim_gym.errors import NoEffectWarning, NoKeyboardWarning, NoWindowError, ScenarioError, UnknownNameError


def test_behaviours_drive_without_an_action() -> None:
    here = world()
    assert (here.status, here.time, here.count, here.step_time, here.name) == ("None", 0.0, 0, 0.1, "world")
    here.step()
    assert here.robot.state.tolist() == pytest.approx([1.0 + 0.1 * np.cos(np.pi / 4), 1.0, 0.1])
    assert here["robot_1"].state.tolist() == [1, 5, 0]  # nobody drives it
    assert (here.status, here.count) == ("Running", 1)


@pytest.mark.parametrize(
    ("action", "action_id", "expected"),
    [
        ([0.5, 0.2], None, {0: [0.5, 0.2]}),
        ((0.5, 0.2), "robot_1", {1: [0.5, 0.2]}),
        (np.array([0.5, 0.2]), 3, {3: [0.5, 0.2]}),
        (np.array([[0.5], [0.2]]), 1, {1: [0.5, 0.2]}),
        ([0.5, 0.2], [0, "obstacle_3"], {0: [0.5, 0.2], 3: [0.5, 0.2]}),
        ([[0.5, 0.2], [0.1, 0.0]], None, {0: [0.5, 0.2], 1: [0.1, 0.0]}),
        ([[0.5, 0.2], None, None, [0.3, 0.1]], None, {0: [0.5, 0.2], 3: [0.3, 0.1]}),
        ([[0.5, 0.2], [0.1, 0.0], [0.3, 0.0]], 1, {1: [0.5, 0.2], 3: [0.3, 0.0]}),
        ([[0.5, 0.2], [0.1, 0.0]], ["obstacle_3", 1], {3: [0.5, 0.2], 1: [0.1, 0.0]}),
        ([np.array([[0.5], [0.2]])], "robot_1", {1: [0.5, 0.2]}),
        ({"robot_1": [0.5, 0.2], "obstacle_3": [9.0, 0.0]}, None, {1: [0.5, 0.2], 3: [1.0, 0.0]}),
        ([], None, {}),
    ],
)
def test_actions(action: Any, action_id: Any, expected: dict[int, list[float]]) -> None:
    here = world()
    here.step(action, action_id)
    own = {0: [np.cos(np.pi / 4), 1.0], 1: [0, 0], 3: [0, 0]}
    for number, velocity in {**own, **expected}.items():
        assert here[number].velocity.tolist() == pytest.approx(velocity), number


@pytest.mark.parametrize(
    ("action", "action_id", "error", "message"),
    [
        ([0.5, 0.2], "robot_7", ValueError, "no body named 'robot_7'"),
        ([0.5, 0.2], 17, ValueError, "no body number 17"),
        ([0.5, 0.2, 0.1], 0, ValueError, r"'robot_0' has 2 numbers \(linear, angular\), got 3"),
        ([0.5, float("nan")], 0, ValueError, "must be finite"),
        ([[0.5, 0.2]] * 5, None, ValueError, "5 actions for 4 bodies"),
        ([[0.5, 0.2]], [0, 1], ValueError, "1 actions for 2 bodies"),
        ({"robot_0": [0.5, 0.2]}, 0, ValueError, "leave action_id out"),
        (5, 0, TypeError, "an action is a list"),
    ],
)
def test_bad_actions(action: Any, action_id: Any, error: type[Exception], message: str) -> None:
    here = world()
    with pytest.raises(error, match=message):
        here.step(action, action_id)
    assert here.count == 0


def test_status_and_done() -> None:
    near = {**DIFF, "state": [1, 1, 0], "goal": [1.05, 1, 0]}
    far = {**DIFF, "state": [1, 5, 0], "goal": [9, 5, 0]}
    here = world(robot=[near, far])
    assert not here.done()
    here.step()
    assert (here.status, here.done("any"), here.done("all")) == ("Running", True, False)
    here["robot_1"].set_goal([1, 5.05])
    here.step()
    assert (here.status, here.done()) == ("Arrived", True)
    here["robot_1"].set_goal([9, 5])
    here["robot_1"].set_state([5, 4.6, 0])  # 0.4 m below the middle of the wall, whose half is 0.25 m
    here.step()
    assert (here.status, here["robot_1"].collided, here["robot_1"].stopped) == ("Collision", True, True)
    assert here["robot_1"].hit == here["obstacle_2"]
    assert here.done()  # one has arrived, the other is held
    with pytest.raises(ValueError, match="'all' or 'any'"):
        here.done("some")  # type: ignore[arg-type]


def test_a_world_without_robots() -> None:
    here = world(robot=None)
    here.step()
    assert (here.status, here.done(), here.done("any"), here.robots) == ("Running", False, False, [])
    with pytest.raises(UnknownNameError, match="no robot"):
        _ = here.robot


def test_pause() -> None:
    here = world()
    here.pause()
    here.step([9, 9, 9, 9])  # nothing happens at all
    assert (here.status, here.count) == ("Pause", 0)
    here.resume()
    here.step()
    assert (here.status, here.count) == ("Running", 1)


def test_a_file_may_begin_paused() -> None:
    here = world(world={"status": "Pause"})
    here.step()
    assert (here.status, here.count) == ("Pause", 0)
    here.resume()
    here.step()
    assert here.count == 1
    here.reset()
    assert here.status == "Pause"


def test_the_clock_is_not_rounded() -> None:
    here = world(world={"step_time": 0.004})
    for _ in range(3):
        here.step()
    assert here.time == pytest.approx(0.012, abs=1e-15)


def test_reset_repeats_the_run() -> None:
    robot = {**SCENARIO["robot"][0], "distribution": {"name": "random"}}
    here = world(robot=robot)
    first = here.robot.state
    for _ in range(3):
        here.step([0.5, 0.3])
    path = here.robot.trajectory
    assert path.shape == (4, 3)
    here.reset()
    assert (here.status, here.time) == ("Reset", 0.0)
    assert np.array_equal(here.robot.state, first)
    for _ in range(3):
        here.step([0.5, 0.3])
    assert np.array_equal(here.robot.trajectory, path)
    here.reset(random=True)
    assert not np.array_equal(here.robot.state, first)


def test_seeds_choose_levels() -> None:
    robot = {**SCENARIO["robot"][0], "distribution": {"name": "random"}}
    one, two, other = world(robot=robot, seed=5), world(robot=robot, seed=5), world(robot=robot, seed=6)
    assert np.array_equal(one.robot.state, two.robot.state)
    assert not np.array_equal(one.robot.state, other.robot.state)
    one.reset(random=True)
    two.reset(random=True)
    assert np.array_equal(one.robot.state, two.robot.state)
    one.set_random_seed(6)
    one.reset(random=True)
    assert np.array_equal(one.robot.state, other.robot.state)
    env = irsim_gym.make({**SCENARIO, "robot": robot})
    env.reset(seed=5)
    two.set_random_seed(5)
    two.reset(random=True)
    assert np.array_equal(env.unwrapped.worlds.episodes.simulation.state.pose[0, 0], two.robot.state)


@pytest.mark.parametrize("seed", [2**52 + 5, 2**63 - 1, 2**70 + 3])
def test_large_seeds_are_those_of_environments(seed: int) -> None:
    """Whatever seed Gymnasium takes: they count from 0 again after 2**52."""
    robot = {**SCENARIO["robot"][0], "distribution": {"name": "random"}}
    large, small = world(robot=robot, seed=seed), world(robot=robot, seed=seed % 2**52)
    assert np.array_equal(large.robot.state, small.robot.state)
    large.set_random_seed(seed)
    large.reset(random=True)
    assert np.array_equal(large.robot.state, small.robot.state)


def test_reload_reads_the_file_again(tmp_path: Path) -> None:
    file = tmp_path / "yard.yaml"
    file.write_text("robot: {name: one}\n")
    with irsim_gym.load(file) as here:
        assert (here.name, here.names) == ("yard", ["one"])
        file.write_text("robot: {name: two}\n")
        here.reset(random=True)
        assert here.names == ["one"]
        here.reload()
        assert (here.names, here.status) == (["two"], "Reload")
        here.step()
        assert here.status == "Running"
    here.end()


def test_external_steps_leave_the_moving_to_the_caller() -> None:
    here = world(world={"step_mode": "external"})
    here.step()
    assert here.robot.state.tolist() == [1, 1, 0]
    here.robot.set_state([5, 4.6, 0])
    here.step()
    assert (here.status, here.robot.collided, here.count) == ("Collision", True, 2)
    with pytest.raises(ValueError, match="external"):
        here.step([1, 0])


def test_the_keyboard_is_told_of_once() -> None:
    with pytest.warns(NoKeyboardWarning, match="the behaviours drive"):
        here = world(world={"control_mode": "keyboard"})
    here.step()
    assert here.robot.velocity[1] == 1.0


def test_bad_files_and_modes() -> None:
    with pytest.raises(ScenarioError, match="did you mean"):
        irsim_gym.load({"wrld": {}})
    with pytest.raises(UnknownNameError, match="no scenario named"):
        irsim_gym.load("cluttered_rom")
    with pytest.raises(ValueError, match="must be None, 'rgb_array' or 'human', got"):
        irsim_gym.load({"obstacle": WALL}, render_mode="rgb_array_list")


def test_a_world_without_a_window_has_no_keys_and_no_mouse(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    here = world(gui={"keyboard": {"key_id": 1}})
    assert (here.control_mode, here.display, here.quit_flag, here.key_id) == ("auto", False, False, 1)
    assert here.key_vel.tolist() == [0.0, 0.0, 0.0]
    assert (here.mouse_pos, here.mouse_left_pos, here.mouse_right_pos) == (None, None, None)
    with pytest.warns(NoEffectWarning, match="render_mode='human'"):
        here.show()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
def test_a_window_without_a_display_is_an_error_or_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    here = irsim_gym.load({"obstacle": WALL}, render_mode="human")
    here.step()
    with pytest.raises(NoWindowError, match="no display"):
        here.render()
    assert here.end() is None
    shown = irsim_gym.load({"obstacle": WALL}, display=True)  # IR-SIM's argument: such scripts run on servers
    with pytest.warns(NoEffectWarning, match="display=True shows nothing.*no display"):
        picture = shown.render()
    shown.step()
    assert shown.render().shape == picture.shape  # told once
    assert (shown.headless, shown.display) == (True, False)
    with pytest.warns(NoEffectWarning, match="no window to show"):
        shown.show()
    assert shown.end() is None
    assert irsim_gym.load({"obstacle": WALL}, display=True, disable_all_plot=True).headless
