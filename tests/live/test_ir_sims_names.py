"""IR-SIM's names: those that work, and what is said of those that are not here."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_world import DIFF, SCENARIO, WALL, world

import irsim_gym
from irsim_gym.errors import NoEffectWarning, UnknownNameError

FILE = "robot: {name: one}\n"
CELLS = [[0, 100, 0], [0, 0, 0]]  # columns from the left, rows from the bottom


def test_a_body_is_changed_by_its_methods_alone() -> None:
    world = irsim_gym.load({"robot": {"kinematics": {"name": "diff"}}})
    for name, said in {
        "state": r"state cannot be assigned: use set_state\(",
        "goal": r"goal cannot be assigned: use set_goal\(",
        "collided": "collided cannot be assigned; set_state, set_velocity and set_goal change a body",
        "stat": r"a body has no 'stat' \(did you mean 'state'\?\)",
    }.items():
        with pytest.raises(AttributeError, match=said):
            setattr(world.robot, name, [1, 1, 0])


def test_names_of_a_body() -> None:
    near = {**SCENARIO["robot"][0], "goal": [1.05, 1, 0], "goal_threshold": 0.3, "vel_max": [1.5, 2], "acce": [30, 40]}
    here = world(robot=[{**near, "color": "red", "fov": 1.0, "fov_radius": 5.0, "angle_range": [0, "2*pi"]}, DIFF])
    robot = here.robot
    assert (robot.arrive, robot.arrive_flag, robot.collision, robot.collision_flag, robot.stop_flag) == (False,) * 5
    here.step([1.0, 1.0])
    assert (robot.arrive, robot.arrive_flag, robot.done()) == (True, True, True)
    assert robot.position.tolist() == robot.state[:2].tolist()
    assert robot.orientation == robot.heading == pytest.approx(0.1)
    assert robot.velocity_xy.tolist() == pytest.approx([np.cos(0.1), np.sin(0.1)])
    assert (robot.shape, robot.kinematics, robot.wheelbase, here[2].kinematics) == ("circle", "diff", None, None)
    assert (robot.vel_min.tolist(), robot.vel_max.tolist()) == ([-1.0, -1.0], [1.5, 2.0])
    assert robot.acce.tolist() == [30.0, 40.0]
    assert (robot.color, robot.description, robot.goal_threshold, robot.arrive_mode) == ("red", None, 0.3, "position")
    assert (robot.fov, robot.fov_radius, robot.unobstructed) == (1.0, 5.0, False)
    assert robot.angle_range == pytest.approx((0, 2 * np.pi))
    assert [sensor.number for sensor in robot.sensors] == [5]
    assert robot.external_objects == here.objects[1:]
    assert robot.get_info().name == "robot_0"
    assert robot.get_obstacle_info().radius == pytest.approx(0.2)
    assert robot.get_lidar_scan()["range_max"] == 6.0
    assert robot.get_lidar_offset() == (0.1, 0.0, 0.0)
    robot.set_state([4, 5, 0])
    here.refresh()
    points = robot.get_lidar_points()
    assert points is not None
    assert points[:, 0].tolist() == pytest.approx([4.5 - 4.1, 0.0], abs=1e-6)
    assert robot.get_fov_detected_objects() == [here[2]]
    assert robot.fov_detect_object(here[2])
    assert not robot.fov_detect_object(here[1])
    robot.set_state([5, 4.6, 0])
    here.step()
    assert (robot.collision, robot.collision_flag, robot.stop_flag) == (True, True, True)


def test_an_omni_body_heads_where_it_moves() -> None:
    here = world(robot={**DIFF, "kinematics": {"name": "omni"}, "state": [1, 1, 0.5]})
    assert here.robot.heading == 0.5
    here.step([0.0, 0.8])
    assert here.robot.heading == pytest.approx(np.pi / 2)
    assert here.robot.orientation == 0.5


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gf", r"a body has no 'gf': use shape, kinematics, geometry"),
        ("_goal", "use goal, goals"),
        ("plot_goal", "render"),
        ("apply_contact_velocity", "set_velocity"),
        ("goal_treshold", r"did you mean 'goal_threshold'\?"),
        ("qqqq", "a body has no 'qqqq'$"),
        ("_qqqq", "no attribute '_qqqq'"),
    ],
)
def test_what_a_body_has_not(name: str, said: str) -> None:
    robot = world().robot
    with pytest.raises(AttributeError, match=said):
        getattr(robot, name)
    assert not hasattr(robot, name)
    with pytest.raises(AttributeError):
        setattr(robot, name, 1)  # it would be lost: a view holds nothing of its own


def test_arrays_cannot_be_written_into() -> None:
    here = world(obstacle=WALL)
    robot, wall = here.robot, here["obstacle_2"]
    info, place = robot.info, wall.obstacle_info
    arrays = [robot.state, robot.velocity, robot.twist, robot.goal, robot.goals, robot.trajectory, robot.position]
    arrays += [robot.velocity_xy, robot.vel_min, robot.vel_max, robot.acce, wall.vertices, here.get_robot_state()]
    arrays += [info.goal, info.vel_min, info.vel_max, info.acce, place.center, place.vertex, place.velocity]
    for array in arrays:
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 3.0


@pytest.mark.parametrize(
    ("setter", "numbers", "said"),
    [
        ("set_state", [1], r"a state of 'robot_0' has 2 to 3 finite numbers \(x, y, heading\), got \[1\]"),
        ("set_state", [], "got \\[\\]"),
        ("set_state", "here", "got 'here'"),
        ("set_state", [1, 2, 3, 4], "2 to 3"),
        ("set_velocity", [1], r"a velocity of 'robot_0' has 2 finite numbers \(linear, angular\), got \[1\]"),
        ("set_velocity", [1, np.nan], "finite"),
        ("set_velocity", [[1, 2], [3]], "finite"),
        ("set_goal", [1], "a goal is"),
        ("set_goal", "there", "a goal is"),
        ("set_goal", 4, "a goal is"),
    ],
)
def test_too_few_numbers(setter: str, numbers: Any, said: str) -> None:
    here = world()
    with pytest.raises(ValueError, match=said):
        getattr(here.robot, setter)(numbers)
    assert here.robot.state.tolist() == [1, 1, 0]


def test_names_of_a_world() -> None:
    here = world()
    assert (here.robot_number, here.obstacle_number) == (2, 2)
    assert [body.name for body in here.static_objects] == ["obstacle_2"]
    assert len(here.dynamic_objects) == 3
    assert here.get_map().grid is None
    assert here.get_map(bodies=True).grid.shape == (100, 100)
    added = here.create_obstacle(**WALL | {"state": [8, 2, 0]})
    here.add_object(added)
    here.add_objects([added])
    assert here.obstacle_number == 3
    with pytest.raises(TypeError, match="create_robot"):
        here.add_object(world()[0])
    with pytest.raises(KeyError, match="no body number 17"):
        here.delete_objects([2, 17])
    here.delete_objects([2, "obstacle_3", 2])
    assert here.names == ["robot_0", "robot_1", "obstacle_4"]


def test_the_map_as_cells() -> None:
    here = world(world={"obstacle_map": CELLS, "offset": [-1, 2], "height": 9}, obstacle=None, robot=None)
    cells = here.get_map()
    assert (cells.world_offset, cells.grid_resolution) == ((-1.0, 2.0), (5.0, 3.0))
    assert cells.occupied.tolist() == [[False, True, False], [False, False, False]]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("keyboard", "use key_vel, key_id"),
        ("_env_plot", "save_figure"),
        ("plot_points", r"world\.draw draws over them"),
        ("config", r"world\.scenario"),
        ("robt_list", r"did you mean 'robot_list'\?"),
        ("qqqq", "a world has no 'qqqq'$"),
        ("_qqqq", "no attribute '_qqqq'"),
    ],
)
def test_what_a_world_has_not(name: str, said: str) -> None:
    with pytest.raises(AttributeError, match=said):
        getattr(world(), name)


def test_a_property_that_fails_tells_why(monkeypatch: pytest.MonkeyPatch) -> None:
    here = world()
    monkeypatch.setattr(here._session, "roster", None)
    with pytest.raises(AttributeError, match="'NoneType' object has no attribute"):
        _ = here.names


def test_arguments_of_ir_sims_scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    here = irsim_gym.load("yard.yaml", display=False, headless=True, disable_all_plot=True, save_ani=True, seed=None)
    here.step()
    here.render(0.01)
    assert here.end(3.0) == Path("yard.mp4")
    assert Path("yard.mp4").stat().st_size > 0
    assert here.end() is None  # nothing new to write
    kept = irsim_gym.load("yard.yaml", record=True)
    kept.close()
    assert kept.end(ani_name="other.gif") == Path("other.gif")
    with pytest.warns(NoEffectWarning, match="record=True"):
        assert irsim_gym.load("yard.yaml").end(ani_name="none.gif") is None
    assert not Path("none.gif").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"display": True, "headless": True}, "takes no headless=True where a window is asked for as well"),
        ({"render_mode": "human", "display": False}, "takes no display=False where a window"),
        ({"full": True, "display": True}, "takes no full=True: the window is as large as the picture"),
        ({"log_file": "log.txt"}, "FileHandler"),
        ({"projection": "4d"}, "in the plane"),
        ({"seed": "a"}, "a seed is a whole number, got 'a'"),
    ],
)
def test_arguments_that_mean_nothing(arguments: dict[str, Any], said: str) -> None:
    with pytest.raises(TypeError, match=said):
        irsim_gym.load(SCENARIO, **arguments)


def test_arguments_that_nobody_knows() -> None:
    with pytest.raises(UnknownNameError, match=r"has no parameter 'sed' \(did you mean 'seed', an argument of load"):
        irsim_gym.load(SCENARIO, sed=3)


def test_seeds_are_whole_numbers() -> None:
    here = world()
    for bad in ("a", 1.5, None, True):
        with pytest.raises(TypeError, match="a seed is a whole number"):
            here.set_random_seed(bad)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="0 or more"):
        here.set_random_seed(-1)
    here.set_random_seed(np.int64(4))  # type: ignore[arg-type]
    here.reset(random=True)


def test_without_a_file_the_script_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", [str(tmp_path / "yard.py")])
    with pytest.raises(TypeError, match=r"there is no yard\.yaml beside the script"):
        irsim_gym.load()
    (tmp_path / "yard.yaml").write_text(FILE)
    assert irsim_gym.load().names == ["one"]


def test_render_takes_ir_sims_arguments_that_change_nothing() -> None:
    here = world()
    plain = here.render()
    for mode in ("dynamic", "static", "all"):
        assert np.array_equal(here.render(0.05, figure_kwargs={}, mode=mode), plain)
    with pytest.warns(NoEffectWarning, match="figure_pixels"):
        assert np.array_equal(here.render(figure_kwargs={"dpi": 300}), plain)
    with pytest.warns(NoEffectWarning, match=r"show_traj, it changes nothing \(did you mean 'show_trail'"):
        here.render(show_traj=True)
    with pytest.raises(ValueError, match="mode must be 'dynamic', 'static' or 'all', got 'dynamc'"):
        here.render(mode="dynamc")
