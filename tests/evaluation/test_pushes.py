"""Figures of pushing: work and delivered bodies, against values worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.measures.metrics import summarize
from irsim_gym.evaluation.protocol.protocol import evaluate

BOX = {"shape": {"name": "rectangle", "length": 0.8, "width": 0.8}, "state": [2.5, 4, 0], "mass": 0.5}
YARD: dict[str, Any] = {
    "world": {"name": "yard", "width": 12, "height": 5, "collision_mode": "contact"},
    "robot": {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.3},
        "state": [1, 4, 0],
        "vel_min": [-1, -1],
        "vel_max": [1, 1],
    },
    "obstacle": [{**BOX, "goal": [3.6, 4, 0]}, {**BOX, "state": [9, 1, 0], "goal": [9, 3, 0], "name": "far"}],
}


def ahead(observation: Any) -> np.ndarray:
    """Drive ahead at full speed."""
    return np.tile([1.0, 0.0], (len(observation), 1))


def row_of(*endings: Any, **yard: Any) -> Any:
    """Return the row of one episode of at most 25 steps."""
    task = {"name": "blank", "max_steps": 25, "observations": ["velocity"], "endings": endings}
    return evaluate(ahead, Worlds({**YARD, **yard}, 1, task=task).episodes, 1)[0]


def test_the_work_is_that_of_the_forces_along_the_way() -> None:
    row = row_of({"name": "bodies_arrived", "bodies": ["obstacle_1"]})
    # The robot drives at 1 m/s. In step 9 it moves the box by 0.04715 m: 0.5 kg * 4.715 m/s2 = 2.3575 N. Until step 10
    # friction stops it, and 0.1 m in a step takes 5 N, of which the wheels can press 4.905 N. From then on friction
    # takes 0.04905 m of each 0.1 m, which needs 2.4525 N, until the box is nearer than 0.1 m to its target in step 19.
    assert (row.outcome, row.steps) == ("success", 19)
    assert row.effort == pytest.approx(0.1 * (2.3575 + 4.905 + 9 * 2.4525), abs=1e-3)
    assert row.delivered == 1.0
    # Nobody heeds a goal: there is no way to compare its own with.
    assert row.spl == 1.0
    assert np.isnan(row.path_ratio)


def test_the_share_of_delivered_bodies_counts_those_that_lie_there_at_the_end() -> None:
    row = row_of("bodies_arrived")
    assert (row.outcome, row.delivered) == ("timeout", 0.0)  # pushed past its target by then
    area = row_of({"name": "bodies_arrived", "area": [3.0, 3, 6, 5]})
    assert (area.outcome, area.delivered) == ("timeout", 0.5)
    assert summarize("ahead", [row, area]).delivered == 0.25


def test_without_contacts_there_is_no_work_and_nothing_to_deliver() -> None:
    row = row_of(world={**YARD["world"], "collision_mode": "stop"})
    assert np.isnan(row.effort)
    assert np.isnan(row.delivered)
