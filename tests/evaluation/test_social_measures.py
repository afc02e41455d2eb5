"""How near a robot comes to people, against hand calculations."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.measures.metrics import EpisodeRow, summarize
from irsim_gym.evaluation.measures.people import time_to_contact
from irsim_gym.evaluation.protocol.figure_columns import summary_table
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.tables import table_text

TASK = {"name": "blank", "max_steps": 20, "observations": ["goal"], "rewards": ["progress"], "endings": ["collided"]}
PERSON = {"kinematics": {"name": "omni"}, "behavior": {"name": "dash"}}


def driven(**person: Any) -> EpisodeRow:
    """Drive 2 m along x at 1 m/s past a person who stands at (7, 5.6); both discs have a radius of 0.2 m."""
    robot = {"kinematics": {"name": "diff"}, "vel_max": [1, 1], "goal": [90, 5], "state": [5, 5, 0]}
    world = {"width": 100, "height": 100, "step_time": 0.1}
    other = {"state": [7, 5.6]} | person
    scenario = {"world": world, "robot": robot, "obstacle": other, "task": TASK}
    (row,) = evaluate(lambda seen: np.tile(np.float32([1.0, 0.0]), (len(seen), 1)), Worlds(scenario, 1).episodes, 1)
    return row


def test_intrusions_are_shares_of_steps() -> None:
    # After step k the gap is hypot(2 - 0.1 k, 0.6) - 0.4: below 0.25 m for k = 18, 19, 20, below 0.45 m from k = 14 on.
    row = driven(**PERSON)
    assert (row.intrusion_025, row.intrusion_045) == (3 / 20, 7 / 20)
    assert row.time_to_collision == math.inf  # 0.6 m aside, and 0.4 m for both radii
    head = table_text(summary_table([summarize("mine", [row])], "people"))
    assert "<.25 m" in head
    assert "15.0" in head


def test_walls_and_absent_people_are_none() -> None:
    for row in (driven(), driven(**PERSON, unobstructed=True)):  # an obstacle that stands; a body that touches nothing
        assert math.isnan(row.intrusion_025)
        assert math.isnan(row.time_to_collision)
    assert "<.25 m" not in table_text(summary_table([summarize("mine", [driven()])], "walls"))


def test_the_least_time_to_collision_is_kept() -> None:
    row = driven(**PERSON | {"state": [9, 5.2]})  # they would touch where x differs by sqrt(0.16 - 0.04)
    assert row.time_to_collision == pytest.approx(4.0 - 2.0 - math.sqrt(0.12))


@pytest.mark.parametrize(
    ("away", "speed", "time"),
    [
        ((3.0, 0.0), (-1.5, 0.0), 1.6),  # (3 - 0.6) / 1.5
        ((3.0, 0.0), (1.5, 0.0), math.inf),
        ((3.0, 0.0), (0.0, 0.0), math.inf),
        ((3.0, 0.7), (-1.0, 0.0), math.inf),  # passes 0.1 m aside
        ((0.5, 0.0), (1.0, 0.0), 0.0),  # touches already
        ((3.0, 0.0), (-0.2, 0.0), math.inf),  # in 12 s: beyond the horizon
    ],
)
def test_time_to_contact(away: tuple[float, float], speed: tuple[float, float], time: float) -> None:
    assert time_to_contact(np.array(away), np.array(speed), np.array(0.6)) == pytest.approx(time)
