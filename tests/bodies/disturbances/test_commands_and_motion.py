"""Disturbances of commands and motion, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

STEP = 0.1
DISC = {"kinematics": {"name": "diff"}, "state": [0, 0, 0], "goal": [100, 0], "vel_min": [-1, -2], "vel_max": [1, 2]}


def driven(*disturbances: dict[str, Any], n_worlds: int = 1, **keys: Any) -> ig.Simulation:
    """Return worlds of a robot without anything around it."""
    robot = {**DISC, **keys, "disturbances": list(disturbances)}
    sim = ig.compile(ig.load_scenario({"world": {"name": "d"}, "robot": robot}), n_worlds, agents=(0,))
    sim.reset(seed=0)
    return sim


def speeds(sim: ig.Simulation, commands: list[float]) -> list[float]:
    """Return the speed after each command straight ahead, of world 0."""
    found = []
    for speed in commands:
        sim.step([speed, 0.0])
        found.append(float(sim.state.velocity[0, 0, 0]))
    return found


def test_with_a_latency_of_two_steps_the_first_command_acts_in_the_third_step() -> None:
    sim = driven({"name": "latency", "time": 0.2})
    assert speeds(sim, [0.1, 0.2, 0.3, 0.4, 0.5]) == [0.0, 0.0, 0.1, 0.2, 0.3]


@pytest.mark.parametrize(("time", "steps"), [(0.0, 0), (0.1, 1), (0.11, 2), (0.3, 3)])
def test_times_are_rounded_up_to_steps(time: float, steps: int) -> None:
    found = speeds(driven({"name": "latency", "time": time}), [0.1, 0.2, 0.3, 0.4, 0.5])
    assert found == [*[0.0] * steps, 0.1, 0.2, 0.3, 0.4, 0.5][:5]


def test_latencies_add_up_and_a_new_level_begins_with_an_empty_queue() -> None:
    sim = driven({"name": "latency", "time": 0.1}, {"name": "latency", "time": 0.1})
    assert speeds(sim, [0.1, 0.2, 0.3, 0.4]) == [0.0, 0.0, 0.1, 0.2]
    sim.reset(seed=1)
    assert speeds(sim, [0.5, 0.6, 0.7]) == [0.0, 0.0, 0.5]


def test_a_drive_with_a_lag_of_0_3_s_has_63_percent_of_the_speed_after_0_3_s() -> None:
    found = speeds(driven({"name": "drive_lag", "tau": 0.3}), [1.0] * 9)
    assert found == pytest.approx([1.0 - np.exp(-STEP * k / 0.3) for k in range(1, 10)], abs=1e-12)
    assert found[2] == pytest.approx(0.632, abs=1e-3)
    assert found[8] == pytest.approx(0.950, abs=1e-3)


def test_limits_of_acceleration_apply_after_the_lag() -> None:
    found = speeds(driven({"name": "drive_lag", "tau": 0.3}, acce=[1.0, 1.0]), [1.0] * 3)
    assert found[0] == pytest.approx(0.1)
    assert found[1] == pytest.approx(0.2)


def test_commands_below_the_dead_band_do_not_move_the_wheels() -> None:
    assert speeds(driven({"name": "drive_lag", "dead_band": 0.05}), [0.04, 0.05, -0.04, -0.06]) == [0, 0.05, 0, -0.06]


def test_a_lag_follows_what_the_latency_lets_through() -> None:
    found = speeds(driven({"name": "drive_lag", "tau": 0.1}, {"name": "latency", "time": 0.1}), [1.0, 1.0])
    assert found == pytest.approx([0.0, 1.0 - np.exp(-1.0)])


def test_lost_commands_leave_the_last_one_in_force() -> None:
    n, chance = 2000, 0.3
    sim = driven({"name": "lost_commands", "chance": chance}, n_worlds=n)
    before = np.zeros(n)
    for k in range(1, 6):
        sim.step([0.1 * k, 0.0])
        now = sim.state.velocity[:, 0, 0].copy()
        is_lost = now == before
        assert np.all(is_lost | (now == 0.1 * k))
        assert is_lost.mean() == pytest.approx(chance, abs=3 * np.sqrt(chance * (1 - chance) / n))
        before = now


def test_slip_moves_the_robot_less_than_its_wheels_and_it_believes_its_wheels() -> None:
    sim = driven({"name": "slip", "ahead": 0.1, "turn": 0.5})
    sim.step([1.0, 1.0])
    sim.step([1.0, 0.0])
    assert sim.state.velocity[0, 0].tolist() == [1.0, 0.0, 0.0]
    # The first step is straight ahead, the second along the heading after the first.
    assert sim.state.pose[0, 0] == pytest.approx([0.09 + 0.09 * np.cos(0.05), 0.09 * np.sin(0.05), 0.05])
    assert sim.told.pose[0, 0] == pytest.approx([0.1 + 0.1 * np.cos(0.1), 0.1 * np.sin(0.1), 0.1])
    assert sim.state.twist[0, 0, 0] == pytest.approx(0.9 * np.cos(0.05))


def test_odometry_is_too_long_and_turns_with_the_way() -> None:
    sim = driven({"name": "odometry", "scale": 0.02, "yaw": 0.3})
    sim.step([1.0, 0.0])
    assert sim.state.pose[0, 0].tolist() == [0.1, 0.0, 0.0]
    assert sim.told.pose[0, 0] == pytest.approx([0.102, 0.0, 0.03])
    sim.step([-1.0, 0.0])
    assert sim.state.pose[0, 0] == pytest.approx([0.0, 0.0, 0.0])
    assert sim.told.pose[0, 0] == pytest.approx([0.102 - 0.102 * np.cos(0.03), -0.102 * np.sin(0.03), 0.06])


def test_a_fix_gives_the_true_pose_with_a_deviation_at_its_times_alone() -> None:
    n = 4000
    fix = {"every": 0.3, "std": 0.05, "angle_std": 0.02}
    sim = driven({"name": "odometry", "scale": 1.0, "fix": fix}, n_worlds=n)
    for _ in range(2):
        sim.step([1.0, 0.0])
    np.testing.assert_allclose(sim.told.pose[:, 0, 0], 0.4)
    sim.step([1.0, 0.0])
    error = sim.told.pose[:, 0] - sim.state.pose[:, 0]
    for axis, std in enumerate((0.05, 0.05, 0.02)):
        assert error[:, axis].mean() == pytest.approx(0.0, abs=3 * std / np.sqrt(n))
        assert error[:, axis].std() == pytest.approx(std, rel=3 / np.sqrt(2 * n))


def test_motion_noise_is_no_error_of_what_odometry_counts() -> None:
    sim = driven({"name": "odometry"}, kinematics={"name": "diff", "noise": True})
    sim.step([1.0, 0.0])
    assert sim.told.pose[0, 0] == pytest.approx([0.1, 0.0, 0.0])
    assert sim.state.pose[0, 0, 0] != 0.1


def test_who_is_put_elsewhere_knows_its_place_and_others_are_where_they_are() -> None:
    slip = {"name": "slip", "ahead": 0.5}
    data = {
        "robot": [
            {"kinematics": {"name": "diff"}, "goal": [9, 0], "disturbances": [slip]},
            {"kinematics": {"name": "diff"}, "goal": [9, 5], "state": [5, 5, 0]},
        ]
    }
    sim = ig.compile(ig.load_scenario(data), 1, agents=(0, 1))
    sim.reset(seed=0)
    sim.step([1.0, 0.0])
    assert sim.told.pose[0, :, 0] == pytest.approx([0.1, 5.1])
    assert sim.told.goal_distance[0] == pytest.approx([8.9, 3.9])
    assert sim.state.goal_distance[0] == pytest.approx([8.95, 3.9])
    sim.state.pose[0, :, 0] = [2.0, 9.0]
    sim.place(np.array([0]))
    assert sim.told.pose[0, 0, 0] == 2.0
    sim.state.pose[0, 0, 0] = 3.0
    sim.refresh()
    assert sim.told.pose[0, :, 0].tolist() == [3.0, 9.0]
    assert sim.state.arrived[0].tolist() == [False, True]


def test_a_pair_is_drawn_for_each_level_and_a_number_for_none() -> None:
    n = 3000
    sim = driven({"name": "slip", "ahead": [0.1, 0.3], "turn": 0.2}, n_worlds=n)
    drawn = sim.parts.disturbances.groups[0].tables.values[:, 0]
    assert np.all(drawn[:, 1] == 0.2)
    assert drawn[:, 0].min() >= 0.1
    assert drawn[:, 0].max() < 0.3
    assert drawn[:, 0].mean() == pytest.approx(0.2, abs=3 * 0.2 / np.sqrt(12 * n))
    again = drawn.copy()
    sim.reset_to_start()
    np.testing.assert_array_equal(drawn, again)
    sim.reset(seed=5)
    np.testing.assert_array_equal(drawn[:-5], again[5:])


def test_disturbances_do_not_touch_the_stream_of_the_level() -> None:
    plain, disturbed = driven(), driven({"name": "latency", "time": [0, 0.3]}, {"name": "slip", "ahead": [0, 0.1]})
    for sim in (plain, disturbed):
        sim.step([1.0, 0.0])
    assert plain.state.random[0] == disturbed.state.random[0]


def test_they_act_in_one_order_whatever_the_file_says() -> None:
    found = []
    for order in (1, -1):
        given = [
            {"name": "lost_commands", "chance": 0.4},
            {"name": "latency", "time": 0.2},
            {"name": "drive_lag", "tau": 0.2},
        ]
        found.append(speeds(driven(*given[::order]), [0.1 * k for k in range(10)]))
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("disturbance", "said"),
    [
        ({"name": "latency", "time": -0.1}, "disturbances[0].time: must lie from 0 to 10, got -0.1"),
        ({"name": "latency", "time": [0.3, 0.1]}, "must be [low, high] with low <= high, got [0.3, 0.1]"),
        ({"name": "latency", "time": "soon"}, "must be a number or a list of 2 numbers, got 'soon'"),
        ({"name": "latncy"}, "no disturbance named 'latncy' (did you mean 'latency'?)"),
        ({"name": "lost_beams", "chance": 2}, "must lie from 0 to 1, got 2"),
        ({"name": "lost_beams", "reads": "one"}, "must be 'none' or 'zero', got 'one'"),
        ({"name": "odometry", "fix": {"every": 0}}, "fix.every: must be > 0, got 0"),
        ({"name": "range_bias"}, "'range_bias' changes scans, but the robot has no range sensor"),
    ],
)
def test_bad_values_are_named_with_what_would_be_right(disturbance: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError) as error:
        driven(disturbance)
    assert said in str(error.value)


def test_only_robots_that_move_have_disturbances(tmp_path: Any) -> None:
    file = tmp_path / "world.yaml"
    file.write_text("robot:\n  - kinematics: {name: diff}\nobstacle:\n  - disturbances: [{name: latency, time: 1}]\n")
    with pytest.raises(ScenarioError, match=r"(?s)world.yaml.*4.*only robots have disturbances"):
        ig.load_scenario(file)
    with pytest.raises(ScenarioError, match="'slip' changes how the robot drives, but it cannot move; add kinematics"):
        driven({"name": "slip"}, kinematics=None)
