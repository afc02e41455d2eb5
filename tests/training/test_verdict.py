"""What a training that hardly ever arrives is said to look like, and what to try."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.tasks import load_task
from irsim_gym.training.curves.verdict import failures, look_command, verdict

ROW = EpisodeRow(0, "timeout", "", 300, 30.0, 10.0, 12.0, 0.2)
STANDING = replace(ROW, path_length=0.2)
HIT = replace(ROW, outcome="collision", hit="moving obstacle", steps=40)
LOOK = "irsim-gym record ..."


def world(**task: Any) -> Scenario:
    robot = {"kinematics": {"name": "diff"}, "state": [1, 1, 0], "goal": [9, 9], "vel_max": [1, 1]}
    return load_scenario({"robot": robot, "obstacle": {"state": [5, 5, 0]}, "task": {"name": "navigation", **task}})


def point(rows: list[EpisodeRow], **others: float) -> dict[str, float]:
    """Return a point of the curve as scoring makes it: speed 1 m/s, limit 30 s."""
    shares = {
        name: sum(row.outcome == name for row in rows) / len(rows) for name in ("success", "collision", "timeout")
    }
    left = sum(row.outcome == "left_world" for row in rows) / len(rows)
    return {"steps": 2e6, **shares, "left_world": left, **failures(rows, [1.0] * len(rows), 30.0), **others}


def test_failures_are_counted() -> None:
    rows = [
        STANDING,
        replace(ROW, path_length=2.99),  # less than a quarter of 12 m
        replace(ROW, path_length=3.0),
        replace(ROW, path_length=0.0, optimum=float("inf")),  # nobody knows whether it had to move
        replace(ROW, optimum=30.1),
        replace(HIT, steps=1),
        replace(HIT, hit="map"),
        replace(ROW, outcome="success", path_length=0.1),
    ]
    found = {name: share * len(rows) for name, share in failures(rows, [1.0] * len(rows), 30.0).items() if share}
    assert found == {
        "stood_still": 2, "hit_at_once": 1, "no_way": 1, "too_far": 1, "hit_moving_obstacle": 1, "hit_map": 1
    }  # fmt: skip
    assert failures([replace(ROW, optimum=30.1)], [2.0], 30.0)["too_far"] == 0


@pytest.mark.parametrize(
    ("rows", "ends", "hint"),
    [
        ([STANDING] * 9 + [HIT], "90% stand still", "smaller weight of the reward collision (now 4)"),
        ([HIT] * 9 + [STANDING], "90% collide with a moving obstacle", "past_scans"),
        ([replace(ROW, outcome="left_world")] * 10, "100% leave the world", "a wall around the world"),
        ([ROW] * 10, "100% run out of time", "potential: geodesic"),
        ([replace(ROW, optimum=40.0)] * 10, "100% run out of time", "longer than max_steps (300) at full speed"),
        ([replace(ROW, optimum=float("inf"))] * 10, "100% run out of time", "reachable: true"),
        ([replace(HIT, steps=1, hit="map")] * 10, "100% collide with the map", "a larger `clearance`"),
    ],
)
def test_each_way_to_fail_has_its_words(rows: list[EpisodeRow], ends: str, hint: str) -> None:
    scenario = world()
    said = verdict(point(rows), scenario, load_task(scenario), LOOK)
    assert said[0].startswith(f"0.0% of episodes arrive. Of all episodes {ends}")
    assert any(hint in line for line in said[1:])
    assert said[-1] == f"  - look: {LOOK}"


def test_only_what_fails_gets_a_verdict() -> None:
    scenario = world()
    task = load_task(scenario)
    good = replace(ROW, outcome="success")
    assert verdict(point([good] + [ROW] * 9), scenario, task, LOOK) == []
    assert verdict({"success": 0.0, "steps": 1.0}, scenario, task, LOOK) == []  # a curve of an earlier version
    of_a_team = point([ROW] * 10, individual_success=0.6)
    assert verdict(of_a_team, scenario, task, LOOK) == []
    assert "1,000 are few" in "".join(verdict(point([ROW] * 10, steps=1e3), scenario, task, LOOK))


def test_a_blind_learner_is_told_so_first() -> None:
    scenario = world(observations=[{"name": name, "use": False} for name in ("scan", "free_travel")])
    said = verdict(point([STANDING] * 10), scenario, load_task(scenario), LOOK)
    assert "observes nothing of the obstacles" in said[2]


def test_the_command_to_look_at_it_shows_what_a_policy_does() -> None:
    told = look_command("quick_start", Path("runs/mine"), team=False)
    assert told == "irsim-gym record quick_start runs/mine --split dev --level 0 --level 1 --level 2 --html"
    told = look_command("quick_start", Path("runs/mine"), team=True, task="mine.yaml")
    assert told.endswith("--level 2 --team --task mine.yaml --html")
