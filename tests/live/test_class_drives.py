"""Drives as classes in IR-SIM's form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from irsim_gym.irsim.lib.handler.kinematics_handler import (
    DifferentialKinematics,
    KinematicsHandler,
    register_kinematics,
)

import irsim_gym as ig
from irsim_gym.base import families


class LagDiff(DifferentialKinematics):
    """Follows its commands as a first-order lag, as the kind drive_lag does."""

    def __init__(self, name: str, noise: bool, alpha: Any, tau: float = 0.5) -> None:
        super().__init__(name, noise, alpha)
        self.share_time, self.reached = tau, np.zeros((2, 1))

    def step(self, state: np.ndarray, velocity: np.ndarray, step_time: float) -> np.ndarray:
        self.reached = velocity + (self.reached - velocity) * np.exp(-step_time / self.share_time)
        return super().step(state, self.reached, step_time)


class Sideways(KinematicsHandler):
    """A crab with a third number, and the lag of the attribute."""

    action_dim = 3

    def step(self, state: np.ndarray, velocity: np.ndarray, step_time: float) -> Any:
        return [state[0, 0], state[1, 0] + velocity[2, 0] * step_time, self.tau]


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    families.load()
    monkeypatch.setattr(families.KINEMATICS, "_entries", dict(families.KINEMATICS._entries))
    register_kinematics("lag_diff")(LagDiff)
    register_kinematics("sideways")(Sideways)


def driven(kinematics: dict[str, Any], *disturbances: dict[str, Any], number: int = 1) -> ig.Simulation:
    robot = {"kinematics": kinematics, "disturbances": list(disturbances), "number": number}
    sim = ig.compile(ig.load_scenario({"robot": robot}), 2, agents=range(number))
    sim.reset(seed=0)
    return sim


def test_a_lag_drives_as_the_disturbance_does() -> None:
    lag = driven({"name": "lag_diff", "tau": 0.3})
    same = driven({"name": "diff"}, {"name": "drive_lag", "tau": 0.3})
    for _ in range(2):
        for command in ([1.0, 0.5], [1.0, 0.5], [1.0, 0.5], [0.2, -1.0]):
            for sim in (lag, same):
                sim.step(command)
            np.testing.assert_allclose(lag.state.pose, same.state.pose, atol=1e-12)
        for sim in (lag, same):
            sim.reset(seed=0)
    lag.step([1.0, 0.0])
    assert lag.state.twist[0, 0] == pytest.approx([1.0 - np.exp(-1.0 / 3.0), 0.0, 0.0])


def test_the_default_of_an_option_and_an_instance_for_each_body() -> None:
    sim = driven({"name": "lag_diff"}, number=2)
    sim.step([[1.0, 0.0], [0.5, 0.0]])
    assert sim.state.pose[1, :, 0] == pytest.approx(0.1 * (1.0 - np.exp(-0.2)) * np.array([1.0, 0.5]))


def test_what_it_believes_has_instances_of_its_own() -> None:
    sim = driven({"name": "lag_diff", "tau": 0.3}, {"name": "odometry"})
    for _ in range(3):
        sim.step([1.0, 0.3])
        np.testing.assert_allclose(sim.told.pose, sim.state.pose, atol=1e-12)


def test_commands_of_three_numbers_and_tau_as_an_attribute() -> None:
    sim = driven({"name": "sideways", "tau": 0.25})
    sim.step([0.0, 0.0, 0.5])
    assert sim.state.pose[0, 0] == pytest.approx([0.0, 0.05, 0.25])


def test_what_it_does_wrong_is_said_with_the_body() -> None:
    with pytest.raises(TypeError, match="must be a class derived from KinematicsHandler"):
        register_kinematics("lag")(lambda state: state)  # type: ignore[type-var]
    with pytest.raises(TypeError, match="unexpected keyword argument 'taus'") as caught:
        driven({"name": "lag_diff", "taus": 0.3})
    assert "in kinematics 'lag_diff' for 'robot_0'" in caught.value.__notes__[0]
