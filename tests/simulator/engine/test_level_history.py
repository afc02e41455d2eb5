"""A level is the same after any other: whatever a file may leave out in a level is as the scenario gives it."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.simulator.world.outline import outline_rows
from irsim_gym.simulator.world.state import State

N_LEVELS, STEPS = 8, 4
LIDAR = {"name": "lidar2d", "number": 5, "range_max": 6}
DRAWN = {"distribution": {"name": "random"}, "shape": {"name": "circle", "radius": 0.1}}
DASH = {"name": "dash"}
AREA = {"range_low": [1, 1, -3], "range_high": [9, 9, 3]}
SCENARIO: dict[str, Any] = {
    "world": {"name": "history", "collision_mode": "unobstructed", "step_time": 0.2},
    "robot": [
        {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [9, 1], "sensors": [LIDAR], "behavior": DASH},
        {"kinematics": {"name": "diff"}, "state": [1, 3], "goal": [2, 3, 1], "behavior": {**DASH, "loop": True}},
        {"kinematics": {"name": "diff"}, "state": [1, 5], "goal": [9, 5],
         "behavior": {**DASH, **AREA, "wander": True, "wander_goals": {"keep_first": True, "interval": 1.0}}},
        {"kinematics": {"name": "diff"}, "distribution": {"name": "random", "goals": 2}, "behavior": DASH},
    ],
    "obstacle": [
        {**DRAWN, "kinematics": {"name": "diff"}, "behavior": {**DASH, "loop": True}, "number_range": [0, 2]},
        {"shape": {"name": "polygon", "random_shape": True}, "distribution": {"name": "random"}},
        {**DRAWN, "name": "post"},
    ],
    "task": {"agents": "robot_3"},
}  # fmt: skip
SCRATCH = {"direction", "segments", "discs", "room", "bucket", "bucket_first", "bucket_next", "nearby"}
"""Fields whose rows of absent bodies, or as a whole, mean nothing; ``outlines`` are the rows that do."""
OPTIONAL = ("robot_0", "robot_1", "robot_2")
"""Bodies whose goals a level may give or not."""


def levels_with_gaps() -> LevelSet:
    """Return drawn levels, to which each adds goals, headings of goals, and bodies at random, or does not."""
    drawn = draw_levels(ig.compile(ig.load_scenario(SCENARIO), 4), ["test"], N_LEVELS)
    rng = np.random.default_rng(3)
    start, goal = rng.uniform(1, 9, (2, N_LEVELS, len(OPTIONAL), 3))
    goals = np.full((*goal.shape[:2], drawn.goal.shape[2], 3), np.nan)
    goals[:, :, 0] = goal
    goals[rng.random(goals.shape[:2]) < 0.5] = np.nan
    goals[rng.random(goals.shape[:2]) < 0.3, :, 2] = np.nan
    more = {
        "bodies": (*OPTIONAL, *drawn.bodies),
        "start": np.concatenate([start, drawn.start], axis=1),
        "goal": np.concatenate([goals, drawn.goal], axis=1),
        "present": np.concatenate([np.ones(goals.shape[:2], np.bool_), drawn.present], axis=1),
    }
    for key in ("segment_start", "disc_start"):
        before = np.repeat(getattr(drawn, key)[:, :1], len(OPTIONAL), axis=1)
        more[key] = np.concatenate([before, getattr(drawn, key)], axis=1)
    changed = copy.copy(drawn)
    vars(changed).update(more)
    return changed


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("history") / "gaps.npz"
    path.write_bytes(levels_with_gaps().content())
    return path


def moment(sim: ig.Simulation, w: int) -> dict[str, Any]:
    """Return what differs between levels: the state, and what the model holds for each world."""
    found = {name: getattr(sim.state, name)[w].copy() for name in State.columns() if name not in SCRATCH}
    found["ranges"] = sim.sensors[0].arrays["ranges"][w].copy()
    found |= {name: getattr(sim.model, name)[w].copy() for name in ("present", "start", "waypoint_count")}
    here, count = np.flatnonzero(sim.model.present[w]), sim.model.waypoint_count[w]
    found["waypoints"] = [sim.model.waypoints[w, b, : count[b]].copy() for b in here]
    found["outlines"] = [[rows.copy() for rows in outline_rows(sim.model, sim.state, w, b)] for b in here]
    found["reach"] = sim.model.reach[w, here]
    return found


def test_levels_in_any_order_are_those_of_a_fresh_world(file: Path) -> None:
    scenario = ig.load_scenario({**SCENARIO, "levels": str(file)})
    fresh, played = ig.compile(scenario, N_LEVELS), ig.compile(scenario, 1)
    assert np.isnan(scenario.levels.goal[:, :3, 0, 0]).any()  # type: ignore[union-attr]
    fresh.reset(0, "test")
    expected = [[moment(fresh, w) for w in range(N_LEVELS)]]
    for _ in range(STEPS):
        fresh.step()
        expected.append([moment(fresh, w) for w in range(N_LEVELS)])
    rng = np.random.default_rng(0)
    for level in [*rng.permutation(N_LEVELS), *rng.permutation(N_LEVELS), *rng.permutation(N_LEVELS)]:
        played.reset(int(level), "test")
        for step in range(STEPS + 1):
            if step:
                played.step()
            for name, value in moment(played, 0).items():
                np.testing.assert_equal(value, expected[step][level][name], err_msg=f"level {level}: {name}")
