"""Scan dictionaries, points and velocities in scenes worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.envs.described.moment import BodyMoment
from irsim_gym.errors import ScenarioError, UnknownNameError

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}


def simulation(sensors: list[dict[str, Any]], obstacles: list[dict[str, Any]], n_worlds: int = 1, **robot: Any) -> Any:
    data = {"robot": {**DIFF, "state": [2, 5, 0], "sensors": sensors, **robot}, "obstacle": obstacles}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=[0])
    sim.reset()
    return sim


def square(x: float, y: float, **more: Any) -> dict[str, Any]:
    return {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [x, y, 0], **more}


def test_a_report_has_ir_sims_keys() -> None:
    sensor = {"number": 3, "angle_range": 1.0, "range_min": 0.5, "range_max": 4.1, "scan_time": 0.2}
    report = BodyMoment(simulation([sensor], [square(5, 5)]), 0).scan()
    angles = ["angle_min", "angle_max", "angle_increment"]
    band = ["time_increment", "scan_time", "range_min", "range_max"]
    assert list(report) == [*angles, *band, "ranges", "intensities", "velocity", "valid"]
    numbers = [value for value in report.values() if isinstance(value, float)]
    assert numbers == pytest.approx([-0.5, 0.5, 0.5, 0.0, 0.2, 0.5, 4.1])
    assert report["intensities"] is None
    assert report["ranges"].tolist() == [4.1, pytest.approx(2.5), 4.1]
    assert report["valid"].tolist() == [False, True, False]
    assert not report["velocity"].any()
    assert report["velocity"].shape == (2, 3)


def test_radial_velocities_of_what_is_not_seen_any_more_are_zero() -> None:
    sensor = {"name": "fmcw_lidar2d", "number": 3, "angle_range": 0.2, "range_max": 4}
    mover = square(4, 5, kinematics={"name": "omni"}, velocity=[0.5, 0])
    sim = simulation([sensor], [mover])
    radial = sim.sensors[0].arrays["radial_velocity"]
    assert radial[0, 0] == pytest.approx([0.5 * np.cos(0.1), 0.5, 0.5 * np.cos(0.1)], abs=1e-6)
    sim.state.pose[0, 1] = [9, 9, 0]
    sim.place(np.array([1]))
    sim.refresh()
    assert radial[0, 0].tolist() == [0.0, 0.0, 0.0]


def test_a_sensor_without_noise_draws_nothing() -> None:
    sensors = [{"name": "fmcw_lidar2d", "number": 5}, {"number": 5}]
    sim = simulation(sensors, [square(5, 5)])
    stream = sim.state.random.copy()
    sim.step(np.zeros((1, 1, 2)))
    np.testing.assert_array_equal(sim.state.random, stream)


def test_a_colour_has_a_name() -> None:
    with pytest.raises(ScenarioError, match="no_hit_color"):
        simulation([{"name": "fmcw_lidar2d", "no_hit_color": ""}], [])


def test_a_single_beam_has_no_increment() -> None:
    report = BodyMoment(simulation([{"number": 1}], []), 0).scan()
    assert (report["angle_min"], report["angle_max"], report["angle_increment"]) == (0.0, 0.0, 0.0)


def test_what_is_too_near_blocks_and_is_not_valid() -> None:
    sim = simulation([{"number": 1, "range_min": 3.3}], [square(5, 5)])
    report = BodyMoment(sim, 0, 0).scan()
    assert (report["ranges"].tolist(), report["valid"].tolist()) == ([3.3], [False])
    assert BodyMoment(sim, 0, 0).scan_points() is None


def test_points_are_in_the_frame_of_the_sensor() -> None:
    # The sensor looks to the left from 0.5 m ahead of the body: it is at (2.5, 5), the square begins 1.5 m off.
    sensor = {"number": 3, "angle_range": "pi", "offset": [0.5, 0, "pi / 2"], "range_max": 5}
    points = BodyMoment(simulation([sensor], [square(2.5, 7)]), 0).scan_points()
    assert points == pytest.approx(np.array([[1.5], [0.0]]), abs=1e-6)


def test_points_near_the_end_of_the_range_are_left_out() -> None:
    sim = simulation([{"number": 1, "range_max": 2.51}], [square(5, 5)])
    assert BodyMoment(sim, 0, 0).scan()["valid"].tolist() == [True]
    assert BodyMoment(sim, 0, 0).scan_points() is None


def test_reports_are_copies() -> None:
    sensors = [{"number": 3, "has_velocity": True}, {"name": "fmcw_lidar2d", "number": 3}]
    sim = simulation(sensors, [square(5, 5)])
    for index in range(2):
        group, member = sim.scan(0, index) or pytest.fail("no sensor")
        for value in group.kind.report(group, member, 0).values():
            if isinstance(value, np.ndarray):
                value[:] = 7
        assert BodyMoment(sim, 0).scan(index)["ranges"][1] == pytest.approx(2.5)


def test_sensors_are_counted_in_the_order_of_the_file() -> None:
    # Robots share a group of sensors, whatever the place of a sensor in each robot's list.
    near, far = {"number": 3, "range_max": 1}, {"number": 5, "range_max": 9}
    robots = [{**DIFF, "state": [2, 2 * y, 0], "sensors": order} for y, order in ((1, [near, far]), (3, [far, near]))]
    sim = ig.compile(ig.load_scenario({"robot": robots}))
    sim.reset()
    assert [[BodyMoment(sim, b, 0).scan(i)["range_max"] for i in range(2)] for b in range(2)] == [[1, 9], [9, 1]]
    assert len(BodyMoment(sim, 1, 0).scan()["ranges"]) == 5


def test_sensors_that_do_not_exist_are_told() -> None:
    sim = simulation([{"number": 3}], [square(5, 5)])
    for body, index, name in ((0, 1, "robot_0"), (0, -1, "robot_0"), (1, 0, "obstacle_1")):
        with pytest.raises(UnknownNameError, match=f"'{name}' has no range sensor number {index}"):
            BodyMoment(sim, body, 0).scan(index)
        with pytest.raises(UnknownNameError, match=f"'{name}' has no range sensor number {index}"):
            BodyMoment(sim, body, 0).scan_points(index)


def test_velocities_of_what_is_hit() -> None:
    # A square drives north at 0.5 m/s ahead of the robot; a wall on its left stands, and behind it is nothing.
    moving = {"kinematics": {"name": "omni"}, "velocity": [0, 0.5], "goal": [5, 9], "behavior": {"name": "dash"}}
    obstacles = [square(5, 5, vel_max=[0.5, 0.5], **moving), square(2, 7)]
    beams = {"number": 5, "angle_range": "2 * pi"}
    sensors = [
        {**beams, "has_velocity": True},
        {"name": "fmcw_lidar2d", **beams},
        {"name": "fmcw_lidar2d", **beams, "motion_compensate": True, "offset": [0, 0, 0.1]},
    ]
    sim = simulation(sensors, obstacles, n_worlds=2)
    sim.step([0.4, 0])
    velocity = BodyMoment(sim, 0, 1).scan(0)["velocity"]
    assert velocity == pytest.approx(np.array([[0, 0, 0, 0, 0], [0, 0, 0.5, 0, 0]]))
    # The robot drives at 0.4 m/s towards the square, past the wall: positive values go away.
    radial = BodyMoment(sim, 0, 1).scan(1)["radial_velocity"]
    assert radial == pytest.approx([0, 0, -0.4, 0, 0], abs=1e-12)
    compensated = BodyMoment(sim, 0, 1).scan(2)["radial_velocity"]
    assert compensated == pytest.approx([0, 0, 0.5 * np.sin(0.1), 0, 0], abs=1e-12)


def test_radial_velocities_of_invalid_beams_are_zero() -> None:
    sim = simulation([{"name": "fmcw_lidar2d", "number": 1, "range_min": 3}], [square(5, 5)])
    sim.step([0.4, 0])
    report = BodyMoment(sim, 0, 0).scan()
    assert (report["valid"].tolist(), report["radial_velocity"].tolist()) == ([False], [0.0])


@pytest.mark.parametrize("noise", [{}, {"noise": True, "std": 0.0, "angle_std": 0.0}])
@pytest.mark.parametrize(("wall", "name"), [(2.55, "map"), (2.85, "obstacle_1"), (3.6, "obstacle_1")])
def test_what_is_hit_below_range_min_is_the_nearest(noise: dict[str, Any], wall: float, name: str) -> None:
    # A disc stands 0.7 m ahead, nearer than range_min; a wall of the map stands before or behind it.
    cells = np.zeros((200, 200), np.bool_)
    cells[int(wall * 20)] = True
    sensor = {"number": 1, "range_min": 1.0, "has_velocity": True, **noise}
    disc = {"shape": {"name": "circle", "radius": 0.1}, "kinematics": {"name": "omni"}, "state": [2.8, 5, 0]}
    data = {
        "world": {"obstacle_map": cells.tolist(), "collision_mode": "unobstructed"},
        "robot": {**DIFF, "state": [2, 5, 0], "sensors": [sensor]},
        "obstacle": {**disc, "velocity": [0.5, 0]},
    }
    sim = ig.compile(ig.load_scenario(data))
    sim.reset()
    group, member = sim.scan(0)
    hit = group.arrays["hit"][0, member, 0]
    assert hit == (1 if name == "obstacle_1" else sim.model.map_frame[0].body)
    report = BodyMoment(sim, 0, 0).scan()
    assert (report["ranges"].tolist(), report["valid"].tolist()) == ([1.0], [False])
