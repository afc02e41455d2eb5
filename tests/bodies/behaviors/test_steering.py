"""World velocities to commands, against IR-SIM's conversions."""

from __future__ import annotations

import numpy as np
import pytest
from irsim.util.util import vel_world2diff, vel_world2omni

from irsim_gym.bodies.behaviors.shared.steering import Turning, to_command
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, OMNI_ANGULAR, OMNI_BODY, OMNI_WORLD


def converted(drive: int, heading: float, vx: float, vy: float, *constants: float) -> list[float]:
    command = np.full(3, 9.0)
    to_command(drive, heading, vx, vy, Turning(*(constants or (0.2, 0.1, 0.02, 1.5))), command)
    return list(command)


def test_differential_drives_are_steered_as_in_ir_sim() -> None:
    random = np.random.default_rng(0)
    for _ in range(200):
        heading, (vx, vy) = random.uniform(-4, 4), random.uniform(-1, 1, 2) * random.choice([0.02, 1])
        expected = vel_world2diff(heading, [vx, vy])[:, 0]
        assert converted(DIFFERENTIAL, heading, vx, vy) == pytest.approx([*expected, 0], abs=1e-12)
        expected = vel_world2diff(heading, [vx, vy], w_max=0.8, guarantee_time=0.1, tolerance=0.02)[:, 0]
        assert converted(DIFFERENTIAL, heading, vx, vy, 0.1, 0.02, 0.02, 0.8) == pytest.approx(
            [*expected, 0], abs=1e-12
        )


def test_straight_behind_turns_left_as_in_ir_sim() -> None:
    assert converted(DIFFERENTIAL, 0.0, -1.0, 0.0) == pytest.approx([0, 1.5, 0])
    assert vel_world2diff(0.0, [-1.0, 0.0])[:, 0].tolist() == [0, 1.5]


def test_omnidirectional_drives_execute_the_velocity() -> None:
    expected = vel_world2omni(0.7, [1.0, -2.0])[:, 0]
    assert converted(OMNI_BODY, 0.7, 1.0, -2.0) == pytest.approx([*expected, 0])
    assert converted(OMNI_ANGULAR, 0.7, 1.0, -2.0) == pytest.approx([*expected, 0])
    assert converted(OMNI_WORLD, 0.7, 1.0, -2.0) == [1, -2, 0]


def test_a_car_cannot_follow_a_velocity() -> None:
    assert converted(ACKERMANN, 0.7, 1.0, -2.0) == [0, 0, 0]
