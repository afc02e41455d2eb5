"""Drives against IR-SIM's own steps, its recorded numbers, and values worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from irsim.lib.algorithm import kinematics as theirs

import irsim_gym as ig

DISC = {"name": "circle", "radius": 0.2}
CAR = {"name": "rectangle", "length": 4.6, "width": 1.6, "wheelbase": 3}
FAST = {2: {"vel_max": [9, 9], "vel_min": [-9, -9]}, 3: {"vel_max": [9, 9, 9], "vel_min": [-9, -9, -9]}}
THEIRS = {
    "diff": theirs.differential_kinematics,
    "omni": theirs.omni_kinematics,
    "omni_angular": theirs.omni_angular_kinematics,
    "acker": lambda state, velocity, dt: theirs.ackermann_kinematics(state, velocity, dt, wheelbase=0.7),
}
DRIVES: dict[str, dict[str, Any]] = {
    "diff": {"name": "diff"},
    "omni": {"name": "omni", "frame": "body"},
    "omni_angular": {"name": "omni_angular"},
    "acker": {"name": "acker", "wheelbase": 0.7},
}


def simulation(robot: dict[str, Any], n_worlds: int = 1, *, led: bool = True, **world: Any) -> ig.Simulation:
    robot = {"shape": DISC, **robot}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robot}), n_worlds, agents=(0,) if led else ())
    sim.reset(seed=0)
    return sim


def step(state: list[float], velocity: list[float], **kinematics: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return state (x, y, heading, steering) and twist after one step of 0.1 s."""
    sim = simulation({"kinematics": kinematics, "state": state, **FAST[len(velocity)]})
    sim.step(velocity)
    return np.append(sim.state.pose[0, 0], sim.state.steering[0, 0]), sim.state.twist[0, 0]


@pytest.mark.parametrize("name", DRIVES)
def test_a_step_is_ir_sims(name: str) -> None:
    random = np.random.default_rng(1)
    n_worlds, size = 40, 3 if name == "omni_angular" else 2
    sim = simulation({"kinematics": DRIVES[name], **FAST[size]}, n_worlds)
    state = random.uniform(-3, 3, (n_worlds, 4))
    state[:, 3] /= 3
    state[:4, 2] = [np.pi, -np.pi, np.pi - 1e-9, 0.0]
    velocity = random.uniform(-4, 4, (n_worlds, 1, size))
    velocity[:4] = 0.0
    sim.state.pose[:, 0], sim.state.steering[:, 0] = state[:, :3], state[:, 3]
    sim.step(velocity)
    for w in range(n_worlds):
        expected = THEIRS[name](state[w, : 4 if name == "acker" else 3, None], velocity[w, 0, :, None], 0.1)[:, 0]
        found = np.append(sim.state.pose[w, 0], sim.state.steering[w, 0])[: len(expected)]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12, err_msg=str(state[w]))


def test_half_a_turn_reads_minus_pi() -> None:
    state, _ = step([0, 0, 0], [0, np.pi / 0.1 - 30], name="diff")
    assert state[2] == pytest.approx(0.1 * (np.pi / 0.1 - 30))
    sim = simulation({"kinematics": {"name": "diff"}, "state": [0, 0, np.pi], **FAST[2]})
    sim.step([0.0, 0.0])
    assert sim.state.pose[0, 0, 2] == -np.pi


def test_heading_wraps_into_the_angle_range() -> None:
    for kinematics in DRIVES.values():
        sim = simulation({"kinematics": kinematics, "state": [0, 0, -1.0], "angle_range": [0, 2 * np.pi]})
        sim.step([0.0, 0.0, 0.0])
        assert sim.state.pose[0, 0, 2] == pytest.approx(2 * np.pi - 1)


def test_twist_has_the_heading_after_the_move() -> None:
    _, twist = step([0, 0, 0.3], [2.0, 5.0], name="diff")
    assert twist == pytest.approx([2 * np.cos(0.8), 2 * np.sin(0.8), 5])
    _, twist = step([0, 0, 0.3], [2.0, 1.0, 5.0], name="omni_angular")
    assert twist == pytest.approx([2 * np.cos(0.8) - np.sin(0.8), 2 * np.sin(0.8) + np.cos(0.8), 5])
    state, twist = step([0, 0, 0.3, 0.5], [2.0, 0.4], name="acker", wheelbase=0.8)
    heading = 0.3 + 2 * np.tan(0.5) / 0.8 * 0.1
    assert state[2:] == pytest.approx([heading, 0.4])
    assert twist == pytest.approx([2 * np.cos(heading), 2 * np.sin(heading), 2 * np.tan(0.4) / 0.8])


def test_omni_commands_are_in_the_world_frame_unless_the_body_is_named() -> None:
    state, twist = step([1, 1, 1.2], [2.0, -1.0], name="omni")
    assert state[:3] == pytest.approx([1.2, 0.9, 1.2])
    assert twist == pytest.approx([2, -1, 0])
    state, twist = step([1, 1, np.pi / 2], [2.0, -1.0], name="omni", frame="body")
    assert state[:3] == pytest.approx([1.1, 1.2, np.pi / 2])
    assert twist == pytest.approx([1, 2, 0])


@pytest.mark.parametrize("name", DRIVES)
def test_a_stopped_body_has_no_twist(name: str) -> None:
    size = 3 if name == "omni_angular" else 2
    sim = simulation({"kinematics": DRIVES[name], "state": [1, 1, 0.3]})
    sim.state.stopped[:] = True
    sim.step([1.0] * size)
    assert sim.state.pose[0, 0] == pytest.approx([1, 1, 0.3])
    assert not sim.state.twist.any()
    assert not sim.state.velocity.any()


def test_angular_mode_turns_at_the_yaw_rate_and_steers_accordingly() -> None:
    for speed in (2.0, -2.0):
        state, twist = step([0, 0, 0.1, 0.4], [speed, 0.5], name="acker", mode="angular", wheelbase=0.8)
        assert state[2:] == pytest.approx([0.15, np.arctan(0.5 * 0.8 / speed)])
        assert twist[2] == pytest.approx(0.5)
        assert speed * np.tan(state[3]) / 0.8 == pytest.approx(0.5)


def test_angular_mode_at_rest_keeps_heading_and_steering() -> None:
    state, twist = step([0, 0, 0.1, 0.4], [0.0, 0.5], name="acker", mode="angular", wheelbase=0.8)
    assert state == pytest.approx([0, 0, 0.1, 0.4])
    assert twist.tolist() == [0, 0, 0]


def test_limits_bind_the_commanded_component() -> None:
    # Steering changes by at most acce[1] dt = 0.1 rad a step; in angular mode the yaw rate does.
    limits = {"acce": [9, 1], "state": [0, 0, 0, 0], "velocity": [1, 0.2]}
    sim = simulation({"kinematics": {"name": "acker", "wheelbase": 1}, **limits})
    sim.step([1.0, 1.0])
    assert sim.state.steering[0, 0] == pytest.approx(0.3)
    sim = simulation({"kinematics": {"name": "acker", "wheelbase": 1, "mode": "angular"}, **limits})
    sim.step([1.0, 1.0])
    assert sim.state.pose[0, 0, 2] == pytest.approx(0.03)


def test_wheelbase_of_the_drive_comes_before_the_shapes_and_does_not_move_the_outline() -> None:
    car = {"kinematics": {"name": "acker", "wheelbase": 2}, "shape": CAR, "state": [0, 0, 0, 0.5]}
    sim = simulation(car)
    assert sim.state.segments[0, :, 0].min() == pytest.approx(-0.8)
    sim.step([1.0, 0.0])
    assert sim.state.pose[0, 0, 2] == pytest.approx(np.tan(0.5) / 2 * 0.1)
    sim = simulation({**car, "kinematics": {"name": "acker"}})
    sim.step([1.0, 0.0])
    assert sim.state.pose[0, 0, 2] == pytest.approx(np.tan(0.5) / 3 * 0.1)


def test_limits_and_velocity_have_the_drives_length_by_default() -> None:
    sim = simulation({"kinematics": {"name": "omni_angular"}, "velocity": [0.1, 0.2]})
    assert sim.model.velocity_max[0, 0].tolist() == [1, 1, 1]
    assert sim.model.velocity_min[0, 0].tolist() == [-1, -1, -1]
    assert np.all(np.isinf(sim.model.acceleration_limit[0, 0]))
    assert sim.state.velocity[0, 0].tolist() == [0.1, 0.2, 0.0]
    assert sim.state.twist[0, 0] == pytest.approx([0.1, 0.2, 0.0])


def test_state_is_cut_or_filled_to_what_the_drive_has() -> None:
    sim = simulation({"kinematics": {"name": "diff"}, "state": [1, 2, 0.5, 9], "state_dim": 3, "vel_dim": 2})
    assert sim.state.pose[0, 0].tolist() == [1, 2, 0.5]
    sim = simulation({"kinematics": DRIVES["acker"], "state": [1, 2], "state_dim": 4})
    assert np.append(sim.state.pose[0, 0], sim.state.steering[0, 0]).tolist() == [1, 2, 0, 0]


def test_velocities_at_the_start_are_seen_in_the_world_frame() -> None:
    # Facing +y: ahead 1.0 and 0.5 to the left are -0.5 in x and 1.0 in y.
    given = {"state": [2, 5, np.pi / 2], "velocity": [1.0, 0.5]}
    own = simulation({"kinematics": {"name": "omni", "frame": "body"}, **given})
    assert own.state.twist[0, 0] == pytest.approx([-0.5, 1.0, 0.0])
    turning = simulation({"kinematics": {"name": "omni_angular"}, **given, "velocity": [1.0, 0.5, 0.3]})
    assert turning.state.twist[0, 0] == pytest.approx([-0.5, 1.0, 0.3])
    ahead = simulation({"kinematics": {"name": "diff"}, "state": [2, 5, 2.0], "velocity": [0.7, 0.3]})
    assert ahead.state.twist[0, 0] == pytest.approx([0.7 * np.cos(2.0), 0.7 * np.sin(2.0), 0.3])
