"""Convert the worlds of the BARN challenge (Perille et al. 2020), a user's own copy, into levels of ``barn``.

    python agents/studies/barn_levels.py BARN_dataset/world_files barn.npz

COPY is a folder of ``world_N.world`` files, or an ``.npz`` with ``cylinder_xy`` (n, 2) [m] and ``world_start``: world i
has the rows from ``world_start[i]`` to ``world_start[i + 1]``. The cylinders stand in the middle of cells of 0.15 m, so
each world becomes one level: its cells, and BARN's start and goal.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

RADIUS = 0.075
"""Radius of the cylinders [m]."""
CELL, COLUMNS, ROWS, LEFT = 0.15, 30, 90, -4.5
"""Cells of the benchmark: side [m], numbers, and left edge of the first column [m]; the first row begins at 0."""
START, GOAL = (-2.25, 3.0, np.pi / 2), (-2.25, 13.0, np.nan)
CLOSE = 1e-3
"""Tolerance for rounding in the file [m]."""
Array = NDArray[Any]


def barn_levels(copy: Path) -> dict[str, Array]:
    """Return the arrays of a file of levels (docs/levels.md), worlds in the order of their numbers.

    Raises:
        SystemExit: If the copy cannot be read, or a cylinder fills no cell.
    """
    worlds = [*(_from_folder(copy) if copy.is_dir() else _from_arrays(copy))]
    cells = np.zeros((len(worlds), COLUMNS, ROWS), np.bool_)
    for number, (name, discs) in enumerate(worlds):
        place = (discs[:, :2] - (LEFT, 0.0)) / CELL - 0.5
        column, row = np.rint(place).astype(np.int64).T
        is_on = (np.abs(place - np.rint(place)) * CELL < CLOSE).all(axis=1) & (np.abs(discs[:, 2] - RADIUS) < CLOSE)
        is_on &= (column >= 0) & (column < COLUMNS) & (row >= 0) & (row < ROWS)
        if not is_on.all():
            x, y, radius = discs[~is_on][0].tolist()
            wish = f"cylinders must have a radius of {RADIUS} m and stand in {COLUMNS} x {ROWS} cells of {CELL} m"
            raise SystemExit(f"{copy}, {name}: {wish} from ({LEFT}, 0) on, got radius {radius:g} at ({x:g}, {y:g})")
        cells[number, column, row] = True
    ends = {"start": START, "goal": GOAL}
    about = {"source": "BARN", "file": copy.name, "scenario": "barn"}
    return {
        "bodies": np.array(["robot_0"]),
        **{name: np.full((len(worlds), 1, 3), place) for name, place in ends.items()},
        "cells": cells,
        "about": np.array(json.dumps(about, sort_keys=True)),
    }


def _from_folder(folder: Path) -> list[tuple[str, Array]]:
    """Return name and discs of each world file."""
    files = sorted(folder.glob("*.world"), key=lambda file: (int(*re.findall(r"\d+", file.stem)[:1]), file.name))
    if not files:
        raise SystemExit(f"{folder} holds no .world file")
    worlds = []
    for file in files:
        try:
            discs = _cylinders(ElementTree.parse(file).getroot())
        except (ElementTree.ParseError, ValueError, TypeError) as error:
            raise SystemExit(f"{file} cannot be read as a Gazebo world: {error}") from None
        if not len(discs):
            raise SystemExit(f"{file} holds no cylinder")
        worlds.append((file.name, discs))
    return worlds


def _cylinders(root: Any) -> Array:
    """Return x, y, radius [m] of the models of a world that are cylinders, shape ``(n, 3)``."""
    discs = []
    for model in root.iterfind("./world/model"):
        shape = model.find(".//collision/geometry/cylinder")
        if shape is not None:
            x, y, *_ = (float(value) for value in (model.findtext("pose") or "0 0").split())
            discs.append([x, y, float(shape.findtext("radius", str(RADIUS)))])
    return np.array(discs, np.float64).reshape(-1, 3)


def _from_arrays(file: Path) -> list[tuple[str, Array]]:
    """Return name and discs of each world of an ``.npz``."""
    with np.load(file, allow_pickle=False) as arrays:
        places, rows = arrays["cylinder_xy"].astype(np.float64), arrays["world_start"].astype(np.int64)
    if len(rows) < 2 or rows[0] < 0 or rows[-1] > len(places) or (np.diff(rows) <= 0).any():
        raise SystemExit(f"{file}: world_start must rise from 0 to the number of cylinders, {len(places)}")
    discs = np.column_stack([places, np.full(len(places), RADIUS)])
    parts = np.split(discs[rows[0] : rows[-1]], rows[1:-1] - rows[0])
    return [(f"world {number}", part) for number, part in enumerate(parts)]


def main() -> None:
    """Write the levels."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("copy", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    np.savez_compressed(given.out, **barn_levels(given.copy))


if __name__ == "__main__":
    main()
