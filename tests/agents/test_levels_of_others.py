"""Levels of others: scripts convert small made files, and the collections in ../shared/data where they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.levels import LevelSet

STUDIES = Path(__file__).parents[2] / "agents" / "studies"
DATA = Path(__file__).parents[3] / "shared" / "data"
WORLD = """<sdf version='1.6'><world name='default'>
<model name='ground_plane'><link><collision><geometry><plane/></geometry></collision></link></model>
{}<state><model name='unit_cylinder_0'><pose>9 9 0 0 0 0</pose></model></state></world></sdf>"""
CYLINDER = """<model name='unit_cylinder_{}'><pose frame=''>{} {} 0 0 0 0</pose><link><collision><geometry>
<cylinder><radius>{}</radius><length>1</length></cylinder></geometry></collision></link></model>"""
NAV = {
    "cells": np.zeros((2, 3, 4), np.uint8), "start_xy": np.full((2, 1, 2), 1.5, np.float32),
    "start_heading": np.array([[0.5], [3.5]], np.float32),
    "goal_xy": np.array([[[2.5, 0.5]], [[3.5, 1.5]]], np.float32),
}  # fmt: skip
NAV["cells"][0, 2, 3] = 1  # y = 2.5, x = 3.5


def shared(name: str) -> Path:
    file = next((folder / name for folder in (DATA, Path("/work/shared/data")) if (folder / name).is_file()), None)
    if file is None:
        pytest.skip(f"{name} is not here")
    return file


@pytest.fixture(autouse=True)
def scripts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(STUDIES))


def written(arrays: dict[str, Any], file: Path) -> LevelSet:
    """Levels as a script writes them and the package reads them."""
    from irsim_gym.scenario.reading.level_reading import read_levels

    np.savez_compressed(file, **arrays)
    return read_levels(file)


def barn(copy: Path, file: Path) -> LevelSet:
    from barn_levels import barn_levels

    return written(barn_levels(copy), file)


def jaxnav(arrays: dict[str, Any], file: Path) -> LevelSet:
    from jaxnav_pickle import levels_of

    return written(levels_of(arrays, "nav.pkl"), file)


def test_barn_folders_are_read_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    def write(number: int, *cylinders: tuple[float, float, float]) -> None:
        models = [CYLINDER.format(i, *cylinder) for i, cylinder in enumerate(cylinders)]
        (tmp_path / f"world_{number}.world").write_text(WORLD.format("".join(models)))

    write(10, (-4.425, 0.075, 0.075))
    write(2, (-2.175, 5.0249999, 0.075), (-0.075, 9.525, 0.075))
    file = tmp_path / "levels.npz"
    levels = barn(tmp_path, file)
    assert [np.argwhere(cells).tolist() for cells in levels.cells] == [[[15, 33], [29, 63]], [[0, 0]]]
    sim = ig.compile(ig.load_scenario(file), 2)  # of the benchmark that it names
    sim.reset(0)
    assert sim.state.pose[:, 0].tolist() == [[-2.25, 3.0, np.pi / 2]] * 2
    assert sim.state.goal[1, 0, :2].tolist() == [-2.25, 13.0]
    ahead = sim.sensors[0].arrays["ranges"][0, 0, 300:420]
    # World 2: from 0.065 m behind (-2.25, 3), the post at (-2.175, 5.025) is ahead and a little to the right.
    assert ahead.min() == pytest.approx(np.hypot(0.075, 2.09) - 0.075, abs=1e-3)
    for name, cylinder, told in (
        ("5", (-2.0, 3.075, 0.075), r"\(-2, 3.075\)"),
        ("6", (-2.025, 3.075, 0.175), "0.175 at"),
        ("7", (-2.025, 13.575, 0.075), "13.575"),
    ):
        write(int(name), cylinder)
        with pytest.raises(SystemExit, match=f"world_{name}.world: cylinders must .*{told}"):
            barn(tmp_path, file)
        (tmp_path / f"world_{name}.world").unlink()
    for content, told in (("<sdf>", "cannot be read as a Gazebo world"), (WORLD.format(""), "holds no cylinder")):
        (tmp_path / "world_3.world").write_text(content)
        with pytest.raises(SystemExit, match=f"world_3.world {told}"):
            barn(tmp_path, file)
    np.savez(tmp_path / "barn.npz", cylinder_xy=np.zeros((4, 2)), world_start=[0, 3, 9])
    with pytest.raises(SystemExit, match="world_start must rise from 0 to the number of cylinders, 4"):
        barn(tmp_path / "barn.npz", file)


def test_jaxnav_arrays_become_levels(tmp_path: Path) -> None:
    levels = jaxnav(NAV, tmp_path / "levels.npz")
    assert levels.bodies == ("robot_0",)
    assert "scenario" not in levels.about, "these maps are smaller than the benchmark's"
    assert np.argwhere(levels.cells).tolist() == [[0, 3, 2]]
    assert levels.start[:, 0] == pytest.approx(np.array([[1.5, 1.5, 0.5], [1.5, 1.5, 3.5 - 2 * np.pi]]), abs=1e-6)
    assert levels.goal[1, 0, 0, :2].tolist() == [3.5, 1.5]
    assert np.isnan(levels.goal[..., 2]).all()


def test_the_published_levels_of_jaxnav(tmp_path: Path) -> None:
    levels = jaxnav(dict(np.load(shared("jaxnav_four_1000.npz"))), tmp_path / "four.npz")
    assert (levels.count, levels.bodies) == (1000, ("robot_0", "robot_1", "robot_2", "robot_3"))
    for ends in (levels.start, levels.goal[:, :, 0]):
        column, row = np.moveaxis(np.floor(ends[..., :2]).astype(int), 2, 0)
        assert not levels.cells[np.arange(1000)[:, None], column, row].any()
    assert levels.about["scenario"] == "jaxnav_four"
    data = {
        "world": {"width": 11, "height": 11, "obstacle_map": {"name": "cells"}}, "levels": str(tmp_path / "four.npz"),
        "robot": {"number": 4, "kinematics": {"name": "diff"}, "distribution": {"name": "cells"},
                  "shape": {"name": "rectangle", "length": 0.5, "width": 0.5}},
    }  # fmt: skip
    sim = ig.compile(ig.load_scenario(data), 2)
    sim.reset(7)
    assert sim.state.pose[1, :4] == pytest.approx(levels.start[8])
    assert (sim.model.map_squares[1, 0] == 0).tolist() == levels.cells[8].tolist()


def test_the_worlds_of_barn(tmp_path: Path) -> None:
    levels = barn(shared("barn_worlds.npz"), tmp_path / "barn.npz")
    assert levels.count == 300
    counts = levels.cells.sum(axis=(1, 2))
    assert (counts.min(), counts.max(), counts.sum()) == (181, 365, 78925)
