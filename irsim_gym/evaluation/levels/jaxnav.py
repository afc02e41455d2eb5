"""Imports JaxNav's levels (Rutherford et al. 2024) from a user's copy: a pickle of states, or an .npz.

``foreign.read_pickle`` reads the numbers of the pickle without unpickling its classes. Columns run along x and rows
along y, 1 m each, whereas JaxNav's maps are indexed ``[y][x]``.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.evaluation.levels.foreign import ForeignObject, read_arrays, read_pickle
from irsim_gym.scenario.reading.level_reading import complete_levels
from irsim_gym.scenario.specs.level_set import LevelSet

WORDS = {
    "start_xy": ("pos", "agent_pos"),
    "start_heading": ("theta", "agent_theta"),
    "goal_xy": ("goal", "goal_pos"),
    "cells": ("map_data",),
}
"""Names of a level's arrays in an ``.npz``, and in the classes of JaxNav's pickles."""
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
    arrays = _from_pickle(path) if path.suffix in (".pkl", ".pickle") else read_arrays(path, AXES)
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


def _from_pickle(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a pickle of states, or of a list of them, each of which may hold many levels."""
    records = list(_records(read_pickle(path)))
    found: dict[str, list[NDArray[Any]]] = {name: [] for name in WORDS}
    problems = [] if records else [Problem(0, "", "holds no state of JaxNav")]
    for i, record in enumerate(records):
        for name, words in WORDS.items():
            known = next((vars(record)[word] for word in words if word in vars(record)), None)
            if not isinstance(known, np.ndarray) or known.ndim not in (len(AXES[name]), len(AXES[name]) - 1):
                problems.append(Problem(0, f"[{i}].{words[0]}", "is missing, or no array of the right shape"))
            else:
                found[name].append(known if known.ndim == len(AXES[name]) else known[None])
    if problems:
        raise ScenarioError(str(path), problems)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _records(data: object) -> Iterator[ForeignObject]:
    """Yield the records in nested lists and tuples."""
    if isinstance(data, ForeignObject):
        yield data
    elif isinstance(data, list | tuple):
        for item in data:
            yield from _records(item)
