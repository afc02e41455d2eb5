"""Reads files of other projects: arrays of known shapes, and the numbers in pickles without running their code."""

from __future__ import annotations

import io
import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.base.outside_files import npz_arrays, reading


class ForeignObject:
    """Replaces an object of a class that is not loaded, with the same attributes."""

    def __new__(cls, *values: object) -> ForeignObject:
        """Make a record, ignoring the arguments of the original class."""
        return super().__new__(cls)


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


def read_pickle(file: Path) -> Any:
    """Return what a pickle holds: lists, numbers, text, arrays, and records in the place of all other objects.

    No class or function of the pickle is loaded or called, except those that build NumPy arrays.

    Raises:
        UnreadableFileError: If the file is not a pickle, or needs an unknown function.
    """
    with reading(file, "pickle of numbers"):
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
