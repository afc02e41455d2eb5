"""Shields: how far a robot goes until it stands, worked out by hand, and that it never touches what stands still."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.tasks import Episodes, Outcome, load_task

STEP, RADIUS, WALL = 0.1, 0.2, 3.0
TOLERANCE = 5e-4
CONDITIONS = ["", "latency:time=0.3", "drive_lag:tau=0.5"]


def episodes(scenario: Any, n_worlds: int = 1, **given: str) -> Episodes:
    """Return begun episodes behind a shield."""
    loaded = ig.load_scenario(
        scenario, {"shield": "stop_in_time", **{key: text for key, text in given.items() if text}}
    )
    task = load_task(loaded)
    found = Episodes(ig.compile(loaded, n_worlds, agents=task.agents), task)
    found.begin(np.arange(n_worlds), np.arange(n_worlds), "test")
    return found


def before_a_wall(**keys: Any) -> dict[str, Any]:
    """Return a robot at the origin that looks at a wall."""
    robot = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": RADIUS},
        "state": [0, 0, 0],
        "goal": [9, 0, 0],
        "vel_min": [-1, -1],
        "vel_max": [1, 1],
        "sensors": [{"name": "lidar2d", "number": 181, "angle_range": "2 * pi", "range_max": 6}],
        **keys,
    }
    wall = {"shape": {"name": "linestring", "vertices": [[WALL, -9], [WALL, 9]]}}
    return {"world": {"name": "wall", "step_time": STEP}, "robot": robot, "obstacle": wall}


def approach(
    played: Episodes, steps: int = 120, action: tuple[float, ...] = (1.0, 0.0)
) -> list[tuple[float, float, int]]:
    """Drive at full speed; return gap and speed before each step, and whether the shield acts in it."""
    state, found = played.simulation.state, []
    for _ in range(steps):
        gap, speed, acted = (
            WALL - RADIUS - state.pose[0, 0, 0],
            state.velocity[0, 0, 0],
            int(played.state.extra[0, 0, 0]),
        )
        played.step(np.array([[action]]))
        found.append((gap, speed, int(played.state.extra[0, 0, 0]) - acted))
    assert played.state.outcome[0, 0] != Outcome.COLLISION
    return found


def way_to_a_stop(condition: str, speed: float) -> float:
    """Return how far the robot goes after one more command of 1 m/s, at this speed [m]."""
    if condition == "latency:time=0.3":
        return 0.4  # three commands of 1 m/s under way, and the new one
    if condition == "drive_lag:tau=0.5":
        share = 1.0 - np.exp(-STEP / 0.5)
        return (speed + (1.0 - speed) * share) * STEP / share  # a geometric series
    if condition == "acce":
        first = min(speed + 0.1, 1.0)  # then 0.1 m/s less in each step
        return STEP * sum(first - 0.1 * k for k in range(round(first / 0.1) + 1))
    return 0.1


@pytest.mark.parametrize("condition", [*CONDITIONS, "acce"])
def test_it_acts_when_the_way_to_a_stop_is_longer_than_the_gap_and_not_before(condition: str) -> None:
    keys: dict[str, Any] = {"acce": [1.0, 1.0]} if condition == "acce" else {}
    found = approach(episodes(before_a_wall(**keys), disturbances="" if keys else condition))
    first = next(k for k, (_, _, acted) in enumerate(found) if acted)
    for gap, speed, _ in found[3:first]:  # before that, not all of the commands under way are of 1 m/s
        assert way_to_a_stop(condition, speed) <= gap - TOLERANCE
    assert way_to_a_stop(condition, found[first][1]) > found[first][0] - 2 * TOLERANCE
    assert 0.0 < found[-1][0] < 0.012  # it comes near


def test_a_slowed_command_is_the_fastest_of_128() -> None:
    played = episodes(before_a_wall())
    found = approach(played, 27)
    assert not any(acted for _, _, acted in found)
    played.step(np.array([[[1.0, 0.0]]]))
    # 0.1 m are left, less the tolerance: 127 / 128 of full speed.
    assert played.simulation.state.velocity[0, 0, 0] == pytest.approx(127 / 128)


def test_a_margin_is_kept_and_turning_on_the_spot_too() -> None:
    played = episodes(before_a_wall(), shield="stop_in_time:margin=0.3")
    gap = approach(played)[-1][0]
    assert 0.3 <= gap < 0.312
    heading = played.simulation.state.pose[0, 0, 2]
    played.step(np.array([[[1.0, 0.5]]]))
    assert played.simulation.state.pose[0, 0, 2] - heading == pytest.approx(0.5 * STEP)


def test_a_robot_that_starts_within_the_margin_may_drive_away() -> None:
    played = episodes(before_a_wall(state=[2.7, 0, 0]), shield="stop_in_time:margin=0.3")
    approach(played, 3)
    assert played.simulation.state.pose[0, 0, 0] == pytest.approx(2.7)
    approach(played, 3, (-1.0, 0.0))
    assert played.simulation.state.pose[0, 0, 0] == pytest.approx(2.4)


def test_nobody_drives_where_the_sensor_does_not_look() -> None:
    ahead = [{"name": "lidar2d", "number": 90, "angle_range": "pi"}]
    played = episodes(before_a_wall(sensors=ahead))
    approach(played, 3, (-1.0, 1.0))
    assert played.simulation.state.pose[0, 0].tolist() == pytest.approx([0.0, 0.0, 0.3])
    assert played.state.extra[0, 0, 0] == 3


@pytest.mark.parametrize("condition", CONDITIONS)
@pytest.mark.parametrize(
    "keys",
    [
        {"kinematics": {"name": "omni"}},
        {"kinematics": {"name": "omni_angular"}, "vel_min": [-1, -1, -1], "vel_max": [1, 1, 1]},
        {
            "kinematics": {"name": "acker"},
            "shape": {"name": "rectangle", "length": 1.0, "width": 0.4, "wheelbase": 0.6},
        },
        {"shape": {"name": "rectangle", "length": 0.8, "width": 0.4}},
    ],
)
def test_other_drives_and_shapes_stop_too(condition: str, keys: dict[str, Any]) -> None:
    wall = before_a_wall(**keys)
    n_components = len(wall["robot"]["vel_max"])
    played = episodes(wall, 8, disturbances=condition)
    rng = np.random.default_rng(0)
    for step in range(150):
        if step % 25 == 0:
            actions = rng.uniform(-0.3, 0.3, (8, 1, n_components))
            actions[:, :, 0] = 1.0
        played.step(actions)
    assert not (played.state.outcome == Outcome.COLLISION).any()
    assert played.state.min_clearance.min() < 0.05
    assert (played.state.extra > 0).any()


def collisions(name: str, n_levels: int, steps: int, condition: str, hold: int) -> int:
    """Return the collisions of robots that drive ahead and turn at random, with a new turn every ``hold`` steps."""
    played = episodes(name, n_levels, disturbances=condition)
    rng = np.random.default_rng(1)
    for step in range(steps):
        if step % hold == 0:
            actions = rng.uniform(-1.0, 1.0, (n_levels, 1, 2))
            actions[:, :, 0] = 1.0 if hold > 1 else actions[:, :, 0]
        played.step(actions)
    assert played.state.extra.sum() > n_levels
    return int((played.state.outcome == Outcome.COLLISION).sum())


@pytest.mark.parametrize("condition", CONDITIONS)
def test_nobody_touches_what_stands_still(condition: str) -> None:
    assert collisions("cluttered_room", 60, 120, condition, 20) == 0


@pytest.mark.slow
@pytest.mark.parametrize("hold", [1, 20])
@pytest.mark.parametrize("condition", CONDITIONS)
def test_nobody_touches_what_stands_still_in_1000_levels(condition: str, hold: int) -> None:
    assert collisions("cluttered_room", 1000, 300, condition, hold) == 0


def meeting_another(shield: str, lane: float) -> Episodes:
    """Return a robot behind a shield, and another one that drives towards it on a lane."""
    data = before_a_wall()
    other = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": RADIUS},
        "behavior": {"name": "dash"},
        "state": [2.5, lane, np.pi],
        "goal": [-9, lane, 0],
        "vel_max": [0.5, 1.5],
    }
    data["obstacle"] = [data["obstacle"], other]
    return episodes(data, shield=shield)


@pytest.mark.parametrize(("shield", "touches"), [("stop_in_time", True), ("velocity_obstacle", False)])
def test_only_velocity_obstacle_makes_way_for_others(shield: str, touches: bool) -> None:
    played = meeting_another(shield, 0.0)
    for _ in range(50):
        played.step(np.array([[[1.0, 0.0]]]))
    assert (played.state.outcome[0, 0] == Outcome.COLLISION) == touches
    assert played.state.extra[0, 0, 0] > 0


def test_velocity_obstacle_lets_commands_pass_that_meet_nobody() -> None:
    played = meeting_another("velocity_obstacle", 1.0)
    for _ in range(20):
        played.step(np.array([[[1.0, 0.0]]]))
    assert played.simulation.state.pose[0, 0].tolist() == pytest.approx([2.0, 0.0, 0.0])
    assert played.state.extra[0, 0, 0] == 0


def test_a_step_costs_1_where_the_robot_is_too_near() -> None:
    scenario = before_a_wall(state=[2.0, 0, 0])
    env = ig.make(scenario, task={"name": "navigation", "near": 0.35})
    env.reset(seed=0)
    costs = [env.step(np.array([1.0, 0.0], np.float32))[4]["cost"] for _ in range(8)]
    # Gaps after each step: 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1 m, contact.
    assert costs == [0, 0, 0, 0, 1, 1, 1, 1]


def test_batch_single_and_threads_are_shielded_alike() -> None:
    given = {"shield": "stop_in_time", "disturbances": "latency:time=[0, 0.3]; drive_lag:tau=0.2"}
    envs = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, **given)
    threads = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=5, num_threads=3, **given)
    single = gymnasium.make("irsim_gym/cluttered_room-v0", **given)
    seen, _ = envs.reset(seed=7)
    other, _ = threads.reset(seed=7)
    alone, _ = single.reset(seed=7 + 3)
    action, acted = np.array([1.0, 0.2], np.float32), 0
    for _ in range(60):
        np.testing.assert_array_equal(seen, other)
        np.testing.assert_array_equal(seen[3], alone)
        seen, _, _, _, infos = envs.step(np.tile(action, (5, 1)))
        other, *_ = threads.step(np.tile(action, (5, 1)))
        alone, _, ended, cut, info = single.step(action)
        assert info["shield"] == infos["shield"][3]
        acted = max(acted, info["shield"])
        if ended or cut:
            break
    assert acted > 0


def test_without_a_shield_no_info_tells_of_one() -> None:
    _, info = ig.make("cluttered_room").reset(seed=0)
    assert "shield" not in info
    _, info = ig.make("cluttered_room", task={"shield": "stop_in_time"}).reset(seed=0)
    assert info["shield"] == 0


@pytest.mark.parametrize(
    ("scenario", "shield", "said"),
    [
        ("cluttered_room", "stop_in_tim", "no shield named 'stop_in_tim' (did you mean 'stop_in_time'?)"),
        ("cluttered_room", "stop_in_time:margin=-1", "shield.margin: "),
        ("cluttered_room", "stop_in_time:margi=1", "did you mean 'margin'?"),
        ("cluttered_room", 3, "must be text such as 'stop_in_time:margin=0.05', got 3"),
        (before_a_wall(sensors=[]), "stop_in_time", "has a shield and no range sensor; add sensors: [{name: lidar2d}]"),
        (before_a_wall(vel_min=[0.1, -1]), "stop_in_time", "cannot stand: vel_min is [0.1, -1"),
    ],
)
def test_bad_values_are_named_with_what_would_be_right(scenario: Any, shield: Any, said: str) -> None:
    with pytest.raises(ScenarioError) as error:
        load_task(ig.load_scenario(scenario, {"shield": shield}))
    assert said in str(error.value)
