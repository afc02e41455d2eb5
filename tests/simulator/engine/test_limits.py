"""What a drive can execute of what it is asked, worked out by hand."""

from __future__ import annotations

import numpy as np

from irsim_gym.simulator.step.command_limits import limit_velocity
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State


def limited(worlds: list[int], fastest: list[list[float]], sharpest: list[list[float]], asked: float) -> np.ndarray:
    """Return the velocities of one body in three worlds, from rest, after a step of 0.1 s."""
    sizes = dict.fromkeys(("segment", "disc", "map_column", "map_row", "map_box", "bucket", "waypoint", "watching"), 0)
    sizes |= {"world": 3, "body": 1}
    limits = frozenset({"velocity_min", "velocity_max", "acceleration_limit"}) if len(fastest) > 1 else frozenset()
    model, state = Model.allocate(sizes, per_world=limits), State.allocate(sizes)
    model.velocity_min[:, 0], model.velocity_max[:, 0] = -np.array(fastest), fastest
    model.acceleration_limit[:, 0], model.step_time[0] = sharpest, 0.1
    model.present[:], model.driven[:], state.command[:] = True, True, asked
    limit_velocity(np.array(worlds), np.zeros(1, np.int64), model, state)
    return state.velocity[:, 0]


def test_each_world_has_limits_of_its_own() -> None:
    fastest = [[4.0, 4.0, 0.0], [2.5, 2.5, 0.0], [4.0, 4.0, 0.0]]
    sharpest = [[2.0, np.inf, 0.0], [30.0, 30.0, 0.0], [30.0, 2.0, 0.0]]
    expected = [[0.2, 4.0, 0.0], [2.5, 2.5, 0.0], [3.0, 0.2, 0.0]]
    np.testing.assert_allclose(limited([0, 1, 2], fastest, sharpest, 5.0), expected, atol=1e-15)


def test_worlds_share_what_has_one_row() -> None:
    expected = [[-0.2, -4.0, 0.0], [0.0, 0.0, 0.0], [-0.2, -4.0, 0.0]]
    found = limited([0, 2], [[4.0, 4.0, 0.0]], [[2.0, np.inf, 0.0]], -5.0)
    np.testing.assert_allclose(found, expected, atol=1e-15)
