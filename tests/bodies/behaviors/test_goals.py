"""Which goal comes after which, for all drives (compared with ir-sim 2.12.0 where a run is long)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig

LOOP = {"name": "dash", "loop": True}


def simulation(**robot: Any) -> ig.Simulation:
    given = {"kinematics": {"name": "omni_angular"}, "state": [4, 5, 0.5], "behavior": LOOP}
    sim = ig.compile(ig.load_scenario({"robot": {**given, **robot}}))
    sim.reset(seed=0)
    return sim


def test_headings_do_not_matter_between_goal_and_start() -> None:
    # In IR-SIM such a body stops turning to the goal's heading once it goes back and forth.
    sim = simulation(goal=[4, 5, 2.0])
    assert sim.state.goal[0, 0].tolist() == [4, 5, 2]
    sim.step()
    sim.step()
    assert sim.state.goal[0, 0, :2].tolist() == [4, 5]
    assert np.isnan(sim.state.goal[0, 0, 2])


def test_headings_matter_where_they_do_on_arrival() -> None:
    sim = simulation(goal=[4, 5, 0.5], arrive_mode="state")
    sim.step()
    assert sim.state.arrived[0, 0]
    sim.step()
    assert sim.state.goal[0, 0].tolist() == [4, 5, 0.5]
    assert sim.model.waypoints[0, 0, 1].tolist() == [4, 5, 0.5]


def test_given_goals_keep_their_headings_in_a_loop() -> None:
    sim = simulation(goal=[[[4, 5, 0.5], [4, 5, 1.0]]])
    for _ in range(3):
        sim.step()
    assert sim.state.goal[0, 0].tolist() in ([4, 5, 0.5], [4, 5, 1.0])


# Steps after which ir-sim 2.12.0 goes on to the second goal and arrives at it (None: not within 100 steps).
ARRIVALS = {
    ("diff", "position", 0.3): (20, 43),
    ("diff", "state", 0.9): (14, 36),
    ("omni", "position", 0.3): (20, 42),
    ("omni", "state", 0.9): (14, None),
    ("omni_angular", "position", 0.3): (20, 42),
    ("omni_angular", "state", 0.9): (14, 35),
    ("acker", "position", 0.3): (20, 43),
    ("acker", "state", 0.9): (14, 36),
}


@pytest.mark.parametrize(("name", "mode", "threshold"), ARRIVALS)
def test_goals_are_reached_when_ir_sim_says(name: str, mode: str, threshold: float) -> None:
    sim = simulation(
        kinematics={"name": name, **({"frame": "body"} if name == "omni" else {})},
        shape={"name": "circle", "radius": 0.2, "wheelbase": 0.4},
        state=[2, 2, 0.3],
        goal=[[[4, 3, 0.5], [5, 5, 1.0]]],
        arrive_mode=mode,
        goal_threshold=threshold,
        behavior={"name": "dash"},
    )
    second, last = [], []
    for _ in range(100):
        sim.step()
        second.append(bool(sim.state.waypoint[0, 0]))
        last.append(bool(sim.state.arrived[0, 0]))
    found = second.index(True) + 1, last.index(True) + 1 if any(last) else None
    assert found == ARRIVALS[name, mode, threshold]


@pytest.mark.parametrize("distribution", ["circle", "random"])
def test_a_loop_goes_back_to_a_start_and_a_goal_that_were_drawn(distribution: str) -> None:
    """No entry gives a goal, and yet there are two: ir-sim 2.12.0 goes on to ``[goal, start]``."""
    robot = {"kinematics": {"name": "omni"}, "number": 2, "distribution": {"name": distribution}, "goal_threshold": 0.2}
    world = {"collision_mode": "unobstructed"}
    sim = ig.compile(ig.load_scenario({"world": world, "robot": {**robot, "behavior": LOOP, "vel_max": [3, 3]}}), 3)
    sim.reset(seed=1)
    goal, start = sim.model.waypoints[:, :, 0, :2].copy(), sim.model.start[:, :, :2].copy()
    np.testing.assert_array_equal(sim.model.waypoints[:, :, 1, :2], start)
    assert sim.model.waypoint_count.tolist() == [[2, 2]] * 3
    assert (np.linalg.norm(goal - start, axis=-1) > 0.2).all()
    back = np.zeros((3, 2), np.bool_)
    for _ in range(120):
        sim.step()
        heads_back = (sim.state.goal[:, :, :2] == start).all(axis=-1)
        assert (heads_back | (sim.state.goal[:, :, :2] == goal).all(axis=-1)).all()
        back |= heads_back
    assert back.all()


@pytest.mark.parametrize(
    "behavior", [LOOP, {"name": "dash", "wander": True, "range_low": [1, 1, 0], "range_high": [9, 9, 0]}]
)
def test_who_is_held_in_place_keeps_its_goal(behavior: dict[str, Any]) -> None:
    """IR-SIM neither asks a body that has stopped what it does nor gives it another goal."""
    robot = {"kinematics": {"name": "omni"}, "state": [2, 5, 0], "goal": [3, 5, 0], "behavior": behavior}
    stone = {"shape": {"name": "circle", "radius": 0.2}, "state": [8, 8, 0]}
    sim = ig.compile(ig.load_scenario({"robot": robot, "obstacle": stone}))
    sim.reset(seed=0)
    goal = sim.state.goal[0, 0].copy()
    sim.state.pose[0, :2] = [goal, [goal[0] + 0.3, goal[1], 0]]
    sim.place(np.arange(2))
    stream = sim.state.random.copy()
    for _ in range(3):
        sim.step()
        assert sim.state.stopped[0, 0]
        assert sim.state.arrived[0, 0]
        assert sim.state.goal[0, 0].tolist() == goal.tolist()
    np.testing.assert_array_equal(sim.state.random, stream)
