"""Who moves, who stalls, and what is felt, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError
from irsim_gym.simulator.engine import Shard

DT, GRIP = 0.1, 0.5 * 9.81
"""Duration of a step [s], and the friction of a mass of 1 kg [N]."""
SLOP = 1e-6
BALL: dict[str, Any] = {"shape": {"name": "circle", "radius": 0.3}}
BOX: dict[str, Any] = {"shape": {"name": "rectangle", "length": 0.6, "width": 0.6}}
ROBOT = {**BALL, "kinematics": {"name": "diff"}, "state": [1, 4, 0], "goal": [9, 4, 0], "behavior": {"name": "dash"}}


def begun(*obstacles: dict[str, Any], robot: Any = None, n_worlds: int = 1, **world: Any) -> Any:
    data = {"world": {"collision_mode": "contact", **world}, "robot": robot or [], "obstacle": list(obstacles)}
    simulation = ig.compile(ig.load_scenario(data), n_worlds)
    simulation.reset(seed=0)
    return simulation


def force(push: Any, b: int) -> list[float]:
    return [push.felt["x"][0, b], push.felt["y"][0, b]]


def after(simulation: Any, steps: int) -> Any:
    for _ in range(steps):
        simulation.step()
    return simulation


def test_friction_slows_what_coasts() -> None:
    ball = {**BALL, "mass": 2, "friction": 0.1, "state": [2, 4, 0], "velocity": [2, 0, 3]}
    state = after(begun(ball), 1).state
    # b = 0.1 * 9.81 * 0.1; the radius of gyration of a disc is its radius over the root of 2.
    speed, rate = 2 - 0.0981, 3 - 0.0981 / (0.3 / np.sqrt(2))
    assert state.velocity[0, 0] == pytest.approx([speed, 0, rate], abs=1e-12)
    assert state.pose[0, 0] == pytest.approx([2 + speed * DT, 4, rate * DT], abs=1e-12)
    assert state.twist[0, 0].tolist() == state.velocity[0, 0].tolist()


@pytest.mark.parametrize("mode", ["stop", "unobstructed"])
def test_bodies_coast_in_other_modes_too(mode: str) -> None:
    ball = {**BALL, "mass": 1, "friction": 0, "state": [2, 4, 0], "velocity": [1, 0, 0]}
    simulation = after(begun(ball, {**BALL, "state": [3.25, 4, 0]}, collision_mode=mode), 8)
    # The wall is 0.65 m away: after 7 steps they touch, and with stop the ball stands from then on.
    assert simulation.state.pose[0, 0, 0] == pytest.approx(2.7 if mode == "stop" else 2.8)
    assert simulation.state.velocity[0, 0, 0] == (0.0 if mode == "stop" else 1.0)
    assert simulation.model.stands.tolist() == [False, True]
    assert simulation.parts.pushing is None


def test_a_drive_gathers_speed_no_faster_than_it_grips() -> None:
    state = after(begun(robot={**ROBOT, "friction": 0.2}), 3).state
    # 0.2 * 9.81 * 0.1 more in each step.
    assert state.velocity[0, 0, 0] == pytest.approx(3 * 0.1962)
    assert state.pose[0, 0, 0] == pytest.approx(1 + 0.1 * 0.1962 * (1 + 2 + 3))


@pytest.mark.parametrize("own", [False, True])
def test_a_drive_lags_behind(own: bool) -> None:
    robot = {**ROBOT, "kinematics": {"name": "diff", "tau": 0.5}} if own else ROBOT
    state = after(begun(robot=robot, drive_tau=9.0 if own else 0.5, friction=5), 2).state
    assert state.velocity[0, 0, 0] == pytest.approx(1 - 0.8**2)


@pytest.mark.parametrize(("masses", "moves"), [([0.9], True), ([1.1], False), ([0.5, 0.4], True), ([0.6, 0.6], False)])
def test_a_robot_pushes_what_its_grip_can_and_stalls_at_more(masses: list[float], moves: bool) -> None:
    boxes = [{**BOX, "mass": mass, "state": [1.7 + 0.6 * k, 4, 0]} for k, mass in enumerate(masses)]
    simulation = after(begun(*boxes, robot=ROBOT), 20)
    push, state, last = simulation.parts.pushing, simulation.state, len(masses)
    assert state.velocity[0, 0, 0] == pytest.approx(1.0 if moves else 0.0, abs=1e-9)
    assert push.drive[0, 0, 0] == 1.0  # the wheels do not know
    assert push.felt["touches"][0].all()
    gaps = [0.6] * last
    assert np.diff(state.pose[0, :, 0]) == pytest.approx(gaps, abs=1e-5)
    # The floor holds a box with 0.5 * 9.81 N for a kilogram; a robot that stalls presses as hard as it grips.
    felt = GRIP * masses[0] if moves else GRIP
    assert force(push, 0) == pytest.approx([-felt, 0.0], abs=1e-6)


def test_a_wall_stops_what_is_across_and_lets_slide_what_is_along() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[0, 4.6], [9, 4.6]]}}
    robot = {**ROBOT, "kinematics": {"name": "omni"}, "state": [1, 4, 0], "goal": [7, 10], "vel_max": [1, 1]}
    state = after(begun(wall, robot=robot), 20).state
    assert state.pose[0, 0, 1] == pytest.approx(4.3 - SLOP, abs=1e-9)
    assert state.velocity[0, 0, 0] > 0.5
    assert state.velocity[0, 0, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("friction", "slides"), [(0.9, False), (0.4, True)])
def test_a_box_slides_along_a_wall_outside_of_the_cone_of_friction(friction: float, slides: bool) -> None:
    """Two balls are squeezed into a wall at 45 degrees: their tangent of 1 against the mean of 0.9 or 0.4 and 1.6."""
    wall = {"shape": {"name": "linestring", "vertices": [[0, 4.35], [9, 4.35]]}, "friction": 1.6}
    ball = {**BALL, "mass": 0.1, "friction": friction, "state": [1.42, 4.05 - 2 * SLOP, 0]}
    robot = {**ROBOT, "kinematics": {"name": "omni"}, "state": [1, 3.63, 0], "goal": [9, 11.63], "mass": 5}
    before = 1.42
    state = after(begun(wall, ball, robot=robot), 5).state
    assert (state.pose[0, 2, 0] - before > 0.05) == slides
    assert state.pose[0, 2, 1] == pytest.approx(4.05 - SLOP, abs=1e-5)


def test_a_push_beside_the_middle_turns_a_box() -> None:
    box = {**BOX, "mass": 0.2, "state": [1.7, 4.2, 0]}
    state = after(begun(box, robot=ROBOT), 8).state
    assert state.pose[0, 1, 2] > 0.05  # pushed below its middle, it turns to the left
    fixed = after(begun({**box, "inertia": "inf"}, robot=ROBOT), 8).state
    assert fixed.pose[0, 1, 2] == 0.0


def test_balls_of_equal_mass_exchange_their_speeds() -> None:
    ball = {**BALL, "mass": 1, "friction": 0}
    one, other = {**ball, "state": [2, 4, 0], "velocity": [1, 0, 0]}, {**ball, "state": [3, 4, 0]}
    state = after(begun(one, other, restitution=1), 20).state
    # Half of the overlap moves each of them, and counts as speed: both went on with 1 together, and then part.
    assert state.velocity[0, :, 0].sum() == pytest.approx(1.0, abs=1e-12)
    assert state.velocity[0, 1, 0] - state.velocity[0, 0, 0] == pytest.approx(1.0, abs=1e-12)


def test_no_momentum_is_made_and_no_energy() -> None:
    rng = np.random.default_rng(3)
    balls = [
        {**BALL, "mass": float(rng.uniform(0.5, 2)), "friction": 0, "state": [3 + 0.7 * (k % 4), 3 + 0.7 * (k // 4), 0],
         "velocity": [*rng.uniform(-1, 1, 2), 0]} for k in range(12)
    ]  # fmt: skip
    for restitution in (0.0, 1.0):
        simulation = begun(*balls, restitution=restitution)
        masses = np.array([ball["mass"] for ball in balls])
        momenta, energies = [], []
        for _ in range(40):
            velocity = simulation.state.velocity[0, :, :2]
            momenta.append(masses @ velocity)
            energies.append(0.5 * masses @ (velocity**2).sum(axis=1))
            simulation.step()
        assert np.array(momenta) == pytest.approx(np.array([momenta[0]] * 40), abs=1e-12)
        if restitution == 0.0:
            # Taking bodies apart gives them speed, a slop of 1e-6 m in a step of 0.1 s at the least.
            assert max(energies) <= energies[0] * 1.05


def test_the_order_of_obstacles_changes_nothing_but_rounding() -> None:
    boxes = [
        {**BOX, "mass": 0.3, "state": [2, 4.1, 0.3]},
        {**BALL, "mass": 0.2, "state": [4, 6, 0]},
        {**BOX, "state": [6, 4, 0.2]},
    ]
    one, other = (after(begun(*chosen, robot=ROBOT), 40) for chosen in (boxes, boxes[::-1]))
    assert one.state.pose[0, [0, 1, 2, 3]] == pytest.approx(other.state.pose[0, [0, 3, 2, 1]], abs=1e-10)


def test_unobstructed_bodies_and_absent_ones_take_no_part() -> None:
    ghost = {**BOX, "mass": 0.3, "state": [2, 4, 0], "unobstructed": True}
    simulation = after(begun(ghost, {**BOX, "mass": 0.3, "state": [4, 4, 0]}, robot=ROBOT), 5)
    gone = np.array([[False, False, True]])
    simulation.vanish(Shard(np.array([0])), np.arange(3), gone)
    after(simulation, 40)
    assert simulation.state.pose[0, 0, 0] > 5.0
    assert simulation.state.pose[0, 1:, 0].tolist() == [2, 4]
    assert not simulation.parts.pushing.felt["touches"].any()


def test_levels_draw_outlines_and_maps() -> None:
    robot = {**ROBOT, "distribution": {"name": "random"}, "goal": None, "number": 2}
    shapes = [
        {"name": "circle", "random_shape": True},
        {"name": "rectangle", "random_shape": True},
        {"name": "polygon", "random_shape": True, "is_convex": True},
        {"name": "linestring", "random_shape": True},
    ]
    drawn = [{"shape": shape, "mass": 0.5, "distribution": {"name": "random"}} for shape in shapes]
    world = {"obstacle_map": {"name": "cells", "fill": [0.03, 0.06]}}
    robot["behavior"] = {"name": "dash", "wander": True, "range_low": [0, 0, -3], "range_high": [10, 10, 3]}
    sims = [begun(*drawn, robot=robot, n_worlds=3, **world), begun(*drawn, robot=robot, **world)]
    sims[0].reset(seed=5)
    sims[1].reset(seed=7)
    for _ in range(60):
        for simulation in sims:
            simulation.step()
    many, single = sims
    matter = many.parts.matter
    assert len({float(one) for one in matter.inertia[:, 2]}) == 3
    disc = many.model.local_discs[:, many.model.disc_start[2], 2]
    assert matter.inertia[:, 2] == pytest.approx(0.5 * 0.5 * disc**2)
    assert np.array_equal(many.state.pose[2], single.state.pose[0])
    assert np.array_equal(many.parts.pushing.felt[2], single.parts.pushing.felt[0])


def test_what_contact_does_not_go_with_is_refused() -> None:
    with pytest.raises(ScenarioError, match="collision_check: contact takes bodies apart where the step ends"):
        begun(robot=ROBOT, collision_check="swept")
    shape = {"name": "polygon", "random_shape": True}
    with pytest.raises(ScenarioError, match="is_convex: true"):
        begun({"shape": shape, "distribution": {"name": "random"}})
    assert begun(robot=ROBOT, step_mode="external").parts.pushing is None


def test_who_begins_anew_has_felt_nothing() -> None:
    robot = {**ROBOT, "distribution": {"name": "random"}, "goal": [9, 4]}
    simulation = begun({**BOX, "mass": 5, "state": [5, 5, 0]}, robot=robot, n_worlds=2)
    push = simulation.parts.pushing
    push.felt["contact_time"], push.felt["x"], push.drive[:] = 1.0, 1.0, 0.5
    simulation.respawn(Shard(np.arange(2)), np.array([0]), np.array([[True], [False]]))
    assert push.felt["contact_time"].tolist() == [[0.0, 1.0], [1.0, 1.0]]
    assert push.drive[:, 0, 0].tolist() == [0.0, 0.5]
