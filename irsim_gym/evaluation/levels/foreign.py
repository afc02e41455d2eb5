"""Reads files of other projects: arrays of known shapes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.base.outside_files import npz_arrays, reading


def read_arrays(file: Path, axes: Mapping[str, tuple[str, ...]]) -> dict[str, NDArray[Any]]:
    """Return arrays of numbers from an ``.npz``.

    Args:
        axes: Names of the axes of each array; a digit is a fixed length, and ``x+1`` is one more than axis ``x``.

    Raises:
        UnreadableFileError: If the file cannot be read.
        ScenarioError: If an array is missing, has another shape or holds no numbers; the error lists every problem.
    """
    with reading(file, "file of levels"):
        found = npz_arrays(file)
    problems, sizes = [], dict[str, int]()
    for name, wanted in axes.items():
        array = found.get(name)
        wish = f"must be numbers with the axes ({', '.join(wanted)})"
        if array is None:
            problems.append(Problem(0, name, f"is missing: it {wish}"))
        elif array.ndim != len(wanted) or array.dtype.kind not in "biuf" or not np.isfinite(array).all():
            problems.append(Problem(0, name, f"{wish}, got {array.dtype}, shape {array.shape}"))
        else:
            for axis, length in zip(wanted, array.shape, strict=True):
                known = int(axis) if axis.isdigit() else sizes.setdefault(axis, length)
                if length != known:
                    problems.append(Problem(0, name, f"{wish}: {axis} must be {known} long, got {length}"))
    if problems:
        raise ScenarioError(str(file), problems)
    return found
