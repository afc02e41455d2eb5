"""What a script reads of contacts that push: masses, forces, messages and marks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig

ROBOT: dict[str, Any] = {
    "kinematics": {"name": "diff"},
    "shape": {"name": "circle", "radius": 0.3},
    "state": [1, 4, 0],
    "goal": [9, 4, 0],
    "behavior": {"name": "dash"},
    "sensors": [{"type": "contact2d", "force_scale": 0.1, "plot": {"color": "red"}}],
}
BOX = {"shape": {"name": "rectangle", "length": 0.8, "width": 0.4}, "state": [1.9, 4, 0], "mass": 0.5}
WALL = {"shape": {"name": "linestring", "vertices": [[8, 0], [8, 8]]}}


def world(*obstacles: dict[str, Any], mode: str = "contact", **options: Any) -> Any:
    return ig.load({"world": {"collision_mode": mode}, "robot": ROBOT, "obstacle": list(obstacles)}, **options)


def test_masses() -> None:
    here = world({**BOX, "friction": 0.2}, WALL)
    robot, box, wall = here.objects
    assert (robot.mass, robot.passive, robot.pushable, robot.friction) == (1.0, False, True, 0.5)
    assert robot.inertia == pytest.approx(0.5 * 0.3**2)
    assert robot.friction_force == pytest.approx(0.5 * 9.81)
    assert (box.mass, box.inv_mass, box.passive, box.static, box.color) == (0.5, 2.0, True, False, "#E69F00")
    # An even rectangle: m (a^2 + b^2) / 12.
    assert box.inertia == pytest.approx(0.5 * (0.8**2 + 0.4**2) / 12)
    assert box.gyration == pytest.approx(np.sqrt((0.8**2 + 0.4**2) / 12))
    assert box.inv_inertia == pytest.approx(1 / box.inertia)
    assert (wall.mass, wall.inv_mass, wall.inv_inertia, wall.gyration, wall.pushable) == (np.inf, 0, 0, 0, False)
    assert here.world_param.gravity == 9.81


def test_contacts() -> None:
    here = world(BOX, WALL)
    for _ in range(12):
        here.step()
    robot, box, wall = here.objects
    (record,) = here.contacts
    assert (record.a, record.b) == (robot, box)
    felt = robot.contact
    assert (felt.in_contact, felt.started, felt.ended) == (True, False, False)
    assert (felt.partners, box.contact.partners) == ([box], [robot])
    assert felt.force == pytest.approx([-0.5 * 0.5 * 9.81, 0.0])  # the ground holds 0.5 kg
    assert box.contact.reports[0].normal.tolist() == [1.0, 0.0]
    assert felt.contact_time == box.contact.contact_time > 0.5
    assert (wall.contact.in_contact, wall.contact.air_time) == (False, pytest.approx(1.2))
    told = here.get_msg().objects
    assert (told[1].contact_force.x, told[1].contacts[0].other) == (pytest.approx(2.4525), "robot_0")
    assert robot.drive_velocity_xy == pytest.approx([1.0, 0.0])
    (point, line) = here.simulation.marks(0)
    assert point.color == line.color == "red"
    assert np.ptp(line.points, axis=0) == pytest.approx([0.24525, 0.0])
    assert np.isfinite(here.render()).all()


def test_velocities_that_a_script_sets() -> None:
    here = world(BOX, WALL)
    robot, box, wall = here.objects
    robot.set_velocity([0.8, 0.1])
    assert robot.drive_velocity_xy == pytest.approx([0.8, 0.0])
    box.set_velocity([1.0, 0.0, 0.5])
    assert box.velocity.tolist() == [1.0, 0.0, 0.5]
    with pytest.raises(ValueError, match="'obstacle_2' never moves"):
        wall.set_velocity([1, 0])


def test_a_body_that_is_added_changes_nothing_that_others_feel() -> None:
    here = world(BOX)
    for _ in range(8):
        here.step()
    before = here.robot.contact.contact_time, here.robot.drive_velocity_xy.tolist()
    here.add(shape={"name": "circle"}, state=[5, 8, 0])
    assert (here.robot.contact.contact_time, here.robot.drive_velocity_xy.tolist()) == before
    here.reset()
    assert here.robot.contact.contact_time == 0.0


def test_without_contact_mode_nobody_feels_anything() -> None:
    here = world(BOX, mode="stop")
    for _ in range(12):
        here.step()
    assert here.contacts == []
    assert here.robot.contact.force.tolist() == [0.0, 0.0]
    assert here.robot.inertia == pytest.approx(0.045)
