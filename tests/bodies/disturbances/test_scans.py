"""Disturbances of scans: what beams read, and how often."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

import irsim_gym as ig

FAR = 5.0
WALL = {"shape": {"name": "linestring", "vertices": [[3, -100], [3, 100]]}}


def scanning(*disturbances: dict[str, Any], n_worlds: int = 1, beams: int = 8, **sensor: Any) -> ig.Simulation:
    """Return worlds of a robot 3 m before a wall, with beams to all sides; beam 0 looks back."""
    lidar = {"name": "lidar2d", "number": beams + 1, "angle_range": 2 * np.pi, "range_max": FAR, **sensor}
    robot = {"kinematics": {"name": "diff"}, "sensors": [lidar], "disturbances": list(disturbances)}
    data = {"world": {"name": "d"}, "robot": robot, "obstacle": WALL}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=(0,))
    sim.reset(seed=0)
    return sim


def ranges(sim: ig.Simulation) -> np.ndarray:
    return sim.sensors[0].arrays["ranges"][:, 0].astype(float)


def test_bias_scales_and_shifts_what_beams_hit_and_nothing_else() -> None:
    plain = ranges(scanning())[0]
    assert plain[[0, 4, 5]] == pytest.approx([FAR, 3.0, 3.0 * np.sqrt(2.0)])
    biased = ranges(scanning({"name": "range_bias", "offset": 0.2, "scale": 0.1}))[0]
    assert biased[[0, 4, 5]] == pytest.approx([FAR, 3.5, 0.2 + 3.3 * np.sqrt(2.0)])


@pytest.mark.parametrize(("offset", "read"), [(-2.9, 0.5), (2.5, FAR)])
def test_biased_ranges_stay_within_those_of_the_sensor(offset: float, read: float) -> None:
    assert ranges(scanning({"name": "range_bias", "offset": offset}, range_min=0.5))[0, 4] == pytest.approx(read)


@pytest.mark.parametrize("chance", [0.0, 0.001, 0.3, 1.0])
@pytest.mark.parametrize(("reads", "reading"), [("none", FAR), ("zero", 0.25)])
def test_beams_are_lost_as_often_as_they_should(chance: float, reads: str, reading: float) -> None:
    lost = {"name": "lost_beams", "chance": chance, "reads": reads}
    sim = scanning(lost, n_worlds=500, beams=360, range_min=0.25)
    plain = ranges(scanning(beams=360, range_min=0.25))[0]
    hits = plain < FAR
    for _ in range(2):
        found = ranges(sim)[:, hits]
        assert np.all((found == reading) | (found == plain[hits]))
        error = np.sqrt(chance * (1 - chance) / found.size)
        assert (found == reading).mean() == pytest.approx(chance, abs=3 * error)
        sim.step([0.0, 0.0])


def test_lost_beams_are_independent_of_each_other_and_of_the_last_scan() -> None:
    sim = scanning({"name": "lost_beams", "chance": 0.5, "reads": "zero"}, n_worlds=4000, beams=360)
    hits = np.flatnonzero(ranges(scanning(beams=360))[0] < FAR)[:40]
    first = ranges(sim)[:, hits] == 0.0
    sim.step([0.0, 0.0])
    both = np.hstack([first, ranges(sim)[:, hits] == 0.0])
    correlation = np.corrcoef(both.T) - np.eye(both.shape[1])
    assert np.abs(correlation).max() < 5 / np.sqrt(4000)


def test_a_sector_of_a_drawn_direction_sees_nothing() -> None:
    n, width = 2000, 1.2
    sim = scanning({"name": "blind_sector", "width": width}, n_worlds=n, beams=360)
    plain = ranges(scanning(beams=360))[0]
    hits = plain < FAR
    blind = ranges(sim) == FAR
    assert np.all(blind[:, ~hits])
    share = width / (2 * np.pi)
    assert blind[:, hits].mean() == pytest.approx(share, abs=3 * np.sqrt(share * (1 - share) / n))
    for row in blind[:, hits]:
        # One sector: the beams that are blind follow each other.
        assert np.abs(np.diff(row.astype(int))).sum() <= 2
    sim.step([0.0, 0.0])
    np.testing.assert_array_equal(ranges(sim) == FAR, blind)


def test_scans_between_two_of_the_sensor_show_the_last_one() -> None:
    sim = scanning({"name": "scan_rate", "every": 0.25})
    seen = [float(ranges(sim)[0, 4])]
    for _ in range(7):
        sim.step([1.0, 0.0])
        seen.append(float(ranges(sim)[0, 4]))
    # Every third step: 0.25 s are rounded up.
    assert seen == pytest.approx([3.0, 3.0, 3.0, 2.7, 2.7, 2.7, 2.4, 2.4])


def test_each_range_sensor_of_a_robot_is_disturbed() -> None:
    lidar = {"name": "lidar2d", "number": 9, "angle_range": 2 * np.pi, "range_max": FAR}
    robot = {"kinematics": {"name": "diff"}, "sensors": [lidar, lidar, {**lidar, "name": "fmcw_lidar2d"}]}
    data = {"robot": {**robot, "disturbances": [{"name": "range_bias", "offset": 0.1}]}, "obstacle": WALL}
    sim = ig.compile(ig.load_scenario(data), 1)
    sim.reset(seed=0)
    for group in sim.sensors:
        assert group.arrays["ranges"][0, :, 4] == pytest.approx(3.1)


def test_what_observations_read_stays_within_their_bounds() -> None:
    given = [
        {"name": "range_bias", "offset": [-1, 1], "scale": [-0.5, 1]},
        {"name": "lost_beams", "chance": 0.5, "reads": "zero"},
        {"name": "blind_sector", "width": [0, 3]},
        {"name": "odometry", "scale": [-1, 1], "yaw": [-1, 1]},
    ]
    text = "; ".join(f"{one['name']}" + "".join(f":{k}={v}" for k, v in one.items() if k != "name") for one in given)
    envs = gymnasium.make_vec("irsim_gym/cluttered_room-v0", num_envs=8, disturbances=text)
    envs.action_space.seed(0)
    seen, _ = envs.reset(seed=0)
    for _ in range(60):
        assert envs.observation_space.contains(seen)
        seen, *_ = envs.step(envs.action_space.sample())


@pytest.mark.parametrize("turn", [0.0, np.pi / 2])
def test_a_sensor_that_stands_elsewhere_sees_what_it_would_see_from_there(turn: float) -> None:
    told, true = (0.3, -0.1, 0.5), (0.3 + 0.2, -0.1 + 0.4, 0.5 + 0.25)
    disturbed = {"name": "mount", "x": 0.2, "y": 0.4, "turn": 0.25}
    found = []
    for offset, disturbances in ((told, [disturbed]), (true, [])):
        lidar = {"name": "lidar2d", "number": 30, "angle_range": 2 * np.pi, "range_max": 50.0, "offset": list(offset)}
        entry = {"kinematics": {"name": "diff"}, "state": [1.0, 2.0, turn], "sensors": [lidar]}
        disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [1.0, 5.0, 0]}
        data = {"robot": {**entry, "disturbances": disturbances}, "obstacle": [WALL, disc]}
        sim = ig.compile(ig.load_scenario(data), 1, agents=(0,))
        sim.reset(seed=0)
        sim.step([0.5, 0.3])
        assert sim.state.pose[0, 0, 2] == pytest.approx(turn + 0.03)
        found.append(ranges(sim)[0])
    np.testing.assert_allclose(*found, atol=1e-5)


@pytest.mark.parametrize(("within", "seen"), [(0.3, [4]), (0.8, [3, 4, 5])])
def test_glass_is_seen_where_beams_meet_it_nearly_at_right_angles(within: float, seen: list[int]) -> None:
    found = ranges(scanning({"name": "glass", "share": 1.0, "seen_within": within}))[0]
    np.testing.assert_array_equal(np.flatnonzero(found < FAR), seen)
    assert found[4] == pytest.approx(3.0)


def test_a_disc_of_glass_is_seen_in_its_middle_by_noisy_scanners_too() -> None:
    lidar = {"name": "lidar2d", "number": 401, "angle_range": 0.4, "range_max": FAR}
    disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [3, 0, 0]}
    for noise in ({}, {"noise": True, "std": 0.01, "angle_std": 0.0}):
        glass = [{"name": "glass", "share": 1.0, "seen_within": 0.5}, {"name": "mount", "turn": 0.05}]
        robot = {"kinematics": {"name": "diff"}, "sensors": [{**lidar, **noise}], "disturbances": glass}
        sim = ig.compile(ig.load_scenario({"robot": robot, "obstacle": disc}), 1, agents=(0,))
        sim.reset(seed=0)
        directions = np.linspace(-0.2, 0.2, 401) + 0.05
        # The law of sines in the triangle of sensor, centre and hit.
        expected = np.abs(3.0 * np.sin(directions)) < 0.5 * np.sin(0.5)
        assert np.sum((ranges(sim)[0] < FAR) != expected) <= (12 if noise else 2)


def test_a_share_of_the_bodies_is_of_glass_for_a_level_and_robots_agree() -> None:
    n, share = 1000, 0.3
    lidar = {"name": "lidar2d", "number": 2, "angle_range": 0.02, "range_max": FAR}
    glass = [{"name": "glass", "share": share, "seen_within": 0.0}]
    robots = [
        {"kinematics": {"name": "diff"}, "state": [0, y, 0], "sensors": [lidar], "disturbances": glass} for y in (0, 5)
    ]
    sim = ig.compile(ig.load_scenario({"robot": robots, "obstacle": WALL}), n, agents=(0, 1))
    sim.reset(seed=0)
    seen = np.concatenate([group.arrays["ranges"][:, :, 0] for group in sim.sensors], axis=1)
    is_glass = seen == FAR
    assert is_glass[:, 0].mean() == pytest.approx(share, abs=3 * np.sqrt(share * (1 - share) / n))
    np.testing.assert_array_equal(is_glass[:, 0], is_glass[:, 1])
    sim.step([0.0, 0.0])
    np.testing.assert_array_equal(seen[:, 0], sim.sensors[0].arrays["ranges"][:, 0, 0])
