"""Kernels as plain Python, with arrays in which an index beyond either end is an error.

NumPy, like a compiled kernel, lets an index below zero count from the end. In a kernel that is a mistake: -1 stands for
nobody there, and must not be taken for the last body.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from irsim_gym.base import kernels as jit
from irsim_gym.base.kernels.structs import Struct


class Guarded(np.ndarray):
    """An array whose elements and parts are asked for by indices from zero on."""

    def __getitem__(self, key: Any) -> Any:
        _check(self, key)
        return super().__getitem__(key)

    def __setitem__(self, key: Any, value: Any) -> None:
        _check(self, key)
        super().__setitem__(key, value)


def _check(array: Guarded, key: Any) -> None:
    for axis, index in enumerate(key if type(key) is tuple else (key,)):
        kind = type(index)
        if kind is slice:
            if (index.start or 0) < 0 or (index.stop or 0) < 0:
                raise IndexError(f"{index} counts from the end of axis {axis} with size {array.shape[axis]}")
        elif kind is not str and index < 0:
            raise IndexError(f"index {index} counts from the end of axis {axis} with size {array.shape[axis]}")


class Fields:
    """What a kernel sees of a struct: its fields, guarded."""

    def __init__(self, struct: Struct) -> None:
        self._struct = struct

    def __getattr__(self, name: str) -> Any:
        value = self.__dict__[name] = _guarded(getattr(self._struct, name))
        return value


def _guarded(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.view(Guarded)
    if isinstance(value, Struct):
        return Fields(value)
    if isinstance(value, tuple):
        inside = map(_guarded, value)
        return value._make(inside) if hasattr(value, "_make") else tuple(inside)
    return value


def install() -> None:
    """Guard all kernels that are defined from now on: before anything of the package is imported that has any."""
    plain = jit.kernel

    def kernel(function: Any = None, /, **options: Any) -> Any:
        if function is None:
            return functools.partial(kernel, **options)
        return _entered(plain(function, **options))

    jit.kernel = kernel


def _entered(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel that guards what Python gives it; what it hands on to other kernels is guarded already."""

    @functools.wraps(function)
    def enter(*arguments: Any) -> Any:
        return function(*map(_guarded, arguments))

    enter.compiled = enter
    return enter
