"""What `check` and `train` say before a training about the levels that it will meet."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml
from command_line import run

import irsim_gym
from irsim_gym.errors import ScenarioError, ScenarioWarning
from irsim_gym.evaluation.levels.level_survey import inner_radius, survey
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.reading.notes import notes
from irsim_gym.scenario.specs import library
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import load_task
from irsim_gym.tasks.definition.sight import idle_robots
from irsim_gym.training.curves.verdict import verdict
from irsim_gym.training.requests.training_request import TrainingRequest

ROBOT: dict[str, Any] = {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [5, 5]}
OTHER: dict[str, Any] = {"kinematics": {"name": "diff"}, "state": [7, 7, 0], "goal": [1, 7]}
BOX: dict[str, Any] = {"shape": {"name": "rectangle", "length": 2, "width": 2}, "state": [5, 5, 0]}
DRAWN: dict[str, Any] = {"kinematics": {"name": "diff"}, "distribution": {"name": "random", "min_goal_distance": 3}}
ONE = "all levels are the same"


def world(robot: Any = ROBOT, obstacle: Any = (), **further: Any) -> dict[str, Any]:
    found = {"world": {"width": 8, "height": 8}, "robot": robot, "obstacle": obstacle}
    return copy.deepcopy({name: part for name, part in {**found, **further}.items() if part != ()})


def told(data: dict[str, Any], *, team: bool = False) -> list[str]:
    scenario = load_scenario(data, warn=False)
    return [note.message for note in survey(scenario, load_task(scenario, team=team))]


def square(half: float) -> dict[str, Any]:
    """A wall around the goal, without area."""
    low, high = 5.0 - half, 5.0 + half
    corners = [[low, low], [high, low], [high, high], [low, high], [low, low]]
    return {"shape": {"name": "linestring", "vertices": corners}}


@pytest.mark.parametrize(
    ("obstacle", "further", "name"),
    [
        (BOX, {}, "'obstacle_1'"),
        ((), {"world": {"width": 8, "height": 8, "obstacle_map": [[0, 0], [0, 100]]}}, "the obstacle map"),
    ],
)
def test_a_goal_in_an_obstacle_is_refused(obstacle: Any, further: dict[str, Any], name: str) -> None:
    with pytest.raises(ScenarioError, match=rf"robot_0: the goal \(5, 5\) lies in {name}"):
        told(world(obstacle=obstacle, **further))


def test_a_goal_is_not_refused_where_a_robot_can_arrive() -> None:
    """The robot of radius 0.2 m stands clear of the box, whose side is at x = 4, up to x = 3.8: 0.1 m from the goal."""
    reachable, deeper = ({**ROBOT, "goal": [x, 5], "goal_threshold": 0.1} for x in (3.89, 3.95))
    assert all(ONE in note for note in told(world(reachable, BOX)))
    with pytest.raises(ScenarioError):
        told(world(deeper, BOX))
    passing = world(ROBOT, BOX)
    passing["world"]["collision_mode"] = "unobstructed"
    assert len(told(passing)) == 1  # it drives through


def test_the_largest_disc_within_an_outline() -> None:
    """A car of 2 m by 1 m whose origin is 0.3 m before its rear, a triangle beside its origin, and two discs."""
    car = {"name": "polygon", "vertices": [[-0.3, -0.5], [1.7, -0.5], [1.7, 0.5], [-0.3, 0.5]]}
    beside = {"name": "polygon", "vertices": [[1, 0], [2, 0], [2, 1]]}
    parts = {"name": "compound", "parts": [{"name": "circle", "radius": 0.4}, {"name": "circle", "radius": 0.2}]}
    robots = [{**ROBOT, "shape": shape} for shape in ({"name": "circle", "radius": 0.25}, car, beside, parts)]
    model = compile(load_scenario(world(robots))).model
    assert [inner_radius(model, 0, b) for b in range(4)] == pytest.approx([0.25, 0.3, 0.0, 0.4])


def test_a_goal_that_walls_shut_in_is_noted() -> None:
    assert "no way wide enough for it leads to its goal" in told(world(obstacle=square(1.0)))[1]
    gap = square(1.0)
    gap["shape"]["vertices"].pop()
    assert len(told(world(obstacle=gap))) == 1


def test_a_time_limit_too_short_for_the_way_is_noted() -> None:
    """4 sqrt(2) m less the threshold of 0.1 m take 55.6 steps of 0.1 m."""
    short, enough = ({"name": "navigation", "max_steps": steps} for steps in (55, 56))
    assert "takes longer than max_steps (55)" in told(world(task=short))[1]
    assert len(told(world(task=enough))) == 1


def test_levels_are_counted_where_they_differ() -> None:
    """Every way is longer than 3 m; at 1 m/s, 20 steps lead 2 m."""
    (note,) = told(world(DRAWN, task={"name": "navigation", "max_steps": 20}))
    assert note.startswith("in 16 of the first 16 levels, the way to its goal takes longer")
    assert told(world(DRAWN)) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"vel_max": [1, 90]}, "a turn rate of 90 rad/s"),
        ({"kinematics": {"name": "acker", "wheelbase": 0.3}, "vel_max": [1, 30]}, "a steering angle of 30 rad"),
        ({"vel_max": [0, 1]}, "vel_max is 0: it can only drive backwards"),
        ({"vel_max": [0, 1], "vel_min": [0, -1]}, "vel_max is 0: it can only turn"),
        ({"sensors": [{"name": "lidar2d", "range_max": 5000}]}, "a range_max of 5000 m in a world of 11.3 m"),
        ({**DRAWN, "goal_threshold": 0.001}, "a step of 0.1 m may jump over a goal_threshold of 0.001 m"),
        ({**DRAWN, "distribution": {"name": "random"}}, "goals may be drawn where it starts"),
    ],
)
def test_limits_that_are_hardly_meant_are_noted(changes: dict[str, Any], words: str) -> None:
    robot = {**ROBOT, **changes}
    if "distribution" in robot:
        del robot["goal"], robot["state"]
    (note,) = notes(load_scenario(world(robot), warn=False))
    assert words in note.message


def test_a_learner_without_any_speed_is_refused() -> None:
    still = load_scenario(world({**ROBOT, "vel_max": [0, 0], "vel_min": [0, 0]}), warn=False)
    with pytest.raises(ScenarioError, match="cannot learn: its velocity limits vel_min and vel_max are all 0"):
        load_task(still)


def test_goals_farther_away_than_the_world_is_large() -> None:
    """Starts and goals lie in a square of 7 m, 0.5 m from the sides: at most 7 sqrt(2) m apart."""
    far = {**DRAWN, "distribution": {"name": "random", "min_goal_distance": 30}}
    with pytest.raises(ScenarioError, match=r"min_goal_distance 30 exceeds .* 9.9 m"):
        irsim_gym.make(world(far))


IDLE = "1 of 2 robots learns; robot_1 has no behavior and stands still"


def test_check_and_make_tell_which_robots_nobody_drives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pair = world([ROBOT, OTHER])
    file = tmp_path / "pair.yaml"
    file.write_text(yaml.safe_dump(pair), encoding="utf-8")
    assert run(monkeypatch, "check", file) == 0
    assert f"robot_0: {IDLE}; --team trains both" in capsys.readouterr().out
    assert run(monkeypatch, "check", file, "--team") == 0
    assert "stands still" not in capsys.readouterr().out
    assert run(monkeypatch, "check", file, "--task", "discrete_navigation") == 0
    assert "task 'discrete_navigation'" in capsys.readouterr().out
    with pytest.warns(ScenarioWarning, match=IDLE):
        irsim_gym.make(pair)
    for quiet in (world([ROBOT, {**OTHER, "behavior": {"name": "dash"}}]), {**pair, "task": {"agents": "robot_0"}}):
        scenario = load_scenario(quiet)
        assert idle_robots(scenario, load_task(scenario)) == ""


def test_a_diagnosis_names_the_robots_that_nobody_drives_first() -> None:
    scenario = load_scenario(world([ROBOT, OTHER]))
    names = ("stood_still", "hit_at_once", "no_way", "too_far", "collision", "timeout", "left_world", "success")
    point = {**dict.fromkeys(names, 0.0), "timeout": 1.0, "no_way": 1.0, "steps": 1e6}
    point |= {f"hit_{hit}": 0.0 for hit in ("obstacle", "moving_obstacle", "robot", "map")}
    lines = verdict(point, scenario, load_task(scenario), "look")
    assert lines[2] == f"  - {IDLE}: --team trains both"


def test_a_training_takes_a_script_with_another_lidar_but_a_team_does_not(tmp_path: Path) -> None:
    lidars = ({"sensors": [{"name": "lidar2d", "number": number}]} for number in (90, 30))
    learner, script = ({**robot, **lidar} for robot, lidar in zip((ROBOT, OTHER), lidars, strict=True))
    file = tmp_path / "two_lidars.yaml"
    file.write_text(yaml.safe_dump(world([learner, {**script, "behavior": {"name": "dash"}}])), encoding="utf-8")
    assert not TrainingRequest(str(file)).settings().is_team
    with pytest.raises(ScenarioError, match="learners of one task need range sensors of one kind"):
        TrainingRequest(str(file), team="episode").settings()


@pytest.mark.slow
@pytest.mark.parametrize("name", library.every_scenario())
def test_no_shipped_scenario_gets_another_note(name: str) -> None:
    scenario = load_scenario(name)
    likely = ("goals may be drawn where it starts",) if name in ("drl_robot_navigation", "rl_rvo_random") else ()
    assert all(note.message.startswith(likely) for note in notes(scenario))
    for team in {False, len(scenario.robots) > 1}:
        assert all(ONE in note.message for note in survey(scenario, load_task(scenario, team=team)))
