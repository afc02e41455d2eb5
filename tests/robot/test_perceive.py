"""``perceive.py``: ways worked out by hand, what it says at export and on the robot, and that it stands alone."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import messages
import numpy as np
import pytest
from command_line import run
from test_readme import blocks

from irsim_gym.robot.drive import Driver
from irsim_gym.robot.export import FILES, export_for_robot
from irsim_gym.robot.parts.perceive import SeenMap

AROUND = np.arange(8) * 0.25 * np.pi
NOTHING = np.full(8, np.inf, np.float32)


def empty_map(**changed: Any) -> SeenMap:
    """Return an empty map of 10 x 10 cells of 1 m for a robot of 0.4 m with eight beams, the first straight ahead."""
    form = {"origin": [0.0, 0.0], "cell": 1.0, "rows": 10, "columns": 10, "every": 1, "inflation": 0.4, "frees": False}
    scan = {"first": 0.0, "step": 0.25 * np.pi, "beams": 8, "range_min": 0.0, "range_max": 9.0, "mount": [0, 0, 0]}
    return SeenMap({"seen_map": {**form, **changed}, "scan": scan})


def ahead(distance: float) -> Any:
    """Return a scan of one hit, straight ahead [m]."""
    return np.where(np.arange(8) == 0, distance, np.inf).astype(np.float32)


def test_unknown_space_is_free() -> None:
    assert empty_map().way(NOTHING, np.array([2.5, 5.5, 0.0]), np.array([8.5, 5.5])).tolist() == [8.5, 5.5, 0.0]


def test_the_way_leads_around_what_was_hit() -> None:
    """Past cell (5, 5), by centres (3.5, 5.5), (4.5, 6.5), ..., (7.5, 6.5), the last in sight; then a diagonal step."""
    way = empty_map().way(ahead(2.7), np.array([2.5, 5.5, 0.0]), np.array([8.5, 5.5]))
    np.testing.assert_allclose(way, [7.5, 6.5, 1.4], rtol=1e-12)


def test_the_sensor_need_not_sit_at_the_robots_origin() -> None:
    moved = empty_map()
    moved.mount = [0.5, 0.0, 0.0]
    way = moved.way(ahead(2.2), np.array([2.5, 5.5, 0.0]), np.array([8.5, 5.5]))
    np.testing.assert_allclose(way, [7.5, 6.5, 1.4], rtol=1e-12)


def test_without_a_way_the_goal_is_infinitely_far() -> None:
    seen, goal = empty_map(), np.array([5.5, 5.5])
    seen.way(np.where(np.arange(8) % 2, np.sqrt(2.0), 1.0).astype(np.float32), np.array([5.5, 5.5, 0.0]), goal)
    assert seen.way(NOTHING, np.array([2.5, 5.5, 0.0]), goal).tolist() == [5.5, 5.5, np.inf]


@pytest.mark.parametrize(("frees", "place"), [(False, [7.5, 6.5, 1.4]), (True, [8.5, 5.5, 0.0])])
def test_a_hit_is_forgotten_only_where_others_move(frees: bool, place: list[float]) -> None:
    """The beams beside reach as far, so that the beam ahead frees what it passes."""
    seen, here, goal = empty_map(frees=frees), np.array([2.5, 5.5, 0.0]), np.array([8.5, 5.5])
    seen.way(ahead(2.7), here, goal)
    np.testing.assert_allclose(seen.way(NOTHING, here, goal), place, rtol=1e-12)


def test_scans_are_added_every_few_decisions_and_forgotten_with_the_rest() -> None:
    seen, here, goal = empty_map(every=2), np.array([2.5, 5.5, 0.0]), np.array([8.5, 5.5])
    lengths = [seen.way(ranges, here, goal)[2] for ranges in (NOTHING, ahead(2.7), ahead(2.7))]
    assert lengths == pytest.approx([0.0, 0.0, 1.4])
    seen.forget()
    assert seen.way(NOTHING, here, goal)[2] == 0.0


def test_large_maps_have_ways_too() -> None:
    """In 64 bits: a wall in column 150 but for row 1. From there, 2 straight steps, 49 diagonal and 230 straight."""
    seen = empty_map(rows=300, columns=300, inflation=0.1)
    for y in range(2, 299):
        seen.way(ahead(1.0), np.array([149.5, y + 0.5, 0.0]), np.array([140.5, y + 0.5]))
    x, y, length = seen.way(NOTHING, np.array([100.5, 280.5, 0.0]), np.array([200.5, 280.5]))
    assert (x, y) == (149.5, 1.5)
    assert length == pytest.approx((2 * 5 + 49 * 7 + 230 * 5) / 5)


@pytest.fixture(scope="module")
def maze(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("robot") / "maze"
    export_for_robot("maze", folder, levels=4)
    return folder


def test_an_export_with_a_map_holds_what_keeps_it(maze: Path) -> None:
    assert {file.name for file in maze.iterdir()} == {*FILES} - {"shield.py"}
    contract = json.loads((maze / "contract.json").read_text(encoding="utf-8"))
    form = contract["seen_map"]
    assert contract["inputs"]["way_on_seen_map"] == {"shape": ["batch", 3], "dtype": "float64"}
    assert (form["rows"], form["columns"], form["every"], form["frees"]) == (66, 66, 4, False)
    assert form["cell"] == pytest.approx(10.25 / 64)
    assert form["origin"] == pytest.approx([-10.25 / 64] * 2)
    assert form["inflation"] == pytest.approx(0.2)
    assert "Its map covers 10.2 x 10.2 m from (0, 0) on" in (maze / "README.md").read_text(encoding="utf-8")


def test_the_check_of_a_map_runs_where_the_package_is_not(maze: Path, tmp_path: Path) -> None:
    """An interpreter of its own runs the blocks of the card, and does not load the package."""
    code = "\n".join(block.text for block in blocks(maze / "README.md", "python"))
    script = tmp_path / "check.py"
    script.write_text(f"{code}\nimport sys\nassert 'irsim_gym' not in sys.modules\nprint(len(check['level']))\n")
    paths = {**os.environ, "PYTHONPATH": str(maze)}
    done = subprocess.run([sys.executable, script], cwd=maze, env=paths, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 100


def test_a_driver_stops_off_its_map(maze: Path, tmp_path: Path) -> None:
    folder = tmp_path / "moved"
    shutil.copytree(maze, folder)
    contract = json.loads((folder / "contract.json").read_text(encoding="utf-8"))
    contract["seen_map"]["origin"] = [20.0, 20.0]
    (folder / "contract.json").write_text(json.dumps(contract), encoding="utf-8")
    for place, reason in ((maze, ""), (folder, "the robot or its goal is off the map: see seen_map in the contract")):
        driver = Driver(place / "contract.json")
        driver.goal(messages.goal(3.5, 1.0))
        driver.scan(messages.scan(0.0, np.full(180, 6.0)))
        driver.odometry(messages.odometry(0.0, (1.0, 1.0, 0.0)))
        assert driver.tick(0.0)[2] == reason


def test_a_new_goal_begins_a_new_map(maze: Path) -> None:
    driver = Driver(maze / "contract.json")
    driver.goal(messages.goal(3.5, 1.0))
    driver.scan(messages.scan(0.0, np.full(180, 0.5)))
    driver.odometry(messages.odometry(0.0, (1.0, 1.0, 0.0)))
    assert driver.tick(0.0)[2] == ""
    assert driver.map.occupied.any()
    driver.goal(messages.goal(3.5, 1.0))
    assert driver.map.occupied.any()
    driver.goal(messages.goal(3.5, 3.0))
    assert not driver.map.occupied.any()


def test_the_command_says_that_it_is_not_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, "export", "bug_trap", "--out", tmp_path / "robot", "--levels", "1") == 0
    assert "not one file: way_on_seen_map" in capsys.readouterr().out
