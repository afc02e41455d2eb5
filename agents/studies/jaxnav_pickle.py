"""Convert levels of JaxNav (Rutherford et al. 2024), a pickle of states, into a file of levels.

    python agents/studies/jaxnav_pickle.py eval_single_agent_1000e.pkl jaxnav.npz

Levels for one or four robots name the benchmark ``jaxnav_single`` or ``jaxnav_four``, so that they are played as they
are. It is not loaded, as that can run code: its arrays are taken out of
it, objects of JaxMARL become plain records, and anything else is refused.
"""

from __future__ import annotations

import argparse
import io
import json
import pickle
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORDS = {
    "cells": ("map_data",),
    "start_xy": ("pos", "agent_pos"),
    "start_heading": ("theta", "agent_theta"),
    "goal_xy": ("goal", "goal_pos"),
}
"""Arrays of a level, and their names in the classes of JaxNav's pickles."""
AXES = {"cells": 3, "start_xy": 3, "start_heading": 2, "goal_xy": 3}
"""Numbers of axes of the arrays; a record with one less holds a single level."""


class ForeignObject:
    """Replaces an object of a class that is not loaded, with the same attributes."""

    def __new__(cls, *values: object) -> ForeignObject:
        """Make a record, ignoring the arguments of the original class."""
        return super().__new__(cls)


def arrays_of(file: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a pickle of states, or of a list of them, each of which may hold many levels."""
    found: dict[str, list[NDArray[Any]]] = {name: [] for name in WORDS}
    for i, record in enumerate(_records(read_pickle(file))):
        for name, words in WORDS.items():
            known = next((vars(record)[word] for word in words if word in vars(record)), None)
            if not isinstance(known, np.ndarray) or known.ndim not in (AXES[name], AXES[name] - 1):
                raise SystemExit(f"{file}: [{i}].{words[0]} is missing, or no array of the right shape")
            found[name].append(known if known.ndim == AXES[name] else known[None])
    if not found["cells"]:
        raise SystemExit(f"{file} holds no state of JaxNav")
    return {name: np.concatenate(parts) for name, parts in found.items()}


BENCHMARKS = {1: "jaxnav_single", 4: "jaxnav_four"}
"""The benchmark that plays levels of so many robots, if their map has its size."""
SIZE = (11, 11)


def levels_of(arrays: Mapping[str, NDArray[Any]], file: str) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file of levels (docs/levels.md) for robots named ``robot_0``, ``robot_1`` and so on.

    Columns run along x and rows along y, 1 m each, whereas JaxNav's maps are indexed ``[y][x]``.

    Args:
        arrays: What ``arrays_of`` returns.
        file: Name of the pickle.
    """
    heading = np.mod(arrays["start_heading"].astype(np.float64) + np.pi, 2.0 * np.pi) - np.pi
    about, size = {"source": "JaxNav", "file": file}, arrays["cells"].shape[1:]
    if heading.shape[1] in BENCHMARKS and size == SIZE:
        about["scenario"] = BENCHMARKS[heading.shape[1]]
    return {
        "bodies": np.array([f"robot_{k}" for k in range(heading.shape[1])]),
        "start": np.concatenate([arrays["start_xy"].astype(np.float64), heading[..., None]], axis=2),
        "goal": np.concatenate([arrays["goal_xy"].astype(np.float64), np.full((*heading.shape, 1), np.nan)], axis=2),
        "cells": arrays["cells"].transpose(0, 2, 1) == 1,
        "about": np.array(json.dumps(about, sort_keys=True)),
    }


def _records(data: object) -> Iterator[ForeignObject]:
    """Yield the records in nested lists and tuples."""
    if isinstance(data, ForeignObject):
        yield data
    elif isinstance(data, list | tuple):
        for item in data:
            yield from _records(item)


def read_pickle(file: Path) -> Any:
    """Return what a pickle holds: lists, numbers, text, arrays, and records in the place of all other objects.

    No class or function of the pickle is loaded or called, except those that build NumPy arrays.

    Raises:
        UnpicklingError: If the file is not a pickle, or needs an unknown function.
    """
    return _NumbersOnly(io.BytesIO(file.read_bytes())).load()


def _device_array(function: Any, arguments: tuple[Any, ...], state: Any, *_: object) -> object:
    """Return a JAX array as a NumPy array; ``function`` is one of ``_KNOWN``."""
    made = function(*arguments)
    made.__setstate__(state)
    return made


def _empty(*_: object) -> NDArray[Any]:
    """Return an empty array, into which a pickle's state is loaded."""
    return np.ndarray((0,), np.int8)


def _scalar(dtype: object, content: bytes = b"") -> object:
    if not isinstance(dtype, np.dtype) or dtype.hasobject:
        raise pickle.UnpicklingError("a scalar of objects")
    return np.frombuffer(content, dtype, 1)[0]


def _dtype(text: str, *_: object) -> np.dtype[Any]:
    made = np.dtype(text)
    if made.hasobject:
        raise pickle.UnpicklingError("an array of objects")
    return made


_KNOWN: Mapping[tuple[str, str], Any] = {
    ("numpy", "ndarray"): np.ndarray,
    ("numpy", "dtype"): _dtype,
    **{(f"numpy.{core}.multiarray", "_reconstruct"): _empty for core in ("core", "_core")},
    **{(f"numpy.{core}.multiarray", "scalar"): _scalar for core in ("core", "_core")},
    ("jax._src.array", "_reconstruct_array"): _device_array,
    ("copyreg", "_reconstructor"): lambda cls, *_: cls() if cls is ForeignObject else _refuse(cls),
    ("builtins", "object"): object,
    ("_codecs", "encode"): lambda text, _: text.encode("latin1"),
}


def _refuse(cls: object) -> object:
    raise pickle.UnpicklingError(f"an object of {cls}")


class _NumbersOnly(pickle.Unpickler):
    """Reads a pickle; classes of known packages become ``ForeignObject``, and other unknown classes are refused."""

    PACKAGES = ("jaxmarl", "sfl", "jax_multirobsim")

    def find_class(self, module: str, name: str) -> Any:
        """Return the replacement of a class or function of the pickle.

        Raises:
            UnpicklingError: If the class or function is unknown.
        """
        if (module, name) in _KNOWN:
            return _KNOWN[module, name]
        if module.split(".")[0] in self.PACKAGES:
            return ForeignObject
        raise pickle.UnpicklingError(f"it needs {module}.{name}, which is not read")


def main() -> None:
    """Write the levels of a pickle."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pickle", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    np.savez_compressed(given.out, **levels_of(arrays_of(given.pickle), given.pickle.name))


if __name__ == "__main__":
    main()
