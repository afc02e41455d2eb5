"""What scripts for IR-SIM call: drawing options, films, logging, random goals, beams in colours."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from small_world import DIFF, SCENARIO, WALL, world

import irsim_gym
from irsim_gym.errors import NoEffectWarning, ScenarioError, UnknownNameError

FILE = "robot: {name: one}\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    return tmp_path


def painted(picture: Any, colour: tuple[int, int, int]) -> int:
    """Return how many pixels of a picture have nearly some colour."""
    return int((np.abs(picture.astype(int) - colour).max(axis=2) < 30).sum())


def test_a_picture_may_be_drawn_otherwise_than_the_file_says() -> None:
    here = irsim_gym.load(SCENARIO)
    for _ in range(5):
        here.step()
    plain = here.render()
    red = here.render(obj_color="red", show_goal=True, goal_color="blue")
    assert painted(plain, (255, 0, 0)) == painted(plain, (0, 0, 255)) == 0
    assert painted(red, (255, 0, 0)) > 500  # three discs of 12 pixels radius and a wall
    assert painted(red, (0, 0, 255)) > 0
    assert np.array_equal(here.render(), plain)  # for one picture alone, as in IR-SIM
    trace = here.render(show_trajectory=True)
    assert not np.array_equal(trace, plain)  # also the way that was driven before
    with pytest.raises(ScenarioError, match=r"plot.obj_alpha: .*2"):
        here.render(obj_alpha=2.0)
    assert np.array_equal(here.render(), plain)


def test_kept_frames_look_as_the_last_picture(here: Path) -> None:
    kept = irsim_gym.load("yard.yaml", record=True)
    kept.render(obj_color="red")
    kept.step()
    first, second = iio.imread(kept.save_animation("kept.gif"))[..., :3]
    assert painted(first, (255, 0, 0)) == 0
    assert painted(second, (255, 0, 0)) > 10


def test_figures_take_ir_sims_arguments(here: Path) -> None:
    yard = irsim_gym.load("yard.yaml")
    yard.step()
    assert yard.save_figure(save_name="one.png") == Path("one.png")
    assert yard.save_figure("two", True) == Path("two_0001.png")
    assert yard.save_figure("three.pdf", include_index=True) == Path("three_0001.pdf")
    yard.save_figure("coarse.png", dpi=50, bbox_inches="standard")
    yard.save_figure("fine.png", dpi=100, bbox_inches="standard", facecolor="red")
    coarse, fine = iio.imread("coarse.png"), iio.imread("fine.png")
    assert fine.shape[:2] == (2 * coarse.shape[0], 2 * coarse.shape[1])
    assert painted(fine[..., :3], (255, 0, 0)) > 1000
    with pytest.raises(ScenarioError, match=r"saved_figure.dpi"):
        yard.save_figure("bad.png", dpi=0)
    with pytest.warns(NoEffectWarning, match=r"save_figure\(\) knows no papertype"):
        yard.save_figure("one.png", papertype="a4")
    with pytest.raises(ValueError, match="no frames"):
        yard.save_animation("none.gif")
    yard.save_figure("four.png", save_gif=True)
    assert iio.imread(yard.save_animation("kept.gif")).shape[-1] == 3


def test_films_at_the_end(here: Path) -> None:
    first = irsim_gym.load("yard.yaml", save_ani=True, ani_kwargs={"ani_name": "named", "suffix": ".gif"})
    assert first.save_ani
    first.step()
    assert first.end(0, rm_fig_path=False) == Path("named.gif")
    second = irsim_gym.load("yard.yaml", save_ani=True)
    second.step()
    with pytest.warns(NoEffectWarning, match=r"end\(\) knows no show_traj, it changes nothing"):
        assert second.end(0, ani_name="other", suffix=".gif", show_traj=True) == Path("other.gif")
    third = irsim_gym.load("yard.yaml", save_ani=True)
    third.close(0.5)
    assert Path("yard.mp4").stat().st_size > 0
    Path("yard.mp4").unlink()
    third.close()  # nothing new to write
    with pytest.raises(ZeroDivisionError), irsim_gym.load("yard.yaml", save_ani=True):
        _ = 1 / 0
    assert not Path("yard.mp4").exists()


def test_quit_ends_the_program() -> None:
    here = world()
    with pytest.raises(SystemExit):
        here.quit()
    assert here.quit_flag
    assert here.done()


def test_the_file_by_ir_sims_name_and_another_one(here: Path) -> None:
    yard = irsim_gym.load(world_name="yard.yaml", log_level="DEBUG", full=True, projection="3d")
    Path("other.yaml").write_text("robot: {name: two}\n")
    Path("bad.yaml").write_text("robot: {nam: two}\n")
    with pytest.raises(ScenarioError, match="unknown key"):
        yard.reload("bad.yaml")
    assert yard.names == ["one"]
    yard.reload()
    assert yard.names == ["one"]
    yard.step()
    yard.reload("other.yaml")
    assert (yard.names, yard.status, yard.count, yard.name) == (["two"], "Reload", 0, "other")
    yard.reload()
    assert yard.names == ["two"]


def test_loggers_are_pythons_own(here: Path, caplog: pytest.LogCaptureFixture) -> None:
    yard = irsim_gym.load("yard.yaml", log_level="success")
    assert isinstance(yard.logger, logging.Logger)
    assert yard.logger.level == logging.INFO
    yard.logger.info("here")
    yard.logger.debug("not here")
    assert caplog.messages == ["here"]
    with pytest.raises(ValueError, match=r"log_level must be one of .*, got 'LOUD'"):
        irsim_gym.load("yard.yaml", log_level="LOUD")


def test_how_the_world_stands() -> None:
    here = world(world={"offset": [-1, 2]})
    here.step()
    assert here.world_param.time == here.time == 0.1
    told = here.world_param
    assert (told.count, told.step_time, told.sample_time) == (1, 0.1, 0.1)
    assert (told.control_mode, told.collision_mode, told.step_mode) == ("auto", "stop", "internal")
    assert (here.x_range, here.y_range) == ((-1.0, 9.0), (2.0, 12.0))
    assert (here.pause_flag, here.headless, here.disable_all_plot, here.save_ani) == (False, True, True, False)
    here.pause()
    assert here.pause_flag
    here.resume()
    here.set_status("Thinking")
    assert here.status == "Thinking"
    here.step_status()
    assert here.status == "Running"
    here.set_status("Thinking")
    here.step()
    assert here.status == "Running"
    here.reset_plot()


def test_the_step_mode_may_be_given() -> None:
    moved = irsim_gym.load(SCENARIO, step_mode="external")
    moved.step()
    assert moved.step_mode == moved.world_param.step_mode == "external"
    assert moved.robot.state.tolist() == [1.0, 1.0, 0.0]
    moved.reload()
    assert moved.step_mode == "external"
    with pytest.raises(ValueError, match="step_mode must be 'internal' or 'external', got 'inner'"):
        irsim_gym.load(SCENARIO, step_mode="inner")


def test_bodies_by_keyword() -> None:
    here = world()
    assert here.get_object_by_name("robot_1") == here[1]
    assert here.get_object_by_name("nobody") is None
    assert here.get_object_by_id(target_id=3) == here[3]
    assert here.get_object_by_id(77) is None
    assert here.get_robot_info(id=1).name == "robot_1"
    assert here.get_lidar_scan(id=0)["range_max"] == 6.0
    assert here.get_lidar_offset(id=0) == (0.1, 0.0, 0.0)
    here.delete_object(target_id=3)
    here.delete_objects(target_ids=[1])
    assert here.names == ["robot_0", "obstacle_2"]


def test_numbers_of_robots_are_positions_among_the_robots() -> None:
    """As in IR-SIM, also after a robot was added behind the obstacles, or deleted."""
    here = world()
    sensor = {"name": "lidar2d", "number": 3, "range_max": 2, "offset": [0.2, 0, 0]}
    here.create_robot(**DIFF, state=[6, 1, 0], goal=[1, 6, 0], name="late", sensors=[sensor])
    assert (here.robots[2].name, here["late"].id) == ("late", 4)
    info = here.get_robot_info(2)
    assert (info.name, info.id, info.goal.tolist()) == ("late", 4, [1, 6, 0])
    assert len(here.get_lidar_scan(2)["ranges"]) == len(here.get_lidar_scan(-1)["ranges"]) == 3
    assert here.get_lidar_offset(2) == here.get_lidar_offset("late") == (0.2, 0.0, 0.0)
    here.delete_object(1)
    assert here.get_robot_info(1).name == "late"
    with pytest.raises(UnknownNameError, match=r"no robot number 2; .* 0 'robot_0', 1 'late'"):
        here.get_robot_info(2)


def test_a_seed_may_begin_anew(here: Path) -> None:
    drawn = {"robot": {**DIFF, "distribution": {"name": "random"}}}
    first, second = irsim_gym.load(drawn, seed=7), irsim_gym.load(drawn, seed=1)
    second.set_random_seed(7, reload=True)
    assert np.array_equal(first.robot.state, second.robot.state)


FREE = {**SCENARIO["robot"][0], "state": [9, 9, 0]}
BLOCKED = {"shape": {"name": "rectangle", "length": 6, "width": 10}, "state": [3, 5, 0]}  # free from x = 6 on


def test_random_goals_are_clear_of_the_obstacles() -> None:
    disc = {"shape": {"name": "circle", "radius": 1}, "state": [8, 5, 0]}
    here = world(robot=FREE, obstacle=[BLOCKED, disc])
    robot = here.robot
    for _ in range(50):
        robot.set_random_goal(here.obstacle_list, goal_check_radius=0.5, range_limits=[[0, 0, 1], [10, 10, 1.5]])
        x, y, heading = robot.goal.tolist()
        assert x > 6.5
        assert np.hypot(x - 8, y - 5) > 1.5
        assert 1 <= heading < 1.5
    inside = 0
    for _ in range(50):
        robot.set_random_goal(here.obstacle_list, free=False)
        assert (robot.goal >= [0, 0, -np.pi]).all()
        assert (robot.goal < [10, 10, np.pi]).all()
        inside += robot.goal[0] < 6
    assert 15 < inside < 45  # 30 are expected, with a deviation of 3.5


def test_random_goals_avoid_the_map_and_lines() -> None:
    line = {"shape": {"name": "linestring", "vertices": [[0, 5], [10, 5]]}, "state": [0, 0, 0]}
    here = world(world={"obstacle_map": [[100, 0], [0, 0]]}, robot=FREE, obstacle=line)  # the lower left quarter
    robot = here.robot
    for _ in range(60):
        robot.set_random_goal(here.obstacle_list, goal_check_radius=0.4, range_limits=[[0, 0], [10, 10]])
        x, y = robot.goal[:2]
        assert abs(y - 5.0) > 0.4  # the line
        assert x > 5.4 or y > 5.4  # the quarter


def test_random_goals_come_back_and_are_as_many() -> None:
    here = world(robot={**SCENARIO["robot"][0], "goal": [[2, 2, 0], [3, 3, 0], [4, 4, 0]]})
    robot = here.robot
    robot.set_random_goal([], init=True)
    drawn = robot.goals
    assert drawn.shape == (3, 3)
    robot.set_goal([1, 9, 0])
    here.reset()
    assert np.array_equal(robot.goals, drawn)
    again = world(robot={**SCENARIO["robot"][0], "goal": [[2, 2, 0], [3, 3, 0], [4, 4, 0]]})
    again.robot.set_random_goal()
    assert np.array_equal(again.robot.goals, drawn)  # from the world's stream


def test_a_goal_without_room() -> None:
    here = world(robot=FREE, obstacle=BLOCKED)
    with pytest.warns(NoEffectWarning, match="no place clear of the obstacles for a goal of 'robot_0' in 5 draws"):
        here.robot.set_random_goal(here.obstacle_list, range_limits=[[1, 1], [2, 2]], max_attempts=5)
    assert (here.robot.goal[:2] >= [1, 1]).all()
    assert (here.robot.goal[:2] < [2, 2]).all()
    for limits in ([[0, 0], [-1, 10]], [[0], [10]], [["a", 0], [1, 1]]):
        with pytest.raises(ValueError, match="range_limits"):
            here.robot.set_random_goal([], range_limits=limits)
    with pytest.raises(ValueError, match="max_attempts is 1 or more"):
        here.robot.set_random_goal([], max_attempts=0)


def test_beams_in_colours_of_their_own(tmp_path: Path) -> None:
    lidar = {"name": "lidar2d", "number": 60, "range_max": 4, "angle_range": 3.0}
    looker = {**DIFF, "state": [3, 5, 0], "sensors": [lidar]}
    here = irsim_gym.load({"robot": [looker, {**looker, "state": [3, 2, 0]}]}, record=True)
    robot, plain = here.robot, here.render()
    robot.set_laser_color(range(30), "blue", 1.0)  # the right half, below y = 5
    blue = here.render()
    apart = np.argwhere(np.abs(blue.astype(int) - plain).max(axis=2) > 3)
    highest = apart[:, 0].min()
    assert painted(blue, (0, 0, 255)) > painted(plain, (0, 0, 255)) == 0
    assert 290 <= highest <= 320  # y = 5 is in the middle of the picture
    robot.set_laser_color(np.arange(200), alpha=0.0)  # more than there are
    assert np.array_equal(here.render(), plain)
    robot.set_laser_color([])
    assert np.array_equal(here.render(), plain)
    robot.set_laser_color([0, 5])
    here.step()
    here.save_html(tmp_path / "run.html")
    with pytest.raises(ValueError, match="no colour named 'blu'"):
        robot.set_laser_color([0], "blu")
    with pytest.raises(ValueError, match="between 0 and 1, got 2"):
        robot.set_laser_color([0], "blue", 2)
    with pytest.raises(UnknownNameError, match="no range sensor"):
        world()[1].set_laser_color([0])


@pytest.mark.filterwarnings("ignore:seldom meant:irsim_gym.errors.ScenarioWarning")
def test_painted_beams_follow_the_scan() -> None:
    lidar = {"name": "lidar2d", "number": 21, "range_max": 4}
    robot = {**DIFF, "state": [1, 5, 0], "vel_max": [10, 1], "sensors": [lidar]}
    here = irsim_gym.load({"robot": robot, "obstacle": WALL})
    here.robot.set_laser_color(range(8, 13), "blue", 1.0)
    here.render()
    here.step([10.0, 0.0])  # a metre nearer to the wall
    seen = here.render()
    anew = irsim_gym.load({"robot": robot, "obstacle": WALL})
    anew.robot.set_laser_color(range(8, 13), "blue", 1.0)
    anew.step([10.0, 0.0])
    assert np.array_equal(seen, anew.render())


@pytest.mark.parametrize(
    "call",
    [
        lambda here: irsim_gym.load(SCENARIO, ani_kwargs={"colour": 1}),
        lambda here: here.render(show_traj=True),
        lambda here: here.render(figure_kwargs={"dpi": 1}),
        lambda here: here.end(0, colour=1),
        lambda here: here.end(0, "film.gif"),
        lambda here: here.close(0, colour=1),
        lambda here: here.show(),
    ],
)
def test_warnings_point_at_the_script(call: Callable[[Any], Any]) -> None:
    with pytest.warns(NoEffectWarning) as told:
        call(world())
    assert [Path(warning.filename).name for warning in told] == [Path(__file__).name]
