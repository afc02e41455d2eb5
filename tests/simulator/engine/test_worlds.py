"""World w is the same whatever the batch, the threads and the order."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import irsim_gym as ig

FIELDS = ("pose", "velocity", "goal", "arrived", "collided", "hit", "random", "time")
COMMAND = [0.7, 0.4]


def rollout(n_worlds: int, seed: int, num_threads: int = 1, name: str = "cluttered_room") -> ig.Simulation:
    sim = ig.compile(ig.load_scenario(name), n_worlds, agents=(0,), num_threads=num_threads)
    sim.reset(seed=seed)
    for _ in range(40):
        sim.step(COMMAND)
    return sim


def outline_rows(sim: ig.Simulation, w: int) -> list[np.ndarray]:
    """Return the outline rows in use, body by body."""
    model, rows = sim.model, []
    for b in range(len(model.role)):
        start, count = model.segment_start[b], model.segment_count[w % len(model.segment_count), b]
        rows += [sim.state.segments[w, start : start + count], sim.state.discs[w, model.disc_start[b] :][:1]]
    return rows


def assert_same(sim: ig.Simulation, w: int, other: ig.Simulation, v: int) -> None:
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(sim.state, field)[w], getattr(other.state, field)[v], err_msg=field)
    for rows, others in zip(outline_rows(sim, w), outline_rows(other, v), strict=True):
        np.testing.assert_array_equal(rows, others)
    ranges, others = sim.sensors[0].arrays["ranges"], other.sensors[0].arrays["ranges"]
    np.testing.assert_array_equal(ranges[w], others[v])


def test_a_world_of_a_batch_is_a_single_world() -> None:
    batch = rollout(6, seed=3)
    for w in range(6):
        assert_same(batch, w, rollout(1, seed=3 + w), 0)


@pytest.mark.parametrize("num_threads", [2, 3])
def test_threads_change_nothing(num_threads: int) -> None:
    serial, threaded = rollout(7, seed=1), rollout(7, seed=1, num_threads=num_threads)
    for w in range(7):
        assert_same(serial, w, threaded, w)


def test_restarting_some_worlds_leaves_the_others_alone() -> None:
    sim, twin = rollout(5, seed=2), rollout(5, seed=2)
    streams = np.arange(5, dtype=np.uint64)
    sim.run(lambda shard: sim.begin(shard, streams), np.array([1, 3]))
    for w in (0, 2, 4):
        assert_same(sim, w, twin, w)
    assert sim.state.step.tolist() == [40, 0, 40, 0, 40]


def test_a_level_does_not_depend_on_what_came_before() -> None:
    fresh = rollout(3, seed=11)
    used = rollout(3, seed=0)
    used.reset(seed=11)
    for _ in range(40):
        used.step(COMMAND)
    for w in range(3):
        assert_same(fresh, w, used, w)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))])
def test_copies_go_on_identically(copied: object) -> None:
    sim = rollout(4, seed=5, num_threads=2)
    twin = copied(sim)  # type: ignore[operator]
    for _ in range(20):
        sim.step(COMMAND)
        twin.step(COMMAND)
    for w in range(4):
        assert_same(sim, w, twin, w)


def test_splits_share_no_level() -> None:
    sim = ig.compile(ig.load_scenario("cluttered_room"), 50)
    starts = {}
    for split in ("train", "dev", "test"):
        sim.reset(seed=0, split=split)
        starts[split] = {tuple(pose) for pose in sim.state.pose[:, 0]}
    assert all(len(found) == 50 for found in starts.values())
    assert not starts["train"] & starts["dev"]
    assert not starts["train"] & starts["test"]
    assert not starts["dev"] & starts["test"]


@pytest.mark.parametrize(("n_worlds", "num_threads"), [(0, 1), (1, 0)])
def test_senseless_sizes_are_refused(n_worlds: int, num_threads: int) -> None:
    with pytest.raises(ValueError, match=">= 1, got"):
        ig.compile(ig.load_scenario("empty_goal"), n_worlds, num_threads=num_threads)


def test_without_a_seed_the_first_level_begins() -> None:
    robot = {"kinematics": {"name": "diff"}, "distribution": {"name": "random"}}
    seen = []
    for given in ({}, {"seed": 0}, {"seed": 0, "split": "train", "episode": 0}, {"seed": 1}):
        simulation = ig.compile(ig.load_scenario({"world": {"name": "first"}, "robot": robot}))
        simulation.reset(**given)
        seen.append(simulation.state.pose[0, 0].tolist())
    assert seen[0] == seen[1] == seen[2] != seen[3]
