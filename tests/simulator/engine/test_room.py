"""What is known of the room around the one body that moves spares tests of contact, and never hides one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym
from irsim_gym.simulator.engine import Simulation

N_WORLDS = 5


def begun(**world: Any) -> Simulation:
    """Return a disc that drives among two discs, a box and walls, 0.5 m and more away from all of them."""
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [2, 2, 0],
        "goal": [4, 4],
        "vel_min": [-2, -2],
        "vel_max": [2, 2],
    }
    obstacles = [
        {"shape": {"name": "circle", "radius": 0.5}, "state": [[3.2, 2], [0.8, 0.8]], "number": 2},
        {"shape": {"name": "rectangle", "length": 0.8, "width": 0.4}, "state": [2, 3.2, 0.4]},
        {"shape": {"name": "linestring", "vertices": [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]}, "state": [0, 0, 0]},
    ]
    data = {"world": world, "robot": robot, "obstacle": obstacles}
    sim = irsim_gym.compile(irsim_gym.load_scenario(data), n_worlds=N_WORLDS, agents=(0,))
    sim.reset(seed=0)
    return sim


def measured(sim: Simulation) -> Any:
    """Return the clearance of the robot in each world [m]."""
    distance = np.zeros((N_WORLDS, 1))
    sim.clearance(sim.shards.all[0], np.zeros(1, np.int64), distance)
    return distance[:, 0].copy()


def test_who_knows_the_room_sees_the_same_contacts() -> None:
    knowing, other = begun(collision_mode="unobstructed"), begun(collision_mode="unobstructed")
    rng, n_touching, n_known = np.random.default_rng(4), 0, 0
    for k in range(150):
        turning = 1.3 * np.array([np.cos(0.1 * k), np.sin(0.1 * k)])
        commands = turning + rng.uniform(-0.7, 0.7, (N_WORLDS, 1, 2))
        for sim in (knowing, other):
            sim.step(commands)
        np.testing.assert_array_equal(knowing.state.collided, other.state.collided)
        np.testing.assert_array_equal(knowing.state.hit, other.state.hit)
        n_touching += int(knowing.state.collided[:, 0].sum())
        n_known += int((knowing.state.room["gap"][:, 0] > 0.0).sum())
        assert (measured(knowing) == measured(other)).all()
        other.state.room["gap"] = 0.0
    assert min(n_touching, n_known) > 30


def test_the_room_around_a_disc() -> None:
    """The nearest is the disc at (3.2, 2), of radius 0.5: 1.2 - 0.5 - 0.2."""
    sim = begun()
    assert measured(sim) == pytest.approx(0.5)
    rooms = [[list(room) for room in rooms.tolist()] for rooms in sim.state.room]
    np.testing.assert_allclose(rooms, [[[2.0, 2.0, 0.5]] + [[0.0] * 3] * 4] * N_WORLDS)


@pytest.mark.parametrize("way", ["place", "refresh"])
def test_a_wall_that_is_put_down_beside_it_is_met(way: str) -> None:
    sim = begun()
    measured(sim)
    sim.state.pose[:, 2, :2] = 1.6, 1.6
    if way == "place":
        sim.place(np.array([2]))
        sim.step([0.0, 0.0])
    else:
        sim.refresh()
    assert sim.state.collided[:, [0, 2]].all()
    assert not sim.state.collided[:, 1].any()


def test_nothing_is_kept_where_others_move() -> None:
    data: dict[str, Any] = {
        "robot": [{"kinematics": {"name": "omni"}, "number": 2, "state": [[2, 2], [4, 2]], "goal": [[2, 2], [4, 2]]}]
    }
    sim = irsim_gym.compile(irsim_gym.load_scenario(data), n_worlds=N_WORLDS)
    sim.reset(seed=0)
    assert (measured(sim) > 1.0).all()
    assert (sim.state.room["gap"] == 0.0).all()
