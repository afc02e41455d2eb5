"""BARN's worlds (Perille et al. 2020) from a user's own copy: a folder of Gazebo files, or an .npz of cylinders.

Each world is one level: the cylinders are the outline of one standing body, ``cylinders``. Start and goal are the same
in all worlds, so the scenario gives them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.errors import Problem, ScenarioError
from irsim_gym.levels.foreign import complete_set, read_arrays
from irsim_gym.scenario.level_set import LevelSet

BODY = "cylinders"
RADIUS = 0.075
"""Radius of the cylinders [m] where the file does not say it."""


def import_barn(path: Path) -> LevelSet:
    """Return BARN's worlds as levels, in the order of their numbers.

    Args:
        path: Folder of ``world_N.world`` files, or an ``.npz`` with ``cylinder_xy`` (n, 2) [m] and ``world_start``:
            world i has the rows from ``world_start[i]`` to ``world_start[i + 1]``.

    Raises:
        ScenarioError: It is neither; the error lists every problem.
    """
    worlds = _from_folder(path) if path.is_dir() else _from_arrays(path)
    counts = np.array([len(discs) for discs in worlds], np.int64)
    ends = np.cumsum(counts)
    return complete_set(
        bodies=(BODY,),
        start=np.zeros((len(worlds), 1, 3)),
        discs=np.concatenate([np.zeros((0, 3)), *worlds]),
        disc_start=np.stack([ends - counts, ends], axis=1),
        about={"source": "BARN", "file": path.name},
    )


def _from_folder(folder: Path) -> list[Floats]:
    """Return the discs of each world file."""
    files = sorted(folder.glob("*.world"), key=_number)
    problems = [] if files else [Problem(0, "", "holds no .world file")]
    worlds = []
    for file in files:
        try:
            worlds.append(_cylinders(ElementTree.parse(file).getroot()))
            if not len(worlds[-1]):
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


def _from_arrays(file: Path) -> list[Floats]:
    """Return the discs of each world of an ``.npz``."""
    arrays = read_arrays(file, {"cylinder_xy": ("n", "2"), "world_start": ("world+1",)})
    rows: Ints = arrays["world_start"].astype(np.int64)
    places = arrays["cylinder_xy"].astype(np.float64)
    if len(rows) < 2 or rows[0] < 0 or rows[-1] > len(places) or (np.diff(rows) <= 0).any():
        wrong = f"must rise from 0 to the number of cylinders, {len(places)}"
        raise ScenarioError(str(file), [Problem(0, "world_start", wrong)])
    # The file has 32 bits: 1e-6 m is finer than they are, and gives the decimal numbers of the original.
    discs = np.column_stack([np.round(places, 6), np.full(len(places), RADIUS)])
    parts: Sequence[Floats] = np.split(discs[: rows[-1]], rows[1:-1])
    return list(parts)
