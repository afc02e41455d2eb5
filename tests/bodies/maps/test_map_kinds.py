"""Cells from pictures, noise and numbers; expected grids from IR-SIM itself."""

from __future__ import annotations

import subprocess
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import irsim
import numpy as np
import pytest
from PIL import Image

from irsim_gym import load_scenario
from irsim_gym.bodies.maps.image import STRIP, read_dark
from irsim_gym.errors import ScenarioError
from irsim_gym.scenario.specs import library


def cells(obstacle_map: Any, **world: Any) -> Any:
    return load_scenario({"world": {"obstacle_map": obstacle_map, **world}}).occupied


def irsim_cells(folder: Path, obstacle_map: Any, **world: Any) -> Any:
    import yaml

    file = folder / "there.yaml"
    robot = [{"kinematics": {"name": "diff"}, "shape": {"name": "circle"}, "state": [0, 0, 0], "goal": [1, 1, 0]}]
    file.write_text(yaml.safe_dump({"world": {"obstacle_map": obstacle_map, **world}, "robot": robot}))
    env = irsim.make(str(file), headless=True, log_level="ERROR")
    grid = env._world.grid_map > 50
    env.end()
    return grid


def save(folder: Path, pixels: Any, name: str = "map.png", mode: str | None = None) -> str:
    image = Image.fromarray(np.asarray(pixels, np.uint8))
    (image.convert(mode) if mode else image).save(folder / name)
    return str(folder / name)


def test_orientation_of_a_picture(tmp_path: Path) -> None:
    # Dark in the top row's first pixel, and in the bottom row's last two.
    path = save(tmp_path, [[0, 255, 255], [255, 0, 0]])
    assert cells(path).tolist() == [[False, True], [True, False], [True, False]]


@pytest.mark.parametrize("mode", [None, "1", "L", "P", "LA", "RGBA"])
def test_pictures_are_read_as_in_ir_sim(tmp_path: Path, mode: str | None) -> None:
    pixels = np.random.default_rng(5).integers(0, 256, (7, 9, 3))
    path = save(tmp_path, pixels, mode=mode)
    for step in (1, 2, 3):
        expected = irsim_cells(tmp_path, path, mdownsample=step)
        assert np.array_equal(cells(path, mdownsample=step), expected)


def test_gray_thresholds(tmp_path: Path) -> None:
    path = save(tmp_path, [[126, 127, 128, 129]])
    assert cells(path).tolist() == [[True], [True], [False], [False]]
    assert np.array_equal(cells(path), irsim_cells(tmp_path, path))


@pytest.mark.parametrize(
    "options",
    [
        {"resolution": 0.25, "fill": 0.2, "seed": 0},
        {"resolution": 0.1, "seed": 7},
        {"resolution": 0.3, "complexity": 0.05, "fractal": 3, "attenuation": 0.8, "fill": 0.5, "seed": 12},
        {"resolution": 0.07, "complexity": 3.7, "fractal": 2, "fill": 0.9, "seed": 1},
    ],
)
def test_perlin_grids_are_those_of_ir_sim(tmp_path: Path, options: dict[str, Any]) -> None:
    spec = {"name": "perlin", **options}
    assert np.array_equal(cells(spec, width=10, height=7), irsim_cells(tmp_path, spec, width=10, height=7))


def test_perlin_without_a_seed_follows_from_the_name() -> None:
    spec = {"name": "perlin", "resolution": 0.5}
    one, same, other = (cells(spec, name=name) for name in ("one", "one", "other"))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_cells_as_numbers() -> None:
    assert cells([[0, 51, 50], [100, 0, 0]]).tolist() == [[False, True, False], [True, False, False]]
    assert cells(np.array([[True, False]])).tolist() == [[True, False]]
    assert cells({"name": "array", "cells": [[0, 100]]}).tolist() == [[False, True]]
    assert cells(np.full((400, 400), 100)).shape == (400, 400)


@pytest.mark.parametrize(
    ("obstacle_map", "message"),
    [
        ("hm3d_10.png", "shipped: cavern.png, floor_plan.png, warehouse.png"),
        ("caverns.png", "did you mean 'cavern.png'?"),
        ("nowhere.png", "no such file as given or beside the scenario; shipped: cavern.png"),
        ({"name": "perln", "resolution": 1}, "no obstacle map named 'perln' (did you mean 'perlin'?)"),
        ({"name": "perlin"}, "resolution: is required"),
        ({"name": "perlin", "resolution": 0.001}, "makes 10000 x 10000 cells, at most 4000000"),
        ({"name": "perlin", "resolution": 1, "fill": 2}, "fill: must be <= 1"),
        ([], "must be a table of numbers"),
        ([[1, 2], [3]], "must be columns of equal length"),
        ([[0, 1]], "contains only 0 and 1"),
        ([[0, 101]], "must be occupancies from 0 to 100"),
        (3, "must be the name of an image"),
    ],
)
def test_what_is_told(obstacle_map: Any, message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        cells(obstacle_map)
    assert message in str(error.value)
    assert "world.obstacle_map" in str(error.value)


def test_a_map_beside_the_scenario_and_its_line(tmp_path: Path) -> None:
    save(tmp_path, [[0, 255]], "here.png")
    (tmp_path / "text.png").write_text("no picture")
    for name in ("here.png", "text.png"):
        (tmp_path / "world.yaml").write_text(f"world:\n  width: 4\n  obstacle_map: {name}\n")
        if name == "here.png":
            assert load_scenario(tmp_path / "world.yaml").occupied.tolist() == [[True], [False]]
        else:
            with pytest.raises(ScenarioError, match=r"world.yaml:3 .*cannot be read as an image"):
                load_scenario(tmp_path / "world.yaml")


@pytest.mark.parametrize("name", ["cave.png", "hm3d_1.png", "hm3d_9.png"])
def test_maps_of_an_installed_ir_sim(name: str, tmp_path: Path) -> None:
    assert np.array_equal(cells(name, mdownsample=4), irsim_cells(tmp_path, name, mdownsample=4))


def test_ir_sims_maps_come_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "world.yaml").write_text("world: {obstacle_map: cave.png}")
    save(tmp_path, [[0, 255]], "cave.png")
    assert load_scenario(tmp_path / "world.yaml").occupied.tolist() == [[True], [False]]
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for name in ("cave.png", "hm3d_9.png"):
        with pytest.raises(ScenarioError, match=r"is not shipped here: install ir-sim, .*; shipped: cavern.png"):
            cells(name)


def test_looking_for_a_map_does_not_import_ir_sim() -> None:
    code = "import sys, irsim_gym as ig; ig.load_scenario({'world': {'obstacle_map': 'cave.png'}});"
    subprocess.run([sys.executable, "-c", code + "assert 'irsim' not in sys.modules"], check=True)


def test_shipped_maps_are_drawn_by_their_script() -> None:
    import importlib.util

    folder = library.configs_folder() / "maps"
    spec = importlib.util.spec_from_file_location("make_maps", folder / "make_maps.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    drawn = script.draw()
    assert set(drawn) == set(library.assets("maps"))
    for name, free in drawn.items():
        with Image.open(folder / name) as picture:
            assert np.array_equal(np.array(picture) > 127, free)
        assert np.array_equal(cells(name), np.fliplr(~free.T))
        assert np.array_equal(cells(name.removesuffix(".png")), np.fliplr(~free.T))


def test_a_picture_taller_than_a_strip_is_read_as_one(tmp_path: Path) -> None:
    pixels = np.random.default_rng(5).integers(0, 256, (2 * STRIP + 31, 40, 3), np.uint8)
    Image.fromarray(pixels).save(tmp_path / "tall.png")
    brightness = (pixels[..., 0] * 0.2989 + pixels[..., 1] * 0.587 + pixels[..., 2] * 0.114) / 255
    clear = np.abs(brightness - 0.5) > 1e-9  # rounding decides on the others
    dark = read_dark(tmp_path / "tall.png")
    np.testing.assert_array_equal(dark[clear], (brightness < 0.5)[clear])
    assert clear.mean() > 0.99


def test_a_large_picture_takes_little_memory(tmp_path: Path) -> None:
    """A pixel takes 4 bytes in colours and 1 in the map; brightness would take 32."""
    Image.new("RGB", (3000, 3000), "white").save(tmp_path / "large.png")
    tracemalloc.start()
    try:
        read_dark(tmp_path / "large.png")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 12 * 3000 * 3000
