"""Levels from a file are the levels that were drawn into it, bit for bit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from test_every_feature import EVERYTHING, STEPS, assert_same, everything

import irsim_gym as ig
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.simulator.levels.level_table import copy_outline

SEED, COUNT = 2, 6
LIDAR = {"name": "lidar2d", "number": 3, "angle_range": 1.0, "range_max": 9}


@pytest.fixture(scope="module")
def drawn() -> LevelSet:
    return draw_levels(ig.compile(everything(), 4), ["train", "dev"], COUNT)


@pytest.fixture
def file(drawn: LevelSet, tmp_path: Path) -> Path:
    path = tmp_path / "levels.npz"
    path.write_bytes(drawn.content())
    return path


def compiled(levels: Path | None, n_worlds: int) -> ig.Simulation:
    data = yaml.safe_load(EVERYTHING) | ({} if levels is None else {"levels": str(levels)})
    return ig.compile(ig.load_scenario(data), n_worlds)


def test_everything_begins_and_goes_on_as_drawn(file: Path) -> None:
    given, fresh = compiled(file, 3), compiled(None, 3)
    for split in ("train", "dev"):
        for sim in (given, fresh):
            sim.reset(SEED, split)
            for _ in range(STEPS):
                sim.step()
        for w in range(3):
            assert_same(given, w, fresh, w)
    np.testing.assert_array_equal(given.model.present, fresh.model.present)
    np.testing.assert_array_equal(given.model.segment_count, fresh.model.segment_count)
    given.reset_to_start()
    fresh.reset_to_start()
    assert_same(given, 0, fresh, 0)


def test_a_file_gives_back_what_it_was_drawn_from(file: Path, drawn: LevelSet) -> None:
    again = draw_levels(compiled(file, 5), ["train", "dev"], COUNT)
    assert again.hashes().tolist() == drawn.hashes().tolist()
    assert len(set(drawn.hashes().tolist())) == 2 * COUNT
    for name, array in drawn.arrays().items():
        if name != "about":
            np.testing.assert_array_equal(again.arrays()[name], array, err_msg=name)


def test_levels_are_counted_modulo_their_number_within_their_split(file: Path) -> None:
    sim = compiled(file, 1)
    sim.reset(COUNT + 1, "dev")
    there = sim.state.pose.copy()
    sim.reset(1, "dev")
    np.testing.assert_array_equal(sim.state.pose, there)
    sim.reset(1, "train")
    assert not np.array_equal(sim.state.pose, there)
    with pytest.raises(ig.errors.UnknownNameError, match=r"levels.npz has no split 'test'.*it has train, dev"):
        sim.reset(0, "test")


def test_later_levels_stay_in_the_file(file: Path) -> None:
    sim = compiled(file, 1)
    first = {tuple(sim.model.level_stream) for e in range(60) if sim.reset(0, "dev", e) is None}
    assert first == {(np.uint64(COUNT + k),) for k in range(COUNT)}


@pytest.mark.parametrize("num_threads", [1, 2])
def test_maps_come_from_the_file(tmp_path: Path, num_threads: int) -> None:
    data = {
        "world": {"name": "cells", "obstacle_map": {"name": "cells", "fill": [0.0, 0.4]}},
        "robot": {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}, "sensors": [LIDAR],
                  "distribution": {"name": "cells"}},
    }  # fmt: skip
    fresh = ig.compile(ig.load_scenario(data), 4)
    drawn = draw_levels(fresh, ["test"], 5)
    assert drawn.cells is not None
    assert drawn.cells.shape == (5, 10, 10)
    assert len(set(drawn.cells.sum(axis=(1, 2)).tolist())) > 1
    (tmp_path / "cells.npz").write_bytes(drawn.content())
    given = ig.compile(ig.load_scenario({**data, "levels": str(tmp_path / "cells.npz")}), 4, num_threads=num_threads)
    for sim in (fresh, given):
        sim.reset(1, "test")
    for name in ("map_squares", "map_room", "map_n_boxes", "start", "waypoints", "level_random"):
        np.testing.assert_array_equal(getattr(given.model, name), getattr(fresh.model, name), err_msg=name)
    np.testing.assert_array_equal(given.sensors[0].arrays["ranges"], fresh.sensors[0].arrays["ranges"])
    assert draw_levels(given, ["test"], 5).hashes().tolist() == drawn.hashes().tolist()
    for cells, told in ((None, "the scenario draws its obstacle_map"), (np.zeros((5, 9, 10), bool), "10 x 10 cells")):
        arrays = {name: array for name, array in drawn.arrays().items() if name != "cells"}
        np.savez(tmp_path / "bad.npz", **arrays, **({} if cells is None else {"cells": cells}))
        with pytest.raises(ig.errors.ScenarioError, match=told):
            ig.load_scenario({**data, "levels": str(tmp_path / "bad.npz")})


def test_discs_from_a_file_replace_the_shape_of_an_obstacle(tmp_path: Path) -> None:
    """Three discs, then one: seen at x = 3 - 0.5 in one level, at 5 - 0.1 in the other, each from (0, 5)."""
    np.savez(
        tmp_path / "discs.npz",
        bodies=["posts"],
        start=np.zeros((2, 1, 3)),
        discs=[[3, 5, 0.5], [6, 5, 0.5], [2, 9, 0.3], [5, 5, 0.1]],
        disc_start=[[0, 3], [3, 4]],
    )
    robot = {"kinematics": {"name": "diff"}, "state": [0, 5, 0], "goal": [9, 5], "sensors": [LIDAR]}
    posts = {"name": "posts", "shape": {"name": "circle"}}
    data = {"robot": robot, "obstacle": posts, "levels": str(tmp_path / "discs.npz")}
    sim = ig.compile(ig.load_scenario(data), 2)
    sim.reset(0)
    assert sim.sensors[0].arrays["ranges"][:, 0, 1] == pytest.approx([2.5, 4.9])
    assert sim.model.reach[:, 1] == pytest.approx([np.hypot(2, 9) + 0.3, np.hypot(5, 5) + 0.1])
    assert sim.model.disc_count[:, 1].tolist() == [3, 1]
    assert sim.model.segment_count[:, 1].tolist() == [0, 0]


def test_all_goals_of_a_level_come_from_the_file_and_missing_ones_from_the_scenario(tmp_path: Path) -> None:
    """Four goals of the first robot in each level; the second has its one goal from the file, then its own again."""
    goals = np.full((2, 2, 4, 3), np.nan)
    goals[0, 0], goals[1, 0] = [[1, k, 0] for k in (1, 2, 3, 4)], [[2, k, 0] for k in (6, 7, 8, 9)]
    goals[0, 1, 0] = [7, 1, 0]
    start = np.zeros((2, 2, 3))
    start[:, 0, :2], start[:, 1, :2] = [5, 5], [5, 2]
    np.savez(tmp_path / "goals.npz", bodies=["ann", "bob"], start=start, goal=goals)
    robot = {"kinematics": {"name": "diff"}}
    robots = [
        {**robot, "name": "ann", "distribution": {"name": "random", "goals": 4}},
        {**robot, "name": "bob", "state": [5, 2, 0], "goal": [8, 8, 0]},
    ]
    simulation = ig.compile(ig.load_scenario({"robot": robots, "levels": str(tmp_path / "goals.npz")}), 2)
    simulation.reset(0)
    assert simulation.model.waypoints[:, 0].tolist() == goals[:, 0].tolist()
    assert simulation.model.waypoints[:, 1, 0].tolist() == [[7, 1, 0], [8, 8, 0]]


@pytest.mark.parametrize(
    ("segment", "disc", "reach"),
    [
        ((0.5, 0.0, 3.0, 4.0), (0.0, 0.0, 1.0), 5.0),  # the second end is the farthest point
        ((3.0, 4.0, 0.5, 0.0), (0.0, 0.0, 1.0), 5.0),
        ((0.0, 0.0, 1.0, 0.0), (6.0, 8.0, 0.5), 10.5),
    ],
)
def test_the_reach_of_an_outline_is_its_farthest_point(
    segment: tuple[float, ...], disc: tuple[float, ...], reach: float, file: Path
) -> None:
    simulation = compiled(file, 1)
    levels, model = simulation.parts.levels, simulation.model
    assert levels is not None
    b = int(levels.bodies[np.flatnonzero(levels.shaped)[0]])
    given = replace(levels, segments=np.array([segment]), discs=np.array([disc]))
    copy_outline(0, b, np.array([0, 1]), np.array([0, 1]), given, model)
    assert model.reach[0, b] == pytest.approx(reach, abs=1e-12)
