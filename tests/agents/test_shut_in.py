"""agents/studies/shut_in.py: why robots run out of time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.tasks import Outcome

STUDIES = Path(__file__).parents[2] / "agents" / "studies"
CORRIDOR = [[100] * 3, *[[100, 0, 100]] * 6, [100] * 3]
ROBOT = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "goal": [6.5, 1.5]}


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import shut_in

    return shut_in


def corridor(*places: float) -> Worlds:
    """Return a corridor with robots that stand in it and want to its right end, before the first step."""
    world = {"height": 3, "width": 8, "obstacle_map": {"name": "array", "cells": CORRIDOR}}
    robots = [{**ROBOT, "state": [x, 1.5, 0]} for x in places]
    task = {"name": "blank", "observations": ["goal"], "endings": ["arrived"]}
    worlds = Worlds({"world": world, "robot": robots, "task": task}, 1, team=True)
    worlds.episodes.begin(np.arange(1), np.arange(1))
    return worlds


@pytest.mark.parametrize(
    ("outcomes", "driven", "reasons"),
    [
        ((Outcome.TIMEOUT, Outcome.SUCCESS), 0.0, {"shut in by robots that have ended": 1}),
        ((Outcome.TIMEOUT, Outcome.TIMEOUT), 0.0, {"shut in by robots on their way": 1, "a free way, stands": 1}),
        ((Outcome.SUCCESS, Outcome.TIMEOUT), 5.0, {"a free way, drives": 1}),
    ],
)
def test_the_reasons(script: Any, outcomes: tuple[Outcome, ...], driven: float, reasons: dict[str, int]) -> None:
    worlds = corridor(1.5, 3.5)
    worlds.episodes.state.outcome[0] = outcomes
    assert script.count(worlds, np.full((1, 2), driven)) == Counter(reasons)
