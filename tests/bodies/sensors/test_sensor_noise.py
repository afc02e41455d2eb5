"""Noise of range sensors: its distribution at fixed seeds, and that it belongs to each world alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import irsim_gym as ig
from irsim_gym.envs.described.moment import BodyMoment

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}
WALL = {"shape": {"name": "linestring", "vertices": [[8, 0], [8, 10]]}}
STD, JITTER = 0.1, 0.05


def simulation(n_worlds: int, *sensors: dict[str, Any], threads: int = 1, steps: int = 0) -> ig.Simulation:
    robot = {**DIFF, "state": [5, 5, 0], "sensors": [{"range_max": 6, "noise": True, **one} for one in sensors]}
    data = {"world": {"name": "noise"}, "robot": robot, "obstacle": WALL}
    sim = ig.compile(ig.load_scenario(data), n_worlds, num_threads=threads)
    sim.reset(seed=7)
    for _ in range(steps):
        sim.step()
    return sim


def errors(n_worlds: int, n_beams: int, steps: int, **options: Any) -> np.ndarray:
    """Return what is added to the ranges to a wall 3 m ahead, shape ``(steps, n_worlds, n_beams)``."""
    sensor = {"number": n_beams, "angle_range": 1.0, "std": STD, "angle_std": 0, **options}
    sim = simulation(n_worlds, sensor)
    group, _ = sim.scan(0) or pytest.fail("no sensor")
    found = []
    for _ in range(steps):
        sim.step()
        found.append(group.arrays["ranges"][:, 0] - 3.0 / np.cos(group.arrays["cast_angles"]).reshape(-1, n_beams))
    return np.array(found)


def test_range_noise_is_normal_and_independent() -> None:
    found = errors(40, 25, 40)
    n = found.size
    # Four standard errors; kurtosis and skewness of normal samples vary by sqrt(24 / n) and sqrt(6 / n).
    assert abs(found.mean()) < 4 * STD / np.sqrt(n)
    assert abs(found.var() / STD**2 - 1) < 4 * np.sqrt(2 / n)
    scaled = found / STD
    assert abs((scaled**3).mean()) < 4 * np.sqrt(15 / n)
    assert abs((scaled**4).mean() - 3) < 4 * np.sqrt(96 / n)
    for axis in range(3):
        first, second = np.moveaxis(found, axis, 0)[:-1].ravel(), np.moveaxis(found, axis, 0)[1:].ravel()
        assert abs(np.corrcoef(first, second)[0, 1]) < 4 / np.sqrt(len(first))


def test_only_beams_that_hit_are_blurred_and_all_stay_in_the_band() -> None:
    sim = simulation(30, {"number": 9, "angle_range": "2 * pi", "std": 0.5, "angle_std": 0, "range_min": 2.8})
    group, _ = sim.scan(0) or pytest.fail("no sensor")
    ranges = group.arrays["ranges"][:, 0]
    assert (ranges[:, [0, 1, 2, 6, 7, 8]] == 6.0).all()
    ahead = ranges[:, 4]
    cut = ahead == np.float32(2.8)
    # The wall is 0.4 standard deviations beyond range_min: 34 % of the readings fall below it.
    assert 3 <= cut.sum() <= 18
    assert ((ahead > 2.8) | cut).all()
    for w in range(30):
        report = BodyMoment(sim, 0, w).scan()
        assert report["valid"][4] == (not cut[w])
        assert not report["valid"][0]
        assert cut[w] == (report["ranges"][4] == 2.8)


def test_what_noise_pushes_out_of_the_band_is_free_and_not_valid() -> None:
    sim = simulation(60, {"number": 1, "std": 2.0, "angle_std": 0, "range_max": 3.5})
    reports = [BodyMoment(sim, 0, w).scan() for w in range(60)]
    beyond = [bool(report["ranges"][0] == 3.5) for report in reports]
    near = [bool(report["ranges"][0] == 0.0) for report in reports]
    assert 12 <= sum(beyond) <= 36  # 40 % of the readings
    assert 0 < sum(near) <= 12  # 7 %
    assert [bool(report["valid"][0]) for report in reports] == [
        not (far or at_zero) for far, at_zero in zip(beyond, near, strict=True)
    ]
    assert [BodyMoment(sim, 0, w).scan_points() is None for w in range(60)] == [
        not report["valid"][0] or report["ranges"][0] >= 3.48 for report in reports
    ]


def test_noise_comes_before_the_lower_bound() -> None:
    # The wall is 3 m away, range_min 4 m: a beam reads more than 4 m only if its error exceeds 1 m, here one in six.
    sim = simulation(300, {"number": 1, "std": 1.0, "angle_std": 0, "range_min": 4})
    group, _ = sim.scan(0) or pytest.fail("no sensor")
    assert 0.10 < (group.arrays["ranges"] > 4).mean() < 0.22


def test_directions_are_cast_aside_but_reported_as_they_were() -> None:
    sensor = {"number": 31, "angle_range": 1.2, "std": 0, "angle_std": JITTER}
    sim = simulation(50, sensor)
    group, _ = sim.scan(0) or pytest.fail("no sensor")
    table = group.arrays
    turned = (table["cast_angles"] - table["angles"]).reshape(50, 31)
    assert np.abs(table["ranges"][:, 0] - 3.0 / np.cos(table["cast_angles"])).max() < 1e-5
    assert abs(turned.mean()) < 4 * JITTER / np.sqrt(turned.size)
    assert abs(turned.var() / JITTER**2 - 1) < 4 * np.sqrt(2 / turned.size)
    report = BodyMoment(sim, 0, 3).scan()
    assert (report["angle_min"], report["angle_max"]) == (pytest.approx(-0.6), pytest.approx(0.6))
    assert report["angle_increment"] == pytest.approx(0.04)
    points = BodyMoment(sim, 0, 3).scan_points()
    assert points is not None
    assert np.arctan2(points[1], points[0]) == pytest.approx(np.linspace(-0.6, 0.6, 31))
    sim.step()
    assert not np.array_equal(turned, (table["cast_angles"] - table["angles"]).reshape(50, 31))


def test_directions_vary_by_the_documented_default() -> None:
    sim = simulation(50, {"number": 31, "std": 0})
    group, _ = sim.scan(0) or pytest.fail("no sensor")
    turned = group.arrays["cast_angles"] - group.arrays["angles"]
    assert turned.std() == pytest.approx(0.02, rel=4 / np.sqrt(2 * turned.size))


def test_radial_velocities_have_a_noise_of_their_own() -> None:
    sensor = {"name": "fmcw_lidar2d", "noise": False, "number": 21, "angle_range": 1.0, "velocity_noise_std": 0.3}
    sim = simulation(60, sensor)
    velocity = sim.sensors[0].arrays["radial_velocity"]
    assert abs(velocity.mean()) < 4 * 0.3 / np.sqrt(velocity.size)
    assert velocity.std() == pytest.approx(0.3, rel=4 / np.sqrt(2 * velocity.size))
    behind = simulation(3, {**sensor, "offset": [0, 0, 3.14159]}).sensors[0].arrays
    assert (behind["radial_velocity"] == 0.0).all()


NOISY = (
    {"number": 20, "angle_range": 2.0},
    {"name": "fmcw_lidar2d", "number": 12, "velocity_noise_std": 0.1},
    {"number": 20, "angle_range": 2.0, "offset": [0, 0, 1], "has_velocity": True},
)


def readings(sim: ig.Simulation, w: int) -> list[np.ndarray]:
    names = ("ranges", "radial_velocity", "velocity")
    return [group.arrays[name][w] for group in sim.sensors for name in names if name in group.arrays]


def test_a_world_draws_the_same_alone_in_a_batch_and_sharded() -> None:
    batch, sharded = simulation(5, *NOISY, steps=3), simulation(5, *NOISY, threads=3, steps=3)
    alone = ig.compile(batch.scenario, 1)
    alone.reset(seed=7 + 2)
    for _ in range(3):
        alone.step()
    for single, one, other in zip(readings(alone, 0), readings(batch, 2), readings(sharded, 2), strict=True):
        np.testing.assert_array_equal(single, one)
        np.testing.assert_array_equal(single, other)
    assert not np.array_equal(readings(batch, 2)[0], readings(batch, 3)[0])


SCRIPT = """
import sys, numpy as np
sys.path.insert(0, sys.argv[2])
from test_sensor_noise import NOISY, readings, simulation
sim = simulation(2, *NOISY, steps=3)
np.savez(sys.argv[1], *readings(sim, 1))
"""


def test_compiled_and_plain_python_agree(tmp_path: Path) -> None:
    target = tmp_path / "plain.npz"
    command = [sys.executable, "-c", SCRIPT, str(target), str(Path(__file__).parent)]
    subprocess.run(command, check=True, env={**os.environ, "NUMBA_DISABLE_JIT": "1"})
    with np.load(target) as stored:
        expected = [stored[name] for name in stored.files]
    for compiled, plain in zip(readings(simulation(2, *NOISY, steps=3), 1), expected, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-5)


def test_an_environment_with_a_noisy_lidar_is_sound_and_repeats_itself(tmp_path: Path) -> None:
    path = tmp_path / "noisy.yaml"
    path.write_text(
        """
robot:
  kinematics: {name: diff}
  state: [1, 1, 0]
  goal: [8, 8]
  sensors: [{number: 36, angle_range: 2 * pi, range_max: 5, range_min: 0.3, noise: true}]
obstacle: {shape: {name: linestring, vertices: [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]}}
"""
    )
    env = ig.make(str(path))
    check_env(env.unwrapped, skip_render_check=True)
    action = np.zeros(env.action_space.shape or (), np.float32)
    runs = []
    for _ in range(2):
        observations = [env.reset(seed=5)[0], *(env.step(action)[0] for _ in range(4))]
        assert all(env.observation_space.contains(one) for one in observations)
        runs.append(np.array([gym.spaces.flatten(env.observation_space, one) for one in observations]))
    np.testing.assert_array_equal(runs[0], runs[1])
    # The robot stands still, so what differs between steps is the scan.
    assert (runs[0][1] != runs[0][2]).sum() > 20
    env.close()
