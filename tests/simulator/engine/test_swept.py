"""``collision_check: swept``: nothing passes what is thinner than a step is long, and who is stopped stays there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.base.kernels import record
from irsim_gym.errors import ScenarioError
from irsim_gym.simulator.engine import Shard, Simulation

THROUGH = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 10]]}}
"""A wall without thickness at x = 5."""
WALL = {"shape": {"name": "rectangle", "length": 0.05, "width": 10}, "state": [5, 5, 0]}
BOX = {"name": "rectangle", "length": 0.4, "width": 0.2}


def driving(**keys: Any) -> dict[str, Any]:
    """Return a disc of 0.2 m that drives 1.5 m in each step: at 1 m, at 2.5 m, at 4 m, and through the wall to 5.5."""
    return {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.2},
        "behavior": {"name": "dash"},
        "state": [1, 5, 0],
        "goal": [9, 5, 0],
        "vel_max": [3, 1],
        "vel_min": [-3, -1],
        "goal_threshold": 1.6,
    } | keys


def begun(*obstacles: Any, robot: Any = None, n_worlds: int = 1, **world: Any) -> Simulation:
    data = {
        "world": {"step_time": 0.5, "collision_check": "swept", **world},
        "robot": driving() if robot is None else robot,
        "obstacle": list(obstacles),
    }
    sim = ig.compile(ig.load_scenario(data, warn=False), n_worlds)
    sim.reset(seed=0)
    return sim


def after(sim: Simulation, n_steps: int) -> Simulation:
    for _ in range(n_steps):
        sim.step()
    return sim


@pytest.mark.parametrize(
    ("obstacle", "x"),
    [
        (THROUGH, 5 - 0.2),
        (WALL, 5 - 0.025 - 0.2),
        ({"shape": {"name": "circle", "radius": 0.1}, "state": [5, 5.1, 0]}, 5 - np.sqrt(0.3**2 - 0.1**2)),
        # A corner at (5, 5.12), which the disc touches with its upper side.
        (
            {"shape": {"name": "polygon", "vertices": [[5, 5.12], [5.1, 5.5], [4.9, 5.5]]}},
            5 - np.sqrt(0.2**2 - 0.12**2),
        ),
    ],
)
def test_a_disc_stops_where_it_touches(obstacle: dict[str, Any], x: float) -> None:
    sim = after(begun(obstacle), 3)
    assert sim.state.pose[0, 0].tolist() == [pytest.approx(x, abs=2e-9), 5, 0]
    assert sim.state.collided[0].all()
    assert sim.state.hit[0].tolist() == [1, 0]
    still = sim.state.pose.copy()
    np.testing.assert_array_equal(after(sim, 2).state.pose, still)


@pytest.mark.parametrize(("radius", "x"), [(None, 4.75 - 0.2), (0.1, 5 - 0.3)])
def test_cells_of_a_map_are_met(radius: float | None, x: float) -> None:
    # Twenty cells of 0.5 m a row; the occupied column reaches from 4.75 to 5.25, its discs stand at x = 5, y = 5, ...
    cells = np.zeros((20, 20), int)
    cells[9] = 100
    table: dict[str, Any] = {"name": "array", "cells": cells.tolist(), "disc_radius": radius}
    sim = after(begun(obstacle_map=table, offset=[0.25, 0.25], robot=driving(vel_max=[5, 1])), 2)
    assert sim.state.pose[0, 0, 0] == pytest.approx(x, abs=2e-9)
    assert sim.state.hit[0].tolist() == [1, 0]


def test_without_it_the_disc_passes() -> None:
    sim = after(begun(WALL, collision_check="step_end"), 3)
    assert sim.state.pose[0, 0, 0] == 5.5
    assert not sim.state.collided.any()


def test_two_that_pass_each_other_stop_where_they_meet() -> None:
    # After two steps they are at 4 and 6; they meet at 4.8 and 5.2, after 0.8 / 1.5 of the third.
    sim = after(begun(robot=[driving(), driving(state=[9, 5, np.pi], goal=[1, 5, 0])]), 3)
    assert sim.state.pose[0, :, 0].tolist() == pytest.approx([4.8, 5.2], abs=2e-9)
    assert sim.state.stopped.all()


def test_later_contacts_of_a_step_are_looked_for_from_where_bodies_stand() -> None:
    # One stops at a short wall, at 4.8. The other would pass beside the wall, but runs into the one.
    last = driving(state=[1, 5.3, 0], goal=[9, 5.3, 0], vel_max=[6, 1])
    first = driving(state=[3.5, 5, 0])
    sim = after(begun({"shape": {"name": "linestring", "vertices": [[5, 0], [5, 5.05]]}}, robot=[first, last]), 2)
    apart = np.sqrt(0.4**2 - 0.3**2)
    assert sim.state.pose[0, 0, 0] == pytest.approx(4.8, abs=2e-9)
    assert sim.state.pose[0, 1, 0] == pytest.approx(4.8 - apart, abs=3e-9)
    assert sim.state.hit[0].tolist() == [1, 0, 0]


@pytest.mark.parametrize("mode", ["unobstructed", "unobstructed_obstacles"])
def test_who_is_not_stopped_passes_and_is_told_of_the_contact(mode: str) -> None:
    mover = driving(state=[1, 5, 0])
    sim = after(begun(mover, WALL, robot=driving(state=[1, 2, 0], goal=[9, 2, 0]), collision_mode=mode), 3)
    stops = mode == "unobstructed_obstacles"
    assert sim.state.pose[0, :2, 0].tolist() == pytest.approx([4.775 if stops else 5.5, 5.5], abs=2e-9)
    assert sim.state.hit[0].tolist() == [2, 2, 0]
    assert sim.state.stopped[0].tolist() == [stops, False, False]
    assert after(sim, 1).state.collided[0].tolist() == [stops, False, stops]


def test_boxes_stop_within_a_millimetre_and_the_turn_counts() -> None:
    sim = after(begun(WALL, robot=driving(shape=BOX)), 3)
    assert sim.state.pose[0, 0, 0] == pytest.approx(5 - 0.025 - 0.2, abs=1e-3)
    # A bar of 2 m turns by 1 rad on the spot: its end meets the point at 0.5 rad, not at the end of the step.
    bar = driving(shape={"name": "rectangle", "length": 2, "width": 0.02}, kinematics={"name": "omni_angular"})
    bar |= {"state": [5, 5, 0], "vel_max": [1, 1, 2], "vel_min": [-1, -1, -2], "behavior": None}
    point = {"shape": {"name": "circle", "radius": 0.01}, "state": [5 + 0.9 * np.cos(0.5), 5 + 0.9 * np.sin(0.5), 0]}
    sim = begun(point, robot=bar)
    sim.step([0, 0, 2], bodies=[0])
    # Side and disc touch where the disc is 0.02 m from the bar's middle line.
    assert sim.state.pose[0, 0, 2] == pytest.approx(0.5 - np.arcsin(0.02 / 0.9), abs=1.5e-3)


def test_random_ways_end_at_the_first_contact() -> None:
    """The swept disc is the way widened by its radius, in shapely's arithmetic."""
    numbers, n_hits = np.random.default_rng(0), 0
    posts = [{"shape": {"name": "circle", "radius": r}, "state": [*numbers.uniform(2, 8, 2), 0]} for r in (0.05, 0.3)]
    bars = [
        {
            "shape": {"name": "rectangle", "length": 0.03, "width": 2},
            "state": numbers.uniform([2, 2, 0], [8, 8, 3]).tolist(),
        }
        for _ in range(4)
    ]
    walls = [{"shape": {"name": "linestring", "vertices": numbers.uniform(1, 9, (3, 2)).tolist()}} for _ in range(2)]
    robot = driving(kinematics={"name": "omni"}, vel_max=[20, 20], vel_min=[-20, -20], behavior=None)
    sim = begun(*posts, *bars, *walls, robot=robot, n_worlds=60, collision_mode="unobstructed_obstacles")
    sim.state.pose[:, 0, :2] = numbers.uniform(0, 10, (60, 2))
    sim.refresh()
    free, start = ~sim.state.collided[:, 0], sim.state.pose[:, 0, :2].copy()
    commands = numbers.uniform(-20, 20, (60, 1, 2))
    sim.step(np.concatenate([commands, np.zeros((60, 1, 1))], axis=2)[..., :2], bodies=[0])
    model, state = sim.model, sim.state
    lines = [shapely.LineString(rows.reshape(-1, 2)) for rows in state.segments[0]]
    things = shapely.union_all(
        [*lines, *(shapely.Point(x, y).buffer(r, quad_segs=400) for x, y, r in state.discs[0, 1:])]
    )
    for w in np.flatnonzero(free):
        way = shapely.LineString([start[w], start[w] + 0.5 * commands[w, 0]])
        ends = state.pose[w, 0, :2]
        if way.distance(things) > 0.2 + 1e-4:
            np.testing.assert_allclose(ends, way.coords[1])
        elif way.distance(things) < 0.2 - 1e-4:
            n_hits += 1
            assert state.collided[w, 0]
            assert shapely.Point(ends).distance(things) == pytest.approx(0.2, abs=1e-4)
            assert shapely.LineString([start[w], ends]).distance(things) > 0.2 - 1e-4
    assert n_hits > 20
    assert len(model.role) == 9


CROWD = {
    "number": 12,
    "kinematics": {"name": "omni"},
    "shape": {"name": "circle", "radius": 0.1},
    "vel_max": [6, 6],
    "vel_min": [-6, -6],
    "distribution": {"name": "random"},
    "behavior": {"name": "dash", "wander": True},
}


@pytest.mark.parametrize("mode", ["stop", "unobstructed_obstacles"])
def test_batches_threads_and_recorded_steps_agree(mode: str) -> None:
    boxes = {**CROWD, "number": 3, "shape": BOX, "kinematics": {"name": "diff"}, "vel_max": [6, 2], "vel_min": [-6, -2]}
    world = {"step_time": 0.2, "collision_check": "swept", "collision_mode": mode}
    scenario = ig.load_scenario({"world": world, "robot": CROWD, "obstacle": [WALL, boxes]}, warn=False)
    sims = [ig.compile(scenario, 6, num_threads=2), ig.compile(scenario, 6, fused=False), ig.compile(scenario, 1)]
    for sim, seed in zip(sims, (3, 3, 5), strict=True):
        sim.reset(seed=seed)
        after(sim, 25)
    assert sims[0]._advance.programs[0] is not None
    assert sims[0].state.collided.any()
    for name in ("pose", "collided", "hit", "stopped", "segments", "discs", "random"):
        whole = getattr(sims[0].state, name)
        np.testing.assert_array_equal(whole, getattr(sims[1].state, name))
        np.testing.assert_array_equal(whole[2:3], getattr(sims[2].state, name))


def test_a_step_without_it_makes_the_calls_that_it_made_before() -> None:
    def calls(sim: Simulation) -> list[str]:
        return [call[0].__name__ for call in record(sim.advance, Shard(np.zeros(1, np.int64)))]

    plain, swept = calls(begun(WALL, collision_check="step_end")), calls(begun(WALL))
    assert [name for name in swept if name not in ("note_starts", "sweep_worlds")] == plain
    assert len(swept) == len(plain) + 2


def test_it_needs_steps_that_move_bodies() -> None:
    with pytest.raises(ScenarioError, match="swept needs step_mode: internal"):
        begun(step_mode="external")
