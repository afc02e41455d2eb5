"""Social forces, alone and as a group."""

from __future__ import annotations

import numpy as np
import yaml

from irsim_gym import compile, load_scenario
from irsim_gym.engine.simulation import Simulation

GOLDEN = """
robot: [{kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [1, 5, 0], goal: [9, 5, 0],
         behavior: {name: sfm}}]
obstacle:
  - {shape: {name: linestring, vertices: [[0, 6], [9, 6]]}, state: [0, 0, 0]}
  - {shape: {name: circle, radius: 0.3}, state: [3, 4.8, 0]}
"""


def simulation(text: str, n: int = 1) -> Simulation:
    made = compile(load_scenario(yaml.safe_load(text)), n_worlds=n)
    made.reset(seed=0)
    return made


def test_golden_walk_between_a_wall_and_a_disc() -> None:
    sim = simulation(GOLDEN)
    expected = [
        ([1.029933012, 4.958320497, 0.0], [0.299330118, -0.416795031]),
        ([1.083117186, 4.885185895, 0.0], [0.531841741, -0.731346017]),
        ([1.155012427, 4.790462212, 0.0], [0.718952411, -0.947236835]),
    ]
    for pose, velocity in expected:
        sim.step()
        np.testing.assert_allclose(sim.state.pose[0, 0], pose, atol=6e-10)
        np.testing.assert_allclose(sim.state.velocity[0, 0, :2], velocity, atol=6e-10)
