"""Observations as of when the next command acts, and the actions that are under way, worked out by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from task_tools import BALL, ROBOT, drive, play

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.evaluation.policies.perception import perceived_task, perception_from, perception_of
from irsim_gym.tasks import Episodes, load_task

AHEAD = (1.0, 0.0)


def late(time: Any = 0.3, **keys: Any) -> dict[str, Any]:
    return {"disturbances": [{"name": "latency", "time": time}], **keys}


def task(*observations: Any, predict: Any = True) -> dict[str, Any]:
    return {"name": "blank", "observations": list(observations), "predict": predict}


def seen(episodes: Episodes) -> Any:
    return episodes.view.observation[0, 0]


@pytest.mark.parametrize("predict", [True, 0.3])
def test_a_goal_is_seen_from_where_the_next_command_acts(predict: Any) -> None:
    episodes = play(late(), task=task({"name": "goal", "scale": 10.0}, predict=predict))
    distances = [seen(episodes)[0]]
    for _ in range(5):
        drive(episodes, *AHEAD)
        distances.append(seen(episodes)[0])
    # It stands 6 m before the goal until the fourth step. Each command under way is 0.1 m.
    assert distances == pytest.approx([0.6, 0.59, 0.58, 0.57, 0.56, 0.55], abs=1e-6)
    assert episodes.simulation.state.pose[0, 0, 0] == pytest.approx(2.2)


def test_a_part_of_a_step_is_predicted_first() -> None:
    episodes = play(task=task({"name": "goal", "scale": 10.0}, predict=0.15))
    drive(episodes, *AHEAD)
    drive(episodes, *AHEAD)
    # At x = 2.2 m; the older of the two commands under way acts for 0.05 s more, the newer one for 0.1 s.
    assert seen(episodes)[0] == pytest.approx(0.565, abs=1e-6)


def test_a_turn_turns_the_scan_and_a_drive_brings_it_nearer() -> None:
    linear = {"name": "scan", "sectors": 180, "code": "linear"}
    robot = late(sensors=[{**ROBOT["sensors"][0], "offset": [0.1, 0, 0]}], goal_threshold=0.1)
    episodes = play(robot, BALL, task(linear))
    for _ in range(3):
        drive(episodes, *AHEAD)
    # The ball begins at x = 4.5 m, the sensor stands at 2.1 m, and will stand at 2.4 m: 2.1 m, less 0.1 m of the robot.
    assert seen(episodes)[89:91] == pytest.approx([1 - 2.0 / 6] * 2, abs=0.003)
    for _ in range(3):
        drive(episodes, -1.0, 1.0)
    # It will have turned left by 0.45 rad: the ball lies to its right, 13 beams from the middle.
    assert np.argmax(seen(episodes)) == pytest.approx(89.5 - 0.45 / (2 * np.pi / 179), abs=1.5)


def test_limits_of_acceleration_hold_on_the_way() -> None:
    episodes = play({"acce": [2.0, 1e3]}, task=task({"name": "goal", "scale": 10.0}, "velocity", predict=0.3))
    for _ in range(2):
        drive(episodes, *AHEAD)
    # 0.2 and 0.4 m/s took it to 2.06 m. Under way are two commands: it stands in between, then speeds up again.
    assert episodes.simulation.state.pose[0, 0, 0] == pytest.approx(2.06)
    assert seen(episodes)[[0, 4]] == pytest.approx([0.6 - 0.006 - 0.002 - 0.004 - 0.006, 0.6], abs=1e-6)


def test_a_car_by_turn_rate_that_stands_is_not_predicted_to_turn() -> None:
    shape = {"name": "rectangle", "length": 0.6, "width": 0.4, "wheelbase": 0.4}
    car = late(kinematics={"name": "acker", "mode": "angular"}, shape=shape)
    episodes = play(car, task=task("heading"))
    for _ in range(4):
        drive(episodes, -1.0, 1.0)
    assert episodes.simulation.state.pose[0, 0, 2] == 0.0
    assert seen(episodes) == pytest.approx([1.0, 0.0])
    for _ in range(3):
        drive(episodes, 1.0, 1.0)
    # It still stands: three commands that turn it by 0.15 rad each are under way.
    assert seen(episodes) == pytest.approx([np.cos(0.45), np.sin(0.45)])


def test_levels_that_draw_their_latency_are_predicted_by_it() -> None:
    episodes = play(late([0.0, 0.5]), task=task("position", "heading"), n_worlds=6)
    rng = np.random.default_rng(0)
    poses, predicted = [], []
    for _ in range(30):
        poses.append(episodes.simulation.state.pose[:, 0].copy())
        predicted.append(episodes.view.observation[:, 0].copy())
        episodes.step(rng.uniform([-1.0, -0.3], [1.0, 0.3], (6, 1, 2)))
    steps = {w: int(n) for w, n in enumerate(episodes.simulation.parts.disturbances.groups[0].arrays["steps"][:, 0])}
    assert len(set(steps.values())) > 2
    for w, n in steps.items():
        then = np.array(poses)[n:, w]
        told = np.array(predicted)[: 30 - n, w]
        np.testing.assert_allclose(told[:, :2] * 5.0 + 5.0, then[:, :2], atol=0.01)
        np.testing.assert_allclose(told[:, 2:], np.stack([np.cos(then[:, 2]), np.sin(then[:, 2])], axis=1), atol=1e-6)


def test_without_a_latency_nothing_changes() -> None:
    envs = [gymnasium.make("irsim_gym/cluttered_room-v0", **given) for given in ({}, {"predict": True})]
    rng = np.random.default_rng(0)
    for env in envs:
        env.reset(seed=3)
    for _ in range(20):
        action = rng.uniform(-1, 1, 2).astype(np.float32)
        one, other = (env.step(action)[0] for env in envs)
        np.testing.assert_array_equal(one, other)


def test_batch_single_and_threads_predict_the_same() -> None:
    given: dict[str, Any] = {"disturbances": "latency:time=[0, 0.4]; lost_beams:chance=0.1", "predict": True}
    given["task"] = {
        "observations": ["pending", "past_scans", "way_on_seen_map", {"name": "nearest_bodies", "count": 2}]
    }
    envs, threads = (
        gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, **given, **more)
        for more in ({}, {"num_threads": 3})
    )
    single = gymnasium.make("irsim_gym/cluttered_room-v0", **given)
    found, _ = envs.reset(seed=7)
    other, _ = threads.reset(seed=7)
    alone, _ = single.reset(seed=7 + 3)
    rng = np.random.default_rng(0)
    for _ in range(30):
        np.testing.assert_array_equal(found, other)
        np.testing.assert_array_equal(found[3], alone)
        actions = rng.uniform(-1, 1, (5, 2)).astype(np.float32)
        found, _, ended, cut, _ = envs.step(actions)
        other, *_ = threads.step(actions)
        alone, *_ = single.step(actions[3])
        if ended[3] or cut[3]:
            break


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("-0.1", "yard.yaml:5   task.predict: must lie from 0 to 10 seconds, or be true or false, got -0.1"),
        ("11", "yard.yaml:5   task.predict: must lie from 0 to 10 seconds, or be true or false, got 11"),
        ("measured", "yard.yaml:5   task.predict: must be a number or true or false, got 'measured'"),
    ],
)
def test_bad_times_are_refused_with_their_line(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "yard.yaml"
    file.write_text(f"robot:\n  kinematics: {{name: diff}}\n  goal: [5, 5]\ntask:\n  predict: {text}\n")
    with pytest.raises(ScenarioError) as error:
        load_task(ig.load_scenario(file))
    assert said in str(error.value)


def test_what_cannot_be_predicted_is_refused() -> None:
    with pytest.raises(ScenarioError, match="'occupancy_image' cannot be predicted: leave out either it or 'predict'"):
        play(task=task("occupancy_image"))
    team = [{**ROBOT, "sensors": []}, {**ROBOT, "sensors": [], "state": [2, 8, 0]}]
    with pytest.raises(ScenarioError, match="'time_to_collision' cannot be predicted in a team"):
        play(team, task=task("time_to_collision"), team=True)
    play(team, task=task("time_to_collision"))
    play(team, task=task("goal", "has_arrived"), team=True)


def test_any_scenario_takes_the_option_and_another_task_keeps_it() -> None:
    for told, meant in (("0.3", 0.3), (0.2, 0.2), ("true", True), (True, True)):
        scenario = ig.load_scenario("cluttered_room", {"predict": told})
        for chosen in (None, "discrete_navigation", {"observations": ["velocity"]}):
            assert load_task(scenario, chosen).predict == meant
        assert scenario.parameters["predict"] == str(told)
    assert load_task(scenario, {"predict": False}).predict is False
    with pytest.raises(ScenarioError, match=r"predict.*must be a number or true or false, got 'often'"):
        load_task(ig.load_scenario("cluttered_room", {"predict": "often"}))


def test_a_policy_keeps_what_it_was_trained_with() -> None:
    scenario = ig.load_scenario("cluttered_room")
    plain, trained = load_task(scenario), load_task(scenario, {"predict": True})
    known = perception_from(perception_of(trained).to_plain())
    assert known.predict is True
    assert "predict" not in perception_of(plain).to_plain()
    assert perceived_task(scenario, plain, known).predict is True
    assert perceived_task(scenario, load_task(scenario, {"predict": 0.2}), known).predict == 0.2
    assert perceived_task(scenario, trained, perception_of(plain)).predict is True


def test_pending_actions_are_the_latest_ones_newest_first() -> None:
    episodes = play(
        {"vel_min": [-0.5, -1.5]}, task={"name": "blank", "observations": [{"name": "pending", "steps": 3}]}
    )
    still = [-1 / 3, 0.0]  # of -0.5 to 1 m/s, 0 lies a third below the middle
    assert seen(episodes) == pytest.approx([*still, *still, *still])
    for action in ((0.1, 0.2), (0.3, 0.4)):
        drive(episodes, *action)
    assert seen(episodes) == pytest.approx([0.3, 0.4, 0.1, 0.2, *still])
    for action in ((0.5, 0.6), (7.0, -0.8)):
        drive(episodes, *action)
    assert seen(episodes) == pytest.approx([1.0, -0.8, 0.5, 0.6, 0.3, 0.4])
    episodes.begin(np.zeros(1, np.int64), np.zeros(1, np.int64))
    assert seen(episodes) == pytest.approx([*still, *still, *still])
