"""How packages show their public names, and where public names of version 0.1 are now."""

import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from irsim_gym.base.outside_files import json_object

FORMER: dict[str, str] = json_object(Path(__file__).with_suffix(".json"))
"""Modules of version 0.1 and the faces that have their public names now. They go with the next release."""


def public(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package with a module ``face``, whose names are loaded when one is used.

    Args:
        package: Its dotted name.
    """

    def load(name: str) -> Any:
        if (name.startswith("__") and name != "__all__") or find_spec(f"{package}.{name}") is not None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.face"), name)

    return load


class FormerModule(ModuleType):
    """A module that is gone: each of its public names warns, and is taken from where it is."""

    def __getattr__(self, name: str) -> Any:
        homes = dict(_homes(FORMER[self.__name__.partition(".")[2]]))
        if name not in homes:
            raise AttributeError(f"module {self.__name__!r} is gone, and with it {name!r}")
        place = f"irsim_gym.{homes[name]}"
        warnings.warn(f"{self.__name__}.{name} is now {place}", DeprecationWarning, stacklevel=2)
        module, _, last = place.rpartition(".")
        return getattr(import_module(module), last)


def _homes(text: str) -> list[tuple[str, str]]:
    """Return names with their places, which end in the same name unless the text says otherwise."""
    parts = [part.partition("=") for part in text.split()]
    return [(first, place) if equals else (first.rpartition(".")[2], first) for first, equals, place in parts]


def keep_former() -> None:
    """Let modules of version 0.1 be imported."""
    for name in FORMER:
        module = FormerModule(f"irsim_gym.{name}")
        module.__spec__ = ModuleSpec(module.__name__, None)
        sys.modules.setdefault(module.__name__, module)
