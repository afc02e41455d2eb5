"""Contacts between bodies that never move are found once, and again where one of them stands elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np

import irsim_gym
from irsim_gym.simulator.engine import Simulation

N_WORLDS = 4


def compiled() -> Simulation:
    """Return worlds of one to three discs in a row, each of which overlaps the next, and a box that is alone."""
    discs = {"shape": {"name": "circle", "radius": 0.6}, "state": [[1, 1], [2, 1], [3, 1]], "number_range": [1, 3]}
    box = {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [6, 6, 0]}
    robot = {"kinematics": {"name": "diff"}, "state": [8, 2, 0], "goal": [9, 2]}
    data: dict[str, Any] = {"robot": robot, "obstacle": [discs, box]}
    return irsim_gym.compile(irsim_gym.load_scenario(data), n_worlds=N_WORLDS)


def test_a_level_after_others_has_the_contacts_of_a_fresh_one() -> None:
    sim, seen = compiled(), set()
    for seed in range(12):
        sim.reset(seed=seed)
        fresh = compiled()
        fresh.reset(seed=seed)
        np.testing.assert_array_equal(sim.model.present, fresh.model.present)
        for ours, expected in (
            (sim.model.static_partner, fresh.model.static_partner),
            (sim.state.hit, fresh.state.hit),
            (sim.state.collided, fresh.state.collided),
        ):
            np.testing.assert_array_equal(ours, expected)
        seen |= {tuple(row) for row in sim.model.static_partner.tolist()}
    assert seen == {(-1, -1, -1, -1, -1), (-1, 2, 1, -1, -1), (-1, 2, 1, 2, -1)}


def test_what_is_put_elsewhere_touches_there_and_no_longer_here() -> None:
    sim = compiled()
    sim.reset(seed=0)
    two = np.flatnonzero(sim.model.present[:, 2])
    before = sim.model.static_partner.copy()
    for place, partners in (((6.0, 5.0), (4, 1)), ((1.0, 1.0), (2, -1))):
        sim.state.pose[:, 1, :2] = place
        sim.place(np.array([1]))
        assert (sim.model.static_partner[two, 1] == partners[0]).all()
        assert (sim.model.static_partner[two, 4] == partners[1]).all()
    np.testing.assert_array_equal(sim.model.static_partner, before)
    assert len(two) > 0


def test_the_first_body_of_a_world_is_a_partner_like_any_other() -> None:
    discs = [{"shape": {"name": "circle", "radius": 0.6}, "state": [x, 1, 0]} for x in (1, 2)]
    sim = irsim_gym.compile(irsim_gym.load_scenario({"obstacle": discs}))
    sim.reset(seed=0)
    for _ in range(2):
        sim.step()
        assert sim.state.hit[0].tolist() == [1, 0]
        assert sim.state.collided[0, 0] == sim.state.collided[0, 1]
