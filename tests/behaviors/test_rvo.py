"""RVO: golden vectors, what is avoided, and what it does where IR-SIM does something else on purpose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym import compile, load_scenario
from irsim_gym.engine.simulation import Simulation


def robot(state: list[float], goal: list[float], **others: Any) -> dict[str, Any]:
    behavior = {"name": "rvo", **others.pop("behavior", {})}
    shape = {"name": "circle", "radius": 0.2}
    return {"kinematics": {"name": "diff"}, "shape": shape, "state": state, "goal": goal, "behavior": behavior} | others


def simulation(*robots: dict[str, Any], obstacle: list[dict[str, Any]] | None = None, n: int = 1) -> Simulation:
    made = compile(load_scenario({"robot": list(robots), "obstacle": obstacle or []}), n_worlds=n)
    made.reset(seed=0)
    return made


def test_golden_pair() -> None:
    sim = simulation(robot([1, 5, 0], [9, 5, 0]), robot([3.2, 5.1, 3.14159], [1, 5, 0]))
    expected = [
        ([1.085, 5.0, -0.1], [0.85, -1.0]),
        ([1.171065374, 4.991364659, -0.185433285], [0.864975012, -0.854332849]),
        ([1.257892118, 4.975076975, -0.240833865], [0.883412253, -0.554005797]),
        ([1.350715612, 4.952279461, -0.240833865], [0.955820475, 0.0]),
    ]
    for pose, velocity in expected:
        sim.step()
        np.testing.assert_allclose(sim.state.pose[0, 0], pose, atol=6e-10)
        np.testing.assert_allclose(sim.state.velocity[0, 0, :2], velocity, atol=6e-10)


def test_a_goal_behind_is_turned_to_when_nothing_is_near() -> None:
    """v = -1 lies outside of what the drive can do from rest: it turns on the spot, at the fixed limit of 1.5 rad/s."""
    sim = simulation(robot([5, 5, 0], [1, 5.5, 0], vel_max=[1, 2], vel_min=[-1, -2]))
    sim.step()
    assert sim.state.velocity[0, 0, :2] == pytest.approx([0, 1.5])
