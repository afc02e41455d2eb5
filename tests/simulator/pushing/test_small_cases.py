"""Small cases of contact, each against a value worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

DT, G, SLOP = 0.1, 9.81, 1e-6
DISC: dict[str, Any] = {"shape": {"name": "circle", "radius": 0.3}}
BOX: dict[str, Any] = {"shape": {"name": "rectangle", "length": 0.6, "width": 0.6}}
ROBOT = {**DISC, "kinematics": {"name": "diff"}, "state": [1, 4, 0], "goal": [9, 4, 0], "behavior": {"name": "dash"}}


def run(steps: int, *obstacles: dict[str, Any], robot: Any = None, **world: Any) -> Any:
    data = {"world": {"collision_mode": "contact", **world}, "robot": robot or [], "obstacle": list(obstacles)}
    simulation = ig.compile(ig.load_scenario(data), check_starts=False)
    simulation.reset(seed=0)
    for _ in range(steps):
        simulation.step()
    return simulation


def overlapping(mass: Any, other: Any, gap: float = 0.5, **more: Any) -> np.ndarray:
    """Return how far two discs moved to the right that overlapped by 0.6 - gap, after one step."""
    one, two = (
        {**DISC, "mass": mass, "state": [3, 4, 0], **more},
        {**DISC, "mass": other, "state": [3 + gap, 4, 0], **more},
    )
    return run(1, one, two).state.pose[0, :, 0] - [3, 3 + gap]


def test_overlaps_are_shared_by_inverse_mass() -> None:
    depth = 0.1 + SLOP
    assert overlapping(1, 1) == pytest.approx([-depth / 2, depth / 2], abs=1e-12)
    assert overlapping(1, 3) == pytest.approx([-depth * 3 / 4, depth / 4], abs=1e-12)
    assert overlapping(1, "inf") == pytest.approx([-depth, 0], abs=1e-12)
    assert overlapping("inf", "inf") == pytest.approx([0, 0], abs=0)


def test_the_push_is_velocity_and_friction_then_takes_it() -> None:
    simulation = run(1, {**DISC, "mass": 1, "state": [3, 4, 0]}, {**DISC, "state": [3.5, 4, 0]})
    speed = (0.1 + SLOP) / DT
    assert simulation.state.velocity[0, 0].tolist() == pytest.approx([-speed, 0, 0], abs=1e-12)
    simulation.step()  # friction 0.5 takes 0.4905 m/s a step
    assert simulation.state.velocity[0, 0, 0] == pytest.approx(-speed + 0.5 * G * DT, abs=1e-12)


def test_discs_in_one_place_part_along_x() -> None:
    assert overlapping(1, 1, gap=0.0) == pytest.approx([(0.6 + SLOP) / 2, -(0.6 + SLOP) / 2], abs=1e-12)


@pytest.mark.parametrize(("gap", "touches"), [(1e-5 - 1e-7, True), (1e-5 + 1e-7, False)])
def test_bodies_touch_up_to_the_tolerance_and_are_left_there(gap: float, touches: bool) -> None:
    discs = [{**DISC, "mass": 1, "state": [x, 7, 0]} for x in (3, 3.6 + gap)]
    simulation = run(1, *discs, robot=ROBOT)  # where nothing moves, only what is within 1e-6 m is looked at
    assert simulation.parts.pushing.felt["touches"][0].tolist() == [False, touches, touches]
    assert simulation.state.pose[0, 1:, 0].tolist() == [3, 3.6 + gap]
    assert not simulation.parts.pushing.felt["x"].any()


def test_timers_count_steps_in_and_out_of_contact() -> None:
    robot = {**ROBOT, "state": [1, 4, 0], "goal": [2.0, 4, 0], "goal_threshold": 0.05}
    simulation = run(0, {**DISC, "mass": 0.2, "friction": 0.05, "state": [1.8, 4, 0]}, robot=robot)
    push, seen = simulation.parts.pushing, []
    for _ in range(30):
        simulation.step()
        felt = push.felt[0, 1]
        seen.append(
            (bool(felt["touches"]), bool(felt["changed"]), float(felt["contact_time"]), float(felt["air_time"]))
        )
    inside, outside = 0.0, 0.0
    before = False
    for touches, changed, contact_time, air_time in seen:
        inside, outside = (inside + DT, 0.0) if touches else (0.0, outside + DT)
        assert (contact_time, air_time) == pytest.approx((inside, outside))
        assert changed == (touches != before)
        before = touches
    assert {touches for touches, *_ in seen} == {True, False}


def test_forces_of_a_pair_are_opposite_and_of_the_ground_bounded() -> None:
    simulation = run(20, {**BOX, "mass": 0.6, "state": [2, 4, 0]}, robot=ROBOT)
    told = simulation.parts.pushing.reports[0, 0]
    felt = simulation.parts.pushing.felt[0]
    assert [felt["x"][0], felt["y"][0]] == [-felt["x"][1], -felt["y"][1]]
    assert told["force"] == pytest.approx(0.5 * 0.6 * G, abs=1e-6)
    assert [told["nx"], told["ny"]] == pytest.approx([-1, 0], abs=1e-9)
    # In the middle of the overlap, as deep as friction has held the box back in the step.
    front = simulation.state.pose[0, 0, 0] + 0.3
    assert [told["x"], told["y"]] == pytest.approx([front - 0.5 * 0.5 * G * DT * DT, 4], abs=1e-5)


@pytest.mark.parametrize("gravity", [9.81, 1.62])
@pytest.mark.parametrize(("mass", "speed"), [(0.99, 1.0), (1.01, 0.0)])
def test_what_a_robot_can_push_does_not_depend_on_gravity(gravity: float, mass: float, speed: float) -> None:
    simulation = run(60, {**BOX, "mass": mass, "state": [1.8, 4, 0]}, robot=ROBOT, gravity=gravity)
    assert simulation.state.velocity[0, 1, 0] == pytest.approx(speed, abs=1e-9)


@pytest.mark.parametrize(("friction", "moves"), [(0.24, True), (0.26, False)])
def test_a_slippery_box_may_be_heavier(friction: float, moves: bool) -> None:
    """Two kilograms with half of the robot's friction are as much as the robot's own."""
    box = {**BOX, "mass": 2, "friction": friction, "state": [2, 4, 0]}
    simulation = run(40, box, robot=ROBOT)
    assert simulation.state.velocity[0, 1, 0] == pytest.approx(float(moves), abs=1e-9)


def test_driven_bodies_share_a_collision_by_mass_and_never_bounce() -> None:
    robots = [{**ROBOT, "mass": 3, "state": [3, 4, 0]}, {**ROBOT, "mass": 1, "state": [3.55, 4, 0], "goal": [1, 4, 0]}]
    robots[1]["behavior"], robots[0]["behavior"] = None, None
    simulation = run(1, robot=robots, restitution=1)
    depth = 0.05 + SLOP
    assert simulation.state.pose[0, :, 0] == pytest.approx([3 - depth / 4, 3.55 + depth * 3 / 4], abs=1e-12)


def test_a_drive_loses_what_pushes_it_aside() -> None:
    """A car is moved across its heading, and gains no speed from it; an omni robot does."""
    wall = {"shape": {"name": "rectangle", "length": 4, "width": 1}, "state": [3, 3.3, 0]}
    for name, limits, speeds in (("diff", [1, 1], [0, 0]), ("omni", [1, 1], [0, (0.1 + SLOP) / DT])):
        robot = {**DISC, "kinematics": {"name": name}, "vel_max": limits, "state": [3, 4, 0], "goal": [9, 4]}
        simulation = run(1, wall, robot=robot)
        assert simulation.state.pose[0, 0, 1] == pytest.approx(4.1 + SLOP, abs=1e-9)
        assert simulation.state.velocity[0, 0, :2].tolist() == pytest.approx(speeds, abs=1e-9)


@pytest.mark.parametrize("inertia", [None, 2.0, "inf"])
def test_turns_go_by_the_inertia(inertia: Any) -> None:
    """A box with its own inertia of m (a^2 + b^2) / 12 = 0.03, or another one; a post pushes it off its middle."""
    box = {**BOX, "mass": 0.5, "state": [3, 4, 0], **({} if inertia is None else {"inertia": inertia})}
    pin = {"shape": {"name": "circle", "radius": 0.1}, "state": [3.39, 4.2, 0]}
    pose, own = run(1, box, pin).state.pose[0, 0], 0.03 if inertia is None else inertia
    if inertia == "inf":
        assert pose[2] == 0.0
        assert pose[0] == pytest.approx(3 - 0.01 - SLOP, abs=1e-9)
        return
    # q = depth / (1/m + lever^2 / I), with the lever of the contact at y = 0.2 above the centre.
    q = (0.01 + SLOP) / (1 / 0.5 + 0.2**2 / own)
    assert pose[2] == pytest.approx(q * 0.2 / own, rel=0.02)  # further sweeps follow the turned edge


def test_masses_of_a_list_go_to_the_bodies_in_turn() -> None:
    boxes = {
        **BOX,
        "number": 3,
        "state": [[2, 2, 0], [4, 2, 0], [6, 2, 0]],
        "mass": [1, 4],
        "friction": [0.1, 0.2, 0.3],
    }
    matter = run(0, boxes, robot=ROBOT).parts.matter
    assert matter.substance["inverse"][1:] == pytest.approx([1, 1 / 4, 1 / 4])
    assert matter.substance["grip"][1:] == pytest.approx([0.1 * 1 * G, 0.2 * 4 * G, 0.3 * 4 * G])
    assert matter.inertia[0, 1:] == pytest.approx([m * 0.72 / 12 for m in (1, 4, 4)])


@pytest.mark.parametrize(
    ("shape", "inertia"),
    [
        ({"name": "circle", "radius": 0.4}, 2 * 0.4**2 / 2),
        ({"name": "rectangle", "length": 1, "width": 0.5}, 2 * (1 + 0.25) / 12),
        ({"name": "polygon", "vertices": [[0, 0], [3, 0], [0, 3]]}, 2 * (9 + 9) / 18),
        ({"name": "linestring", "vertices": [[-1, 0], [1, 0]]}, 2 * 1 / 2),
    ],
)
def test_inertia_follows_from_the_shape(shape: dict[str, Any], inertia: float) -> None:
    """Textbook moments; a right triangle has m (a^2 + b^2) / 18, and lines count as discs of their radius."""
    matter = run(0, {"shape": shape, "mass": 2, "state": [4, 4, 0]}, robot=ROBOT).parts.matter
    assert matter.inertia[0, 1] == pytest.approx(inertia)


def test_a_bounce_keeps_its_share_of_the_speed() -> None:
    """Against a wall, with the mean of both restitutions: it comes back with half of its speed."""
    wall = {"shape": {"name": "rectangle", "length": 1, "width": 4}, "state": [4, 4, 0], "restitution": 0.6}
    ball = {**DISC, "mass": 1, "friction": 0, "restitution": 0.4, "state": [3.15, 4, 0], "velocity": [1, 0, 0]}
    simulation = run(1, ball, wall)
    assert simulation.state.velocity[0, 0, 0] == pytest.approx(-0.5, abs=1e-9)
    assert simulation.state.pose[0, 0, 0] == pytest.approx(3.2 - SLOP, abs=1e-9)


def test_an_acker_feels_its_push_along_its_heading() -> None:
    shape = {"name": "rectangle", "length": 0.8, "width": 0.4, "wheelbase": 0.5}
    robot = {**ROBOT, "kinematics": {"name": "acker"}, "shape": shape, "state": [1, 4, 0, 0], "mass": 2}
    simulation = run(40, {**BOX, "mass": 1, "state": [2.5, 4, 0]}, robot=robot)
    assert simulation.state.velocity[0, :, 0] == pytest.approx([1, 1], abs=1e-9)
    assert simulation.parts.pushing.felt["x"][0, 1] == pytest.approx(0.5 * G, abs=1e-6)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({"mass": -1}, "mass"), ({"mass": 0}, "mass"), ({"friction": -0.1}, "friction"),
        ({"restitution": 1.5}, "restitution"), ({"inertia": -1}, "inertia"), ({"mass": [1, -2], "number": 2}, "mass"),
        ({"mass": float("nan")}, "mass"),
    ],
)  # fmt: skip
def test_numbers_out_of_range_are_told(body: dict[str, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        run(0, {**BOX, "state": [4, 4, 0], **body}, robot=ROBOT)
