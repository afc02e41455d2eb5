"""Imports JaxNav's levels (Rutherford et al. 2024) from a user's copy, an .npz.

Columns run along x and rows along y, 1 m each, whereas JaxNav's maps are indexed ``[y][x]``.
"""

from pathlib import Path

import numpy as np

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.evaluation.levels.foreign import read_arrays
from irsim_gym.scenario.reading.level_reading import complete_levels
from irsim_gym.scenario.specs.level_set import LevelSet

BENCHMARKS = {1: "jaxnav_single", 4: "jaxnav_four"}
"""The benchmark that plays levels of so many robots, if their map has its size."""
SIZE = (11, 11)
AXES = {
    "cells": ("level", "row", "column"),
    "start_xy": ("level", "robot", "2"),
    "start_heading": ("level", "robot"),
    "goal_xy": ("level", "robot", "2"),
}


def import_jaxnav(path: Path) -> LevelSet:
    """Return JaxNav's levels for robots named ``robot_0``, ``robot_1`` and so on.

    Levels of the benchmark ``jaxnav_single`` or ``jaxnav_four`` name it, so that they are played as they are.

    Raises:
        ScenarioError: If the file cannot be used; the error lists every problem.
    """
    arrays = read_arrays(path, AXES)
    cells = arrays["cells"].astype(np.int64)
    if ((cells != 0) & (cells != 1)).any():
        raise ScenarioError(str(path), [Problem(0, "cells", "must be 0 (free) or 1 (wall)")])
    heading = np.mod(arrays["start_heading"].astype(np.float64) + np.pi, 2.0 * np.pi) - np.pi
    goal = arrays["goal_xy"].astype(np.float64)
    found = {
        "bodies": [f"robot_{k}" for k in range(heading.shape[1])],
        "start": np.concatenate([arrays["start_xy"].astype(np.float64), heading[..., None]], axis=2),
        "goal": np.concatenate([goal, np.full((*heading.shape, 1), np.nan)], axis=2),
        "cells": cells.transpose(0, 2, 1) == 1,
    }
    about = {"source": "JaxNav", "file": path.name}
    if heading.shape[1] in BENCHMARKS and cells.shape[1:] == SIZE:
        about["scenario"] = BENCHMARKS[heading.shape[1]]
    return complete_levels("", found, about)
