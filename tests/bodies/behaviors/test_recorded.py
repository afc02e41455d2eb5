"""Recorded people: where they are at each step, when they are there, and files that cannot be read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import ScenarioError

ROWS = """# frame id x y
0 7 1.0 1.0
10 7 1.4 1.0
5,3,5.0,2.0
15 3 5.0 2.4
20 7 1.4 1.2
"""
OMNI = {"kinematics": {"name": "omni"}}


@pytest.fixture
def square(tmp_path: Path) -> Path:
    (tmp_path / "people.txt").write_text(ROWS, encoding="utf-8")
    return tmp_path


def simulation(folder: Path, n_worlds: int = 1, behavior: dict[str, Any] | None = None, **world: Any) -> ig.Simulation:
    replay = {"name": "recorded", "file": "people.txt", "time_unit": 0.04} | (behavior or {})
    number = 1 if "person" in replay else 2
    file = folder / "world.yaml"
    people = {"number": number, **OMNI, "behavior": replay}
    file.write_text(json.dumps({"world": world, "obstacle": people}), encoding="utf-8")
    sim = ig.compile(ig.load_scenario(file), n_worlds)
    sim.reset(seed=0)
    return sim


def test_people_walk_as_they_did(square: Path) -> None:
    # Frames at 25 Hz: person 7 is there from 0 to 0.8 s, person 3 from 0.2 to 0.6 s; straight lines between rows.
    sim = simulation(square)
    x = {0: 1.0, 1: 1.1, 2: 1.2, 3: 1.3, 4: 1.4, 5: 1.4, 6: 1.4, 7: 1.4, 8: 1.4}
    for step in range(12):
        present = sim.model.present[0].tolist()
        if step <= 8:
            expected = [x[step], 1.0 + max(step - 4, 0) * 0.05]
            assert sim.state.pose[0, 0, :2] == pytest.approx(expected), step
        if 2 <= step <= 6:
            assert sim.state.pose[0, 1, :2] == pytest.approx([5.0, 2.0 + (step - 2) * 0.1]), step
        assert present == [step <= 8, 2 <= step <= 6], step
        sim.step()


def test_a_body_that_decides_in_between_changes_nobody(square: Path) -> None:
    """A body that looks at others begins a turn of its own, so the recorded bodies decide in two parts."""
    replay = {"name": "recorded", "file": "people.txt", "time_unit": 0.04}
    watching = {**OMNI, "state": [9, 9, 0], "goal": [9, 5, 0], "behavior": {"name": "rvo"}}
    people = [{**OMNI, "behavior": replay | {"person": person}} for person in (7, 3)]
    file = square / "world.yaml"
    file.write_text(json.dumps({"obstacle": [people[0], watching, people[1]]}), encoding="utf-8")
    sim = ig.compile(ig.load_scenario(file))
    sim.reset(seed=0)
    for step in range(7):
        if step >= 2:
            assert sim.state.pose[0, 2, :2] == pytest.approx([5.0, 2.0 + (step - 2) * 0.1]), step
        sim.step()


def test_a_person_by_id_later_and_elsewhere(square: Path) -> None:
    behavior = {"person": 7, "start_time": 0.3, "offset": [2.0, -1.0]}
    sim = simulation(square, 2, behavior)
    for _ in range(2):
        assert sim.state.pose[1, 0, :2] == pytest.approx([3.3, 0.0])
        sim.step()
        assert sim.state.pose[1, 0, :2] == pytest.approx([3.4, 0.0])
        for _ in range(7):
            sim.step()
        assert not sim.model.present[:, 0].any()
        sim.reset_to_start()


def test_sensors_and_contacts_see_who_is_there(square: Path) -> None:
    scenario = {
        "robot": {**OMNI, "state": [3, 2, 0], "sensors": [{"name": "lidar2d", "number": 1, "range_max": 5}]},
        "obstacle": {**OMNI, "behavior": {"name": "recorded", "file": str(square / "people.txt"), "person": 3}},
    }
    scenario["obstacle"]["behavior"]["time_unit"] = 0.04
    sim = ig.compile(ig.load_scenario(scenario))
    sim.reset(seed=0)
    seen = []
    for _ in range(10):
        seen.append(float(sim.sensors[0].arrays["ranges"][0, 0, 0]))
        sim.step()
    assert [gap < 5 for gap in seen] == [step in (2, 3) for step in range(10)]  # then it has walked out of the beam
    assert seen[3] == pytest.approx(2.0 - np.sqrt(0.2**2 - 0.1**2), abs=1e-5)
    assert seen[2] == pytest.approx(1.8, abs=1e-5)


BAD = {
    "1 2 3": "line 1: must have 4 numbers, time, id, x, y, got 3",
    "0 1 2 3\n0.4 1 x 3": "line 2: must have 4 numbers, time, id, x, y, got '0.4 1 x 3'",
    "0 1.5 2 3": "line 1: must have finite numbers and a whole id",
    "0 1 2 3\n0 1 2 4": "line 2: person 1 is at two places at the time 0, see line 1",
    "# nothing": "holds no rows",
    "0 1 2 3\n1 1 4.5 3": "person 1 walks at up to 2.5 m/s, but vel_max and vel_min allow 1: give",
    "0 1 2 3\n9 1 2 3\n0 2 5 5": "the entry has 3 bodies, but there are 2 persons for them: number: 2",
}


@pytest.mark.parametrize("rows", BAD)
def test_bad_recordings_are_told_with_file_and_line(rows: str, tmp_path: Path) -> None:
    (tmp_path / "people.txt").write_text(rows, encoding="utf-8")
    file = tmp_path / "world.yaml"
    number = 3 if "number" in BAD[rows] else 1
    file.write_text(
        f"obstacle:\n  number: {number}\n  kinematics: {{name: omni}}\n"
        "  behavior:\n    name: recorded\n    file: people.txt\n",
        encoding="utf-8",
    )
    with pytest.raises(ScenarioError) as refused:
        ig.load_scenario(file)
    assert BAD[rows] in str(refused.value)
    assert "world.yaml" in str(refused.value)


def test_missing_files_and_persons(square: Path) -> None:
    for behavior, message in (
        ({"file": "sqare.txt"}, "no recording 'sqare.txt' (did you mean 'square.txt'?)"),
        ({"person": 4}, "people.txt has no person 4; it has 7, 3"),
    ):
        with pytest.raises(ScenarioError) as refused:
            simulation(square, behavior=behavior)
        assert message in str(refused.value)
