"""``wander_goals: {patience: ...}``: wandering bodies that hold each other go on after a while."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.simulator.engine import Simulation

WANDER = {"name": "dash", "wander": True, "range_low": [1, 1, 0], "range_high": [9, 9, 0]}
DISC = {"kinematics": {"name": "omni"}, "shape": {"name": "circle", "radius": 0.2}}


def begun(patience: float | None, *others: Any, n_worlds: int = 1, **world: Any) -> Simulation:
    """Return two wandering discs that overlap at the start, the first by itself patient."""
    goals = {} if patience is None else {"wander_goals": {"patience": patience}}
    first = {**DISC, "state": [2, 2, 0], "behavior": {**WANDER, **goals}}
    second = {**DISC, "state": [2.3, 2, 0], "behavior": WANDER}
    scenario = ig.load_scenario({"world": world, "obstacle": [first, second, *others]})
    sim = ig.compile(scenario, n_worlds)
    sim.reset(seed=1)
    return sim


@pytest.mark.parametrize("check", ["step_end", "swept"])
def test_held_bodies_go_on_with_another_goal(check: str) -> None:
    sim = begun(1.0, collision_check=check)
    sim.step()  # in which both may move, unless contacts are looked for at its start
    assert sim.state.stopped.all()
    goal, pose = sim.state.goal[0, 0].copy(), sim.state.pose[0].copy()
    for _ in range(8):
        sim.step()
    assert sim.state.stopped.all()
    np.testing.assert_array_equal(sim.state.pose[0], pose)
    np.testing.assert_array_equal(sim.state.goal[0, 0], goal)
    sim.step()  # the tenth, 1 s after the first that held them
    assert sim.state.stopped[0].tolist() == [False, True]
    assert not (sim.state.goal[0, 0] == goal).any(where=[True, True, False])
    for _ in range(10):
        sim.step()
    # Apart, both drive; the first may be held again, by its partner, for as long as before.
    assert not sim.state.collided.any()
    assert np.linalg.norm(sim.state.pose[0, 0, :2] - pose[0, :2]) > 0.5


def test_by_default_they_stand_for_good() -> None:
    sim = begun(None)
    for _ in range(200):
        sim.step()
    assert sim.state.stopped.all()
    assert sim.parts.patience is None


def test_what_cannot_move_holds_them() -> None:
    post = {"shape": {"name": "circle", "radius": 0.2}, "state": [2, 2.3, 0]}
    sim = begun(0.5, post)
    sim.state.pose[0, 1] = 8, 8, 0
    sim.refresh()
    for _ in range(50):
        sim.step()
    assert sim.state.hit[0].tolist() == [2, -1, 0]
    assert sim.state.stopped[0, 0]


def test_a_level_begins_with_all_of_the_patience() -> None:
    sim = begun(1.0)
    for _ in range(6):
        sim.step()
    sim.reset(seed=1)
    for _ in range(9):
        sim.step()
    assert sim.state.stopped.all()
    sim.step()
    assert not sim.state.stopped[0, 0]


def test_a_crowd_of_rvo_bodies_keeps_moving() -> None:
    """Without patience, 6 and 4 of these 24 stand after 25 s."""
    behavior = {**WANDER, "name": "rvo", "range_high": [5, 5, 0], "wander_goals": {"patience": 2}}
    crowd = {**DISC, "number": 24, "distribution": {"name": "random"}, "behavior": behavior}
    scenario = ig.load_scenario({"world": {"width": 6, "height": 6}, "obstacle": crowd})
    batch, single = ig.compile(scenario, 2, num_threads=2), ig.compile(scenario, 1, fused=False)
    batch.reset(seed=0)
    single.reset(seed=1)
    held, longest, still = np.zeros((2, 24)), 0.0, batch.state.pose[:, :, :2].copy()
    for step in range(250):
        batch.step()
        single.step()
        held = np.where(batch.state.stopped, held + 1, 0)
        longest = max(longest, held.max())
        if step == 120:
            still = batch.state.pose[:, :, :2].copy()
    np.testing.assert_array_equal(batch.state.pose[1], single.state.pose[0])
    assert longest == 19  # the step after the twentieth one moves them
    assert (np.linalg.norm(batch.state.pose[:, :, :2] - still, axis=2) > 0.1).all()
