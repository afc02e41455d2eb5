"""Discs in the cells of a map: behaviours take them as they take the same discs given as bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.bodies.behaviors.shared.map_parts import map_discs, most_map_discs, most_map_walls
from irsim_gym.evaluation.levels.density import covered_share

RADIUS = 0.3
RVO = {"behavior": {"name": "rvo", "neighbor_threshold": 2.5}}
ORCA = {"group_behavior": {"name": "orca", "timeHorizonObst": 2.0}}


def posts(rng: np.random.Generator) -> Any:
    """Return which of 10 x 10 cells are occupied, about one in six."""
    return rng.random((10, 10)) < 0.16


def scene(occupied: Any, robots: dict[str, Any], *, as_map: bool) -> Any:
    """Return the same posts as a map of discs, or as circles in the same order."""
    world: dict[str, Any] = {"width": 10, "height": 10}
    obstacles = []
    if as_map:
        world["obstacle_map"] = {"name": "array", "cells": occupied, "disc_radius": RADIUS}
    else:
        circle = {"shape": {"name": "circle", "radius": RADIUS}}
        obstacles = [{**circle, "state": [*place, 0]} for place in (np.argwhere(occupied) + 0.5).tolist()]
    data = {"world": world, "robot": robots, "obstacle": obstacles}
    sim = ig.compile(ig.load_scenario(data, warn=False), fused=False)
    sim.reset(seed=0)
    return sim


def crowd(rng: np.random.Generator, occupied: Any, count: int) -> dict[str, Any]:
    """Return robots that touch no post, each with its goal and a velocity."""
    states: list[list[float]] = []
    while len(states) < count:
        place = rng.uniform(0.3, 9.7, 2)
        away = np.hypot(*(np.argwhere(occupied) + 0.5 - place).T)
        if away.min(initial=9.0) > RADIUS + 0.2 and all(np.hypot(*(place - one[:2])) > 0.5 for one in states):
            states.append([*place, rng.uniform(-3, 3)])
    return {
        "number": count,
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": states,
        "goal": [[*goal, 0.0] for goal in rng.uniform(1, 9, (count, 2))],
        "vel_max": [1.0, 1.0],
    }


@pytest.mark.parametrize("behavior", [RVO, ORCA])
def test_they_are_avoided_as_circles_that_stand(behavior: dict[str, Any]) -> None:
    rng, deviations = np.random.default_rng(3), []
    for _ in range(4):
        occupied = posts(rng)
        robots = {**crowd(rng, occupied, 6), **behavior}
        sims = [scene(cells, robots, as_map=as_map) for cells, as_map in ((occupied, True), (occupied, False))]
        without = scene(np.zeros_like(occupied), robots, as_map=False)
        for _ in range(12):
            for sim in (*sims, without):
                sim.step()
            np.testing.assert_array_equal(sims[0].state.command[0, :6], sims[1].state.command[0, :6])
        deviations.append(np.abs(sims[0].state.pose[0, :6] - without.state.pose[0, :6]).max())
    assert min(deviations) > 0.05, "they are in the way"


def test_people_walk_around_one_as_around_a_round_wall() -> None:
    """A compound shape that stands is a wall for them, though all of it be a disc."""
    part = {"name": "circle", "radius": RADIUS}
    wall = {"shape": {"name": "compound", "parts": [part, part]}, "state": [4.5, 5.5, 0]}
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [2, 5.2, 0],
        "goal": [8, 5.6, 0],
        "behavior": {"name": "sfm"},
    }
    occupied = np.zeros((10, 10), np.bool_)
    occupied[4, 5] = True
    disc = {"name": "array", "cells": occupied, "disc_radius": RADIUS}
    paths = []
    for world, obstacles in (({"obstacle_map": disc}, []), ({}, [wall]), ({}, [])):
        data = {"world": {"width": 10, "height": 10, **world}, "robot": robot, "obstacle": obstacles}
        sim = ig.compile(ig.load_scenario(data, warn=False), fused=False)
        sim.reset(seed=0)
        path = []
        for _ in range(100):
            sim.step()
            path.append(sim.state.pose[0, 0, :2].copy())
        paths.append(np.array(path))
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-12)
    assert np.abs(paths[1] - paths[2])[:, 1].max() > 0.2, "it is in the way"
    assert paths[0][-1, 0] > 7.0


def test_people_pass_between_posts_where_whole_cells_leave_no_way() -> None:
    """Posts of 0.1 m in cells of 0.5 m, 1.5 m apart: in their middle they push to both sides, and to the rear."""
    occupied = np.zeros((20, 20), np.bool_)
    occupied[8, 2::3] = True
    robot = {
        "kinematics": {"name": "omni"},
        "shape": {"name": "circle", "radius": 0.2},
        "state": [2, 5, 0],
        "goal": [8, 5, 0],
        "behavior": {"name": "sfm"},
    }
    arrived = []
    for disc in ({"disc_radius": 0.05}, {}):
        world = {"width": 10, "height": 10, "obstacle_map": {"name": "array", "cells": occupied, **disc}}
        sim = ig.compile(ig.load_scenario({"world": world, "robot": robot}), fused=False)
        sim.reset(seed=0)
        for _ in range(180):
            sim.step()
        arrived.append(bool(sim.state.arrived[0, 0]))
        assert sim.state.pose[0, 0, 1] == pytest.approx(5.0, abs=0.01)
    assert arrived == [True, False]


def test_discs_near_a_point() -> None:
    """Centres nearer than 1.05 m, column by column; there is room for all, and no walls are left."""
    occupied = np.ones((10, 10), np.bool_)
    occupied[4, 6] = False
    size = {"width": 10, "height": 10}
    discs = {**size, "obstacle_map": {"name": "array", "cells": occupied, "disc_radius": RADIUS}}
    model = ig.compile(ig.load_scenario({"world": discs}, warn=False)).model
    found = np.zeros((most_map_discs(model, 1.05), 3))
    count = map_discs(model, 0, 4.4, 5.5, 1.05, found)
    assert found[:count].tolist() == [[3.5, 5.5, RADIUS], [4.5, 4.5, RADIUS], [4.5, 5.5, RADIUS]]
    assert map_discs(model, 0, 5.0, 5.0, 9.0, np.zeros((most_map_discs(model, 9.0), 3))) == 99
    assert most_map_walls(model, 9.0) == 0
    model = ig.compile(ig.load_scenario({"world": {**size, "obstacle_map": occupied}}, warn=False)).model
    assert most_map_discs(model, 9.0) == map_discs(model, 0, 5.0, 5.0, 9.0, np.zeros((0, 3))) == 0


def test_a_level_is_covered_by_the_discs() -> None:
    """17 discs in the world of 100 m2, and one that another body covers in part is not counted twice."""
    occupied = np.zeros((10, 10), np.bool_)
    occupied.flat[:85:5] = True
    world = {"width": 10, "height": 10, "obstacle_map": {"name": "array", "cells": occupied, "disc_radius": RADIUS}}
    box = {"shape": {"name": "rectangle", "length": 1, "width": 2}, "state": [0, 0.5, 0]}
    sim = ig.compile(ig.load_scenario({"world": world, "obstacle": [box]}, warn=False))
    sim.reset(seed=0)
    # The box holds the left half of the disc at (0.5, 0.5), and 0.5 m x 1.5 m of it lie in the world.
    expected = 16.5 * np.pi * RADIUS**2 + 0.5 * 1.5
    assert covered_share(sim.model, sim.state, 0) == pytest.approx(expected / 100.0, rel=1e-3)
