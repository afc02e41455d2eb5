"""Buckets: near bodies are found, whatever moves where, and contacts are those of all pairs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.geometry.buckets import find_nearby, put_in_order, square_of
from irsim_gym.simulator.step import outlines
from irsim_gym.simulator.world.group import Shard

WORLDS = Shard(np.arange(2, dtype=np.int64))


def crowd(n_robots: int = 50, n_obstacles: int = 30, **world: Any) -> Any:
    """Two worlds of small bodies, a long wall, a large box, and an obstacle that nobody touches."""
    data = {
        "world": {"width": 12, "height": 8, "offset": [-3, 2], **world},
        "robot": {
            "number": n_robots,
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "distribution": {"name": "manual"},
            "state": [0, 0, 0],
        },
        "obstacle": [
            {
                "number_range": [n_obstacles // 2, n_obstacles],
                "shape": {"name": "rectangle", "length": 0.5, "width": 0.3},
                "distribution": {"name": "random"},
            },
            {"shape": {"name": "linestring", "vertices": [[-3, 2], [9, 10]]}},
            {"shape": {"name": "rectangle", "length": 4, "width": 3}, "state": [6, 4, 0.3]},
            {"shape": {"name": "circle", "radius": 0.3}, "state": [1, 3], "unobstructed": True},
        ],
    }
    return ig.compile(ig.load_scenario(data), 2)


def scatter(sim: Any, rng: np.random.Generator, spread: float) -> None:
    """Put all small bodies somewhere, within the world or around it."""
    small = np.flatnonzero(sim.model.bucketed)
    sim.state.pose[:, small] = rng.uniform([-3, 2, -np.pi], [9, 10, np.pi], (2, len(small), 3))
    sim.state.pose[:, small, :2] += rng.normal(0.0, spread, (2, len(small), 2))
    everyone = sim.parts.everyone
    outlines.place(everyone, sim.model, sim.state, WORLDS)
    body_buckets.refresh(everyone, sim.model, sim.state, WORLDS)


def begun(**world: Any) -> tuple[Any, np.random.Generator]:
    sim, rng = crowd(**world), np.random.default_rng(3)
    sim.model.present[:, rng.choice(50, 9, replace=False)] = False
    body_buckets.empty(sim.model, sim.state, WORLDS)
    return sim, rng


def test_few_bodies_have_no_buckets() -> None:
    sim = crowd(n_robots=10, n_obstacles=4)
    assert sim.model.bucket_frame[0].columns == 0
    found = np.zeros(len(sim.model.role), np.int64)
    count = find_nearby(
        0.0, 0.0, 0.1, sim.model.bucket_frame[0], sim.state.bucket_first[0], sim.state.bucket_next[0], found
    )
    assert found[:count].tolist() == list(range(len(sim.model.role)))


@pytest.mark.parametrize(("width", "height", "most"), [(12, 8, 1.5), (1000, 2, 2), (2, 1000, 2)])
def test_squares_cover_the_world(width: float, height: float, most: float) -> None:
    sim = crowd(width=width, height=height)
    x, y, side, columns, rows, _ = sim.model.bucket_frame[0]
    n_bodies = len(sim.model.role)
    assert (x, y) == (-3, 2)
    assert columns * side >= width
    assert rows * side >= height
    assert n_bodies / most <= columns * rows <= n_bodies


def test_large_bodies_stay_out_of_the_squares() -> None:
    sim = crowd()
    n_bodies = len(sim.model.role)
    assert np.flatnonzero(~sim.model.bucketed).tolist() == [n_bodies - 3, n_bodies - 2]


@pytest.mark.parametrize("spread", [0.0, 2.0, 30.0])
def test_all_bodies_within_a_radius_are_found(spread: float) -> None:
    sim, rng = begun()
    model, state = sim.model, sim.state
    found = np.zeros(len(model.role), np.int64)
    for _ in range(8):
        scatter(sim, rng, spread)
        for w in range(2):
            for x, y, radius in rng.uniform([-9, -4, 0], [15, 16, 4], (12, 3)):
                count = find_nearby(
                    x, y, radius, model.bucket_frame[0], state.bucket_first[w], state.bucket_next[w], found
                )
                got = found[:count]
                assert (np.diff(got) > 0).all(), "ascending, each once"
                assert model.present[w, got].all()
                near = np.hypot(state.pose[w, :, 0] - x, state.pose[w, :, 1] - y) <= radius
                assert set(np.flatnonzero(model.present[w] & (near | ~model.bucketed))) <= set(got.tolist())


def test_a_small_search_looks_at_few_bodies() -> None:
    sim, rng = begun()
    scatter(sim, rng, 0.0)
    found = np.zeros(len(sim.model.role), np.int64)
    frame, state = sim.model.bucket_frame[0], sim.state
    counts = [
        find_nearby(x, y, 0.5, frame, state.bucket_first[0], state.bucket_next[0], found)
        for x, y in rng.uniform([-3, 2], [9, 10], (20, 2))
    ]
    assert np.mean(counts) < len(found) / 4


def test_an_absent_body_leaves_its_bucket() -> None:
    sim, rng = begun()
    scatter(sim, rng, 0.0)
    sim.model.present[0, 5] = False
    body_buckets.refresh(np.array([5], np.int64), sim.model, sim.state, WORLDS)
    assert sim.state.bucket[0, 5] == -1
    found = np.zeros(len(sim.model.role), np.int64)
    count = find_nearby(
        3.0, 6.0, 99.0, sim.model.bucket_frame[0], sim.state.bucket_first[0], sim.state.bucket_next[0], found
    )
    assert found[:count].tolist() == np.flatnonzero(sim.model.present[0]).tolist()


@pytest.mark.parametrize(("spread", "least"), [(0.0, 300), (1.0, 150), (20.0, 10)])
def test_contacts_through_buckets_are_those_of_all_pairs(spread: float, least: int) -> None:
    sim, rng = begun(collision_mode="unobstructed")
    model, state = sim.model, sim.state
    frame = model.bucket_frame.copy()
    n_touching = 0
    for _ in range(6):
        scatter(sim, rng, spread)
        results = []
        for columns in (frame[0].columns, 0):
            model.bucket_frame["columns"] = columns
            contact.find_static(sim.parts.fixed, model, state, WORLDS)
            contact.find(sim.parts.movers, model, state, WORLDS)
            results.append([a.copy() for a in (model.static_partner, state.collided, state.hit, state.stopped)])
        model.bucket_frame[:] = frame
        for near, every in zip(*results, strict=True):
            np.testing.assert_array_equal(near, every)
        n_touching += int(results[0][1].sum())
    assert n_touching > least


@pytest.mark.parametrize("spread", [0.0, 2.0, 30.0])
@pytest.mark.parametrize("limit", [np.inf, 0.7, 0.0])
def test_clearances_through_buckets_are_those_of_all_pairs(spread: float, limit: float) -> None:
    sim, rng = begun()
    model, everyone = sim.model, sim.parts.everyone
    frame = model.bucket_frame.copy()
    for alone in (False, True):
        model.present[:] = model.present & (not alone)
        model.present[:, 5] = True
        scatter(sim, rng, spread)
        near, every = np.zeros((2, len(everyone))), np.zeros((2, len(everyone)))
        sim.clearance(WORLDS, everyone, near, limit)
        model.bucket_frame["columns"] = 0
        sim.clearance(WORLDS, everyone, every, limit)
        model.bucket_frame[:] = frame
        np.testing.assert_array_equal(near, every)
        assert (near[:, 5] == limit).all() or not alone
        assert len(np.unique(near)) > 50 or limit < 1.0 or alone


def test_a_step_keeps_the_buckets_up_to_date() -> None:
    robot = {
        "number": 70,
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.1},
        "vel_max": [3, 1],
        "behavior": {"name": "dash"},
        "distribution": {"name": "circle"},
    }
    world = {"width": 20, "height": 20, "collision_mode": "unobstructed"}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": robot}, warn=False))
    sim.reset(seed=1)
    for _ in range(30):
        sim.step()
    state, model = sim.state, sim.model
    x, y, side, columns, _, _ = model.bucket_frame[0]
    place = np.floor((state.pose[0, :, 1] - y) / side) * columns + np.floor((state.pose[0, :, 0] - x) / side)
    inside = ((state.pose[0, :, :2] > 0.1) & (state.pose[0, :, :2] < 19.9)).all(axis=1)
    assert inside.sum() > 50
    np.testing.assert_array_equal(state.bucket[0, inside], place[inside])


@pytest.mark.parametrize("count", [0, 1, 2, 3, 10, 47, 300])
def test_numbers_are_put_in_order(count: int) -> None:
    numbers = np.random.default_rng(count).integers(-50, 50, 310)
    before = numbers.copy()
    put_in_order(numbers, count)
    assert numbers.tolist() == [*sorted(before[:count].tolist()), *before[count:].tolist()]


def test_no_coordinate_leads_out_of_the_squares() -> None:
    places = [square_of(value, -1.0, 0.5, 4) for value in (-np.inf, -1.0, 0.4, 0.99, 1e300, np.inf, np.nan)]
    assert places == [0, 0, 2, 3, 3, 3, 0]
