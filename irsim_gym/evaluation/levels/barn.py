"""Imports BARN's worlds (Perille et al. 2020) from a user's copy: a folder of Gazebo files, or an .npz of cylinders.

The cylinders of BARN stand in the middle of cells of 0.15 m, so each world becomes one level of the benchmark ``barn``:
its cells, and BARN's start and goal.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints
from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.evaluation.levels.foreign import read_arrays
from irsim_gym.scenario.reading.level_reading import complete_levels
from irsim_gym.scenario.specs.level_set import LevelSet

SCENARIO = "barn"
RADIUS = 0.075
"""Radius of the cylinders [m]."""
CELL, COLUMNS, ROWS, LEFT = 0.15, 30, 90, -4.5
"""Cells of the benchmark: side [m], numbers, and left edge of the first column [m]; the first row begins at 0."""
START, GOAL = (-2.25, 3.0, np.pi / 2), (-2.25, 13.0, np.nan)
CLOSE = 1e-3
"""Tolerance for rounding in the file [m]."""


def import_barn(path: Path) -> LevelSet:
    """Return BARN's worlds as levels of the benchmark ``barn``, in the order of their numbers.

    Args:
        path: Folder of ``world_N.world`` files, or an ``.npz`` with ``cylinder_xy`` (n, 2) [m] and ``world_start``:
            world i has the rows from ``world_start[i]`` to ``world_start[i + 1]``.

    Raises:
        ScenarioError: If the path is neither, or a cylinder fills no cell; the error lists every problem.
    """
    worlds = _from_folder(path) if path.is_dir() else _from_arrays(path)
    cells, problems = np.zeros((len(worlds), COLUMNS, ROWS), np.bool_), []
    for number, (name, discs) in enumerate(worlds):
        is_wrong = _occupy(cells[number], discs)
        if is_wrong.any():
            x, y, radius = (float(value) for value in discs[is_wrong][0])
            wish = f"cylinders must have a radius of {RADIUS} m and stand in {COLUMNS} x {ROWS} cells of {CELL} m"
            problems.append(Problem(0, name, f"{wish} from ({LEFT}, 0) on, got radius {radius:g} at ({x:g}, {y:g})"))
    if problems:
        raise ScenarioError(str(path), problems)
    start, goal = (np.full((len(worlds), 1, 3), place) for place in (START, GOAL))
    found = {"bodies": ["robot_0"], "start": start, "goal": goal, "cells": cells}
    return complete_levels("", found, {"source": "BARN", "file": path.name, "scenario": SCENARIO})


def _occupy(cells: Flags, discs: Floats) -> Flags:
    """Occupy the cells of cylinders x, y, radius [m], and return which cylinders fill no cell."""
    place = (discs[:, :2] - (LEFT, 0.0)) / CELL - 0.5
    column, row = np.rint(place).astype(np.int64).T
    is_on = (np.abs(place - np.rint(place)) * CELL < CLOSE).all(axis=1) & (np.abs(discs[:, 2] - RADIUS) < CLOSE)
    is_on &= (column >= 0) & (column < COLUMNS) & (row >= 0) & (row < ROWS)
    cells[column[is_on], row[is_on]] = True
    return np.logical_not(is_on)


def _from_folder(folder: Path) -> list[tuple[str, Floats]]:
    """Return name and discs of each world file."""
    files = sorted(folder.glob("*.world"), key=_number)
    problems = [] if files else [Problem(0, "", "holds no .world file")]
    worlds = []
    for file in files:
        try:
            worlds.append((file.name, _cylinders(ElementTree.parse(file).getroot())))
            if not len(worlds[-1][1]):
                problems.append(Problem(0, file.name, "holds no cylinder"))
        except (ElementTree.ParseError, ValueError, TypeError, OSError) as error:
            problems.append(Problem(0, file.name, f"cannot be read as a Gazebo world: {error}"))
    if problems:
        raise ScenarioError(str(folder), problems)
    return worlds


def _number(file: Path) -> tuple[int, str]:
    found = re.search(r"\d+", file.stem)
    return (int(found[0]) if found else -1), file.name


def _cylinders(root: Any) -> Floats:
    """Return x, y, radius [m] of the models of a world that are cylinders, shape ``(n, 3)``."""
    discs = []
    for model in root.iterfind("./world/model"):
        shape = model.find(".//collision/geometry/cylinder")
        if shape is not None:
            x, y, *_ = (float(value) for value in (model.findtext("pose") or "0 0").split())
            discs.append([x, y, float(shape.findtext("radius", str(RADIUS)))])
    return np.array(discs, np.float64).reshape(-1, 3)


def _from_arrays(file: Path) -> list[tuple[str, Floats]]:
    """Return name and discs of each world of an ``.npz``."""
    arrays = read_arrays(file, {"cylinder_xy": ("n", "2"), "world_start": ("world+1",)})
    rows: Ints = arrays["world_start"].astype(np.int64)
    places = arrays["cylinder_xy"].astype(np.float64)
    if len(rows) < 2 or rows[0] < 0 or rows[-1] > len(places) or (np.diff(rows) <= 0).any():
        wrong = f"must rise from 0 to the number of cylinders, {len(places)}"
        raise ScenarioError(str(file), [Problem(0, "world_start", wrong)])
    discs = np.column_stack([places, np.full(len(places), RADIUS)])
    parts: Sequence[Floats] = np.split(discs[rows[0] : rows[-1]], rows[1:-1] - rows[0])
    return [(f"world {number}", part) for number, part in enumerate(parts)]
