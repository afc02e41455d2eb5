"""Files of levels that cannot be used: one error names array, level and what is wrong, for all mistakes at once."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.errors import ScenarioError, ScenarioWarning
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.reading.level_reading import read_levels
from irsim_gym.scenario.specs.level_set import LevelSet

SCENARIO = """\
world: {name: two}
robot:
  - {kinematics: {name: diff}, distribution: {name: random}}
  - {kinematics: {name: diff}, state: [1, 1], goal: [[[2, 2], [3, 3]]]}
obstacle:
  - {shape: {name: circle, random_shape: true}, state: [5, 5]}
  - {number_range: [0, 1], shape: {name: rectangle, length: 1, width: 1}, distribution: {name: random}}
levels: levels.npz
"""
DISC = {"discs": [[0, 0, 0.5]], "disc_start": np.tile([0, 0, 1, 1], (3, 1))}


def arrays(**changes: Any) -> dict[str, Any]:
    """Three levels for the scenario; None leaves an array out."""
    goal = np.full((3, 3, 3), np.nan)
    goal[:, 0] = [8, 8, 0]
    start = np.tile([[1.0, 1.0, 1.0], [5.0, 5.0, 1.0], [7.0, 3.0, 1.0]], (3, 1, 1))
    whole = {"bodies": ["robot_0", "obstacle_2", "obstacle_3"], "start": start, "goal": goal, **DISC}
    return {name: value for name, value in (whole | changes).items() if value is not None}


def changed(name: str, place: tuple[Any, ...], value: Any) -> dict[str, Any]:
    array = np.array(arrays()[name])
    array[place] = value
    return {name: array}


def load(tmp_path: Path, **changes: Any) -> Any:
    (tmp_path / "two.yaml").write_text(SCENARIO, encoding="utf-8")
    np.savez(tmp_path / "levels.npz", **arrays(**changes))
    return load_scenario(tmp_path / "two.yaml")


def test_a_good_file_is_read(tmp_path: Path) -> None:
    levels = load(tmp_path, present=np.array([[1, 1, 1], [1, 1, 0], [1, 1, 1]], bool)).levels
    assert isinstance(levels, LevelSet)
    assert (levels.count, levels.rows("test"), levels.shaped.tolist()) == (3, (0, 3), [False, True, False])
    assert levels.present[1].tolist() == [True, True, False]


MISTAKES = [
    ({"start": None}, ["two.yaml:8   levels.start: is missing"]),
    (
        {"strat": [1], "start": np.full((3, 3, 3), np.nan)},
        ["levels.strat: unknown array (did you mean 'start'?)", "levels.start: level 0, "],
    ),
    ({"disc_start": None}, ["levels.disc_start: is missing, and discs needs it"]),
    ({"start": np.ones((3, 3, 2))}, ["levels.start: must have the axes (level, body, 3), got shape (3, 3, 2)"]),
    ({"goal": np.ones((4, 3, 3))}, ["levels.goal: axis level must be 3 long, as start has 3, got 4"]),
    ({"disc_start": np.zeros((3, 3), int)}, ["levels.disc_start: axis body+1 must be 4 long, as bodies has 3, got 3"]),
    ({"present": np.ones((3, 3))}, ["levels.present: must hold true or false, got float64"]),
    ({"bodies": np.zeros((0,), "U1"), "start": np.zeros((0, 0, 3)), "goal": None, "discs": None, "disc_start": None},
     ["levels.start: holds no level"]),
    ({"bodies": ["robot_0", "obstacle_2", "obstacle_2"]}, ["levels.bodies: the name 'obstacle_2' is there twice"]),
    (changed("start", (2, 0, 1), np.nan),
     ["levels.start: level 2, 'robot_0': must be three numbers between -1e7 and 1e7, got [1.0, nan, 1.0]"]),
    (changed("start", (slice(None), slice(None)), np.inf), ["levels.start: and 6 more like these"]),
    (changed("goal", (1, 0, 0), np.nan), ["levels.goal: level 1, 'robot_0': must be x, y and a heading or NaN"]),
    (changed("goal", (1, 0), np.nan), ["levels.goal: level 1, 'robot_0': needs a goal"]),
    (changed("goal", (1, 1), 2.0), ["levels.goal: level 1, 'obstacle_2': has no goal in the scenario"]),
    (changed("disc_start", (0, 2), -1), ["levels.disc_start: level 0, 'obstacle_2': must not fall, and lie between"]),
    (changed("disc_start", (0, 2), 7), ["level 0, 'obstacle_2': must not fall, and lie between 0 and 1, got [0, 7]"]),
    (changed("disc_start", (1, 2), 0), ["levels.segments: level 1, 'obstacle_2': has no outline (segments or discs)"]),
    (changed("discs", (0, 2), 0), ["levels.discs: row 0: must be x, y and a radius above 0, got [0. 0. 0.]"]),
    ({"present": np.eye(3) < 1}, ["levels.present: level 0, 'robot_0': must be there, since its entry has no number_r",
                                  "levels.present: level 1, 'obstacle_2'"]),
    ({"bodies": ["robot_0", "obstacle_2", "robot_5"]}, ["no body named 'robot_5' (did you mean 'robot_1'?)",
                                                        "the scenario draws 'obstacle_3': the file must place them"]),
    ({"splits": ["train", "tset"], "split_start": [0, 1, 2]},
     ["levels.splits: must be different ones of train, dev, test, got train, tset",
      "levels.split_start: must rise from 0 to the number of levels, 3, got [0, 1, 2]"]),
    ({"segments": np.ones((1, 4)), "segment_start": np.tile([0, 1, 1, 1], (3, 1))},
     ["levels.segments: 'robot_0': only a random_shape or a standing obstacle takes its outline"]),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "told"), MISTAKES, ids=[told[0][:60] for _, told in MISTAKES])
def test_mistakes_are_told(tmp_path: Path, changes: dict[str, Any], told: list[str]) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(tmp_path, **changes)
    for text in told:
        assert text in str(caught.value), caught.value


def test_files_that_are_no_levels(tmp_path: Path) -> None:
    for name, content, told in (
        ("missing.npz", None, "no such file"),
        ("text.npz", b"hello", "it is no .npz file, an archive of arrays"),
        ("cut.npz", (tmp_path / "x.npz").write_bytes(b"") or b"PK\x03\x04cut", "it is no .npz file"),
    ):
        if content is not None:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(ScenarioError, match=told):
            read_levels(tmp_path / name)
    with pytest.raises(ScenarioError, match=r"levels: must be the name of an .npz file, got 3"):
        load_scenario({"levels": 3})


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    class Mischief:
        def __reduce__(self) -> Any:
            return (Path.touch, (tmp_path / "touched",))

    np.savez(tmp_path / "bad.npz", start=np.array([Mischief()], object), allow_pickle=True)
    with pytest.raises(ScenarioError, match=r"start.npy must hold numbers or text, got object"):
        read_levels(tmp_path / "bad.npz")
    assert not (tmp_path / "touched").exists()
    pickle.loads(pickle.dumps(Mischief()))
    assert (tmp_path / "touched").exists()  # unpickled, it would have done it


def test_levels_that_begin_badly_are_noted(tmp_path: Path) -> None:
    """The world is from 0 to 10 m."""
    starts = arrays()["start"]
    starts[1, 0, :2], starts[2, 0, :2] = (10.1, 5.0), (7.99, 8.0)
    with pytest.warns(ScenarioWarning) as told:
        load(tmp_path, start=starts)
    text = str(told[0].message)
    assert "two.yaml:8   levels: 'robot_0' starts outside the world in level 1" in text
    assert "'robot_0' starts at the goal, closer than its goal_threshold in level 2" in text


def test_a_start_in_an_occupied_cell_is_noted(tmp_path: Path) -> None:
    cells = np.zeros((2, 4, 5), bool)
    cells[1, 3, 0] = True  # from 7.5 to 10 m, and from 0 to 2 m
    start = np.array([[[8.0, 1.0, 0.0]], [[8.0, 1.0, 0.0]]])
    goal = np.full((2, 1, 3), 5.0)
    np.savez(tmp_path / "levels.npz", bodies=["robot_0"], start=start, goal=goal, cells=cells)
    (tmp_path / "map.yaml").write_text(
        f"world: {{obstacle_map: {np.zeros((4, 5), int).tolist()}}}\n"
        "robot: {kinematics: {name: diff}, distribution: {name: random}}\nlevels: levels.npz\n"
    )
    with pytest.warns(ScenarioWarning, match="'robot_0' starts in an occupied cell in level 1$"):
        load_scenario(tmp_path / "map.yaml")
