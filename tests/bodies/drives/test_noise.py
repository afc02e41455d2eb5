"""Motion noise: the distributions that the documentation gives, by statistics at fixed seeds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig

N = 4000
STEP = 0.1
LIMITS = {2: {"vel_max": [5, 5], "vel_min": [-5, -5]}, 3: {"vel_max": [5, 5, 5], "vel_min": [-5, -5, -5]}}


def executed(kinematics: dict[str, Any], velocity: list[float], heading: float = 0.0) -> np.ndarray:
    """Return what two such bodies executed in one step of many worlds: forward, left, turn; ``(N, 2, 3)``."""
    robot = {"kinematics": {**kinematics, "noise": True}, "unobstructed": True, **LIMITS[len(velocity)]}
    sim = ig.compile(ig.load_scenario({"robot": {**robot, "number": 2, "state": [0, 0, heading]}}), N, agents=(0, 1))
    sim.reset(seed=0)
    sim.step([velocity, velocity])
    assert np.all(sim.state.velocity[:, :, : len(velocity)] == velocity)
    x, y = sim.state.pose[:, :, 0] / STEP, sim.state.pose[:, :, 1] / STEP
    turned = (sim.state.pose[:, :, 2] - heading) / STEP
    if kinematics["name"] == "acker":
        turned = sim.state.steering
    forward = x * np.cos(heading) + y * np.sin(heading)
    return np.stack([forward, y * np.cos(heading) - x * np.sin(heading), turned], axis=2)


def check(sample: np.ndarray, mean: float, variance: float) -> None:
    """Compare a sample with a normal distribution, at five standard errors."""
    sample = sample.ravel()
    error = np.sqrt(variance / len(sample))
    assert sample.mean() == pytest.approx(mean, abs=5 * error)
    assert sample.var() == pytest.approx(variance, rel=5 * np.sqrt(2 / len(sample)))
    standard = (sample - mean) / np.sqrt(variance)
    assert np.mean(np.abs(standard) < 1) == pytest.approx(0.6827, abs=5 * 0.47 / np.sqrt(len(sample)))


def check_independent(*samples: np.ndarray) -> None:
    correlation = np.corrcoef(np.stack(samples)) - np.eye(len(samples))
    assert np.abs(correlation).max() < 5 / np.sqrt(N)


@pytest.mark.parametrize("name", ["diff", "acker"])
def test_noise_grows_with_the_command(name: str) -> None:
    kinematics = {"name": name, "alpha": [0.04, 0.09, 0.01, 0.16]} | ({"wheelbase": 1} if name == "acker" else {})
    found = executed(kinematics, [2.0, -0.5])
    check(found[..., 0], 2.0, 0.04 * 4 + 0.09 * 0.25)
    check(found[..., 2], -0.5, 0.01 * 4 + 0.16 * 0.25)
    check_independent(found[:, 0, 0], found[:, 0, 2], found[:, 1, 0], found[:, 1, 2])


@pytest.mark.parametrize("name", ["diff", "acker"])
def test_a_body_at_rest_stays_there(name: str) -> None:
    kinematics = {"name": name} | ({"wheelbase": 1} if name == "acker" else {})
    assert not executed(kinematics, [0.0, 0.0]).any()


@pytest.mark.parametrize("frame", ["world", "body"])
@pytest.mark.parametrize("velocity", [[0.0, 0.0], [2.0, -1.0]])
def test_omni_noise_does_not_depend_on_speed(velocity: list[float], frame: str) -> None:
    heading = 0.6 if frame == "body" else 0.0
    found = executed({"name": "omni", "frame": frame, "alpha": [0.04, 0.01]}, velocity, heading)
    check(found[..., 0], velocity[0], 0.04)
    check(found[..., 1], velocity[1], 0.01)
    assert not found[..., 2].any()
    check_independent(found[:, 0, 0], found[:, 0, 1], found[:, 1, 0], found[:, 1, 1])


def test_omni_takes_the_first_and_the_last_of_four_variances() -> None:
    found = executed({"name": "omni", "alpha": [0.04, 0, 0, 0.01]}, [0.0, 0.0])
    check(found[..., 0], 0.0, 0.04)
    check(found[..., 1], 0.0, 0.01)


def test_omni_angular_has_three_variances() -> None:
    found = executed({"name": "omni_angular", "alpha": [0.04, 0.01, 0.09]}, [1.0, -1.0, 0.5], 0.6)
    for axis, (mean, variance) in enumerate([(1.0, 0.04), (-1.0, 0.01), (0.5, 0.09)]):
        check(found[..., axis], mean, variance)
    check_independent(*(found[:, 0, axis] for axis in range(3)))


def test_steps_are_independent_and_only_noisy_members_deviate() -> None:
    noisy = {"kinematics": {"name": "omni", "noise": True}, "unobstructed": True}
    exact = {"kinematics": {"name": "omni"}, "unobstructed": True}
    sim = ig.compile(ig.load_scenario({"robot": [noisy, exact]}), N, agents=(0, 1))
    sim.reset(seed=0)
    places = [sim.state.pose[:, 0, 0].copy()]
    for _ in range(3):
        sim.step([[0.0, 0.0], [1.0, 0.0]])
        places.append(sim.state.pose[:, 0, 0].copy())
    check_independent(*np.diff(places, axis=0))
    assert np.all(sim.state.pose[:, 1] == [pytest.approx(0.3), 0, 0])


def test_stopped_bodies_draw_nothing() -> None:
    robot = {"kinematics": {"name": "omni", "noise": True}}
    sim = ig.compile(ig.load_scenario({"robot": robot}), 2, agents=(0,))
    sim.reset(seed=0)
    sim.state.stopped[0] = True
    before = sim.state.random.copy()
    sim.step([0.0, 0.0])
    assert (sim.state.random != before).tolist() == [False, True]
    assert not sim.state.pose[0].any()
