"""Maps of ROS: how pixels are read, where the world is, what is refused, and maps written from levels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from command_line import run
from PIL import Image

from irsim_gym import load_scenario
from irsim_gym.errors import ScenarioError
from irsim_gym.evaluation.saved_policies.snapshot import take_snapshot
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.engine import compile

USUAL = {"resolution": 0.5, "origin": [-3.0, -2.0, 0.0], "occupied_thresh": 0.65, "free_thresh": 0.196, "negate": 0}


def write(folder: Path, pixels: Any, **changes: Any) -> str:
    """Write a map and its image, and return its file; None leaves a key out."""
    Image.fromarray(np.asarray(pixels, np.uint8)).save(folder / "floor.pgm")
    content = {"image": "floor.pgm", **USUAL, **changes}
    text = yaml.safe_dump({key: value for key, value in content.items() if value is not None})
    (folder / "map.yaml").write_text(text)
    return str(folder / "map.yaml")


def load(obstacle_map: Any, **world: Any) -> Scenario:
    return load_scenario({"world": {"obstacle_map": obstacle_map, **world}})


def cells(folder: Path, pixels: Any, unknown: str = "free", **changes: Any) -> Any:
    """Return the occupied cells of one row of pixels."""
    made = load({"name": "ros", "path": write(folder, [pixels], **changes), "unknown": unknown})
    assert made.occupied is not None
    return made.occupied[:, 0].astype(int).tolist()


def test_a_map_says_where_the_world_is(tmp_path: Path) -> None:
    """Black in the first pixel of the upper row, and in the last two of the lower one."""
    made = load(write(tmp_path, [[0, 254, 254], [254, 0, 0]]))
    assert (made.world.width, made.world.height, made.world.offset) == (1.5, 1.0, (-3.0, -2.0))
    assert made.occupied is not None
    assert made.occupied.tolist() == [[False, True], [True, False], [True, False]]


def test_a_map_stands_where_ros_has_it(tmp_path: Path) -> None:
    """From (0.25, 0.25), a wall of the cells from 0.5 to 1.0 m ahead is 0.25 m away."""
    write(tmp_path, [[254, 254, 0, 254]], origin=[-0.5, 0.0, 0.0])
    robot = {"kinematics": {"name": "diff"}, "state": [0.25, 0.25, 0], "goal": [0, 0.25], "shape": {"name": "circle"}}
    robot["shape"] = {"name": "circle", "radius": 0.1}
    robot["sensors"] = [{"name": "lidar2d", "number": 1}]
    scenario = load_scenario({"world": {"obstacle_map": str(tmp_path / "map.yaml")}, "robot": robot})
    simulation = compile(scenario, 1)
    simulation.reset(seed=0)
    found = simulation.scan(0)
    assert found is not None
    assert found[0].arrays["ranges"][0, 0, 0] == pytest.approx(0.25)


PIXELS = [0, 89, 90, 205, 206, 254]
"""Shares of black: 1, 0.651, 0.647, 0.19608, 0.192, 0.004."""


def test_trinary_pixels(tmp_path: Path) -> None:
    assert cells(tmp_path, PIXELS) == [1, 1, 0, 0, 0, 0]
    assert cells(tmp_path, PIXELS, "occupied") == [1, 1, 1, 1, 0, 0]


def test_negated_pixels(tmp_path: Path) -> None:
    """Shares of white: 0, 0.349, 0.353, 0.804, 0.808, 0.996."""
    for negate in (1, True):
        assert cells(tmp_path, PIXELS, "occupied", negate=negate) == [0, 1, 1, 1, 1, 1]
        assert cells(tmp_path, PIXELS, negate=negate) == [0, 0, 0, 1, 1, 1]


def test_scaled_pixels(tmp_path: Path) -> None:
    """From 0.2 to 0.8 the occupancy grows from 0 to 100: 127 and 128 are 50.3 % and 49.7 %."""
    how = {"mode": "scale", "free_thresh": 0.2, "occupied_thresh": 0.8}
    assert cells(tmp_path, [0, 127, 128, 254], "occupied", **how) == [1, 1, 0, 0]


def test_transparent_pixels_of_a_scaled_map_are_unknown(tmp_path: Path) -> None:
    write(tmp_path, [[0]], image="floor.png", mode="scale")
    Image.fromarray(np.array([[[128, 128, 128, 255], [128, 128, 128, 0]]], np.uint8)).save(tmp_path / "floor.png")
    for unknown, second in (("free", 0), ("occupied", 1)):
        made = load({"name": "ros", "path": str(tmp_path / "map.yaml"), "unknown": unknown})
        assert made.occupied is not None
        # (1 - 128/255 - 0.196) / (0.65 - 0.196) = 67 % where it is opaque.
        assert made.occupied[:, 0].astype(int).tolist() == [1, second]


def test_raw_pixels_are_occupancies(tmp_path: Path) -> None:
    assert cells(tmp_path, [0, 50, 51, 100, 101, 255], mode="raw") == [0, 0, 1, 1, 0, 0]
    assert cells(tmp_path, [0, 50, 51, 100, 101, 255], "occupied", mode="raw") == [0, 0, 1, 1, 1, 1]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"origin": [0.0, 0.0, 0.3]}, r"map\.yaml:\d origin: its yaw must be 0, got 0\.3: turn the image instead"),
        ({"origin": [0.0, 0.0]}, r"map\.yaml:\d origin: must be a list of 3 numbers"),
        ({"resolution": 0}, r"map\.yaml:\d resolution: must be > 0"),
        ({"resolution": None, "negate": 2}, r"map\.yaml:\d resolution: is required.*map\.yaml:\d negate: must be <= 1"),
        ({"free_thresh": 0.7}, r"map\.yaml:\d free_thresh: must not exceed occupied_thresh, 0\.65"),
        ({"mode": "scaled"}, r"map\.yaml:\d mode: must be .*scale"),
        ({"image": "none.pgm"}, r"none\.pgm is no image: no such file"),
        ({"image": "map.yaml"}, r"map\.yaml is no image: cannot identify"),
    ],
)
def test_a_broken_map_is_refused_with_its_line(tmp_path: Path, changes: dict[str, Any], words: str) -> None:
    file = write(tmp_path, [[0, 254]], **changes)
    with pytest.raises(ScenarioError, match=words) as error:
        load(file)
    assert error.value.problems[0].path.startswith("world.obstacle_map")


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text("- 1\n")
    with pytest.raises(ScenarioError, match="image: is required"):
        load(str(tmp_path / "map.yaml"))
    with pytest.raises(ScenarioError, match=r"no map 'none\.yaml'"):
        load("none.yaml")


def test_another_size_than_the_maps_is_refused(tmp_path: Path) -> None:
    file = write(tmp_path, [[0, 254]])
    assert load(file, width=1.0, height=0.5, offset=[-3, -2]).world.width == 1.0
    with pytest.raises(ScenarioError, match=r"world\.width: must be 1, as the map says: leave it out"):
        load(file, width=2.0)
    with pytest.raises(ScenarioError, match=r"world\.offset: must be .*-3.*-2.*, as the map says"):
        load(file, offset=[0, 0])


def test_a_copy_holds_the_map_and_its_image(tmp_path: Path) -> None:
    write(tmp_path, [[0, 254, 254], [254, 0, 0]])
    robot = {"kinematics": {"name": "diff"}, "state": [-2.75, -1.25, 0], "goal": [-2, -1]}
    robot["shape"] = {"name": "circle", "radius": 0.1}
    (tmp_path / "hall.yaml").write_text(yaml.safe_dump({"world": {"obstacle_map": "map.yaml"}, "robot": robot}))
    made = take_snapshot(str(tmp_path / "hall.yaml"), "navigation")
    made.write(tmp_path / "copy")
    (tmp_path / "map.yaml").unlink()
    (tmp_path / "floor.pgm").unlink()
    copy = load_scenario(str(tmp_path / "copy" / "hall.yaml"))
    assert copy.occupied is not None
    assert copy.occupied.tolist() == [[False, True], [True, False], [True, False]]
    assert copy.world.offset == (-3.0, -2.0)


def test_a_drawn_level_is_written_as_a_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells of 0.25 m are written as 5 x 5 of 0.05 m."""
    monkeypatch.chdir(tmp_path)
    hall = {"width": 6, "height": 4, "offset": [-1, 2], "obstacle_map": {"name": "cells", "resolution": 0.25}}
    scenario = {"world": hall}
    Path("hall.yaml").write_text(yaml.safe_dump(scenario))
    assert run(monkeypatch, "draw", "hall.yaml", "--level", "7", "--out", "map.yaml") == 0
    simulation = compile(load_scenario("hall.yaml"), 1)
    simulation.reset(seed=7, split="dev")
    drawn = simulation.model.map_squares[0, 0] == 0
    assert 0.05 < drawn.mean() < 0.95
    made = load("map.yaml")
    assert made.occupied is not None
    np.testing.assert_array_equal(made.occupied, np.kron(drawn, np.ones((5, 5), bool)))
    assert (made.world.width, made.world.height, made.world.offset) == (6.0, 4.0, (-1.0, 2.0))
    content = yaml.safe_load(Path("map.yaml").read_text())
    assert content["image"] == "map.pgm"
    assert content["resolution"] == pytest.approx(0.05)
    assert Path("map.pgm").read_bytes().startswith(b"P5")


def test_bodies_that_stand_are_part_of_a_written_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A square of 1 m covers 20 x 20 cells of 0.05 m, and touches those around it; robots are not part of the map."""
    monkeypatch.chdir(tmp_path)
    square = {"shape": {"name": "rectangle", "length": 0.99, "width": 0.99}, "state": [2.0, 1.0, 0.0]}
    robot = {"kinematics": {"name": "diff"}, "state": [0.5, 0.5, 0], "goal": [3, 0.5]}
    data = {"world": {"width": 4, "height": 2}, "robot": robot, "obstacle": square}
    Path("hall.yaml").write_text(yaml.safe_dump(data))
    assert run(monkeypatch, "draw", "hall.yaml", "--out", "map.yaml") == 0
    found = load("map.yaml").occupied
    assert found is not None
    expected = np.zeros((80, 40), bool)
    expected[30:50, 10:30] = True
    np.testing.assert_array_equal(found, expected)


def test_a_world_that_squares_do_not_fill_is_no_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hall.yaml").write_text(yaml.safe_dump({"world": {"width": 4, "height": 2.03}}))
    assert run(monkeypatch, "draw", "hall.yaml", "--out", "map.yaml") == 1
    assert "4 x 2.03 m cannot be filled with at most 4,000,000 squares of 0.05 m" in capsys.readouterr().err
    assert not Path("map.yaml").exists()
