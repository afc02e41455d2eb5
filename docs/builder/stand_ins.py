"""Stand-ins for optional libraries, so that the reference shows modules which import them without installing them."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

OPTIONAL = ("ray", "sb3_contrib")
"""Libraries that public modules import at their top and that neither ``.[test]`` nor ``.[docs]`` has to bring."""
OWN = "irsim_gym"


class _StandIn(ModuleType):
    """A module of which every name is an empty class, to inherit from and to annotate with."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        made = type(name, (), {"__module__": self.__name__, "__doc__": None})
        setattr(self, name, made)
        return made


class _Finder:
    """Finds stand-ins for libraries and all their submodules. It is asked last, so installed libraries are used."""

    def find_spec(self, name: str, path: Sequence[str] | None = None, target: object = None) -> ModuleSpec | None:
        return ModuleSpec(name, self, is_package=True) if name.partition(".")[0] in OPTIONAL else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return _StandIn(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: names are made when they are asked for."""


@contextmanager
def stood_in() -> Iterator[None]:
    """Let optional libraries that are not installed be imported; afterwards they are as absent as before."""
    finder = _Finder()
    sys.meta_path.append(finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        stand_ins = [name for name, module in sys.modules.items() if isinstance(module, _StandIn)]
        for name in [*_users(), *stand_ins]:
            parent, _, last = name.rpartition(".")
            del sys.modules[name]
            vars(sys.modules.get(parent, ModuleType(""))).pop(last, None)


@cache
def module(name: str) -> ModuleType:
    """Return a module, imported with stand-ins for what it lacks."""
    with stood_in():
        return importlib.import_module(name)


def _users() -> list[str]:
    """Return the names of our modules that hold anything from a stand-in."""
    own = [(name, vars(one)) for name, one in sys.modules.items() if name.partition(".")[0] == OWN]
    return [name for name, held in own if any(map(_is_made_up, held.values()))]


def _is_made_up(value: object) -> bool:
    """Return whether a value is a stand-in, one of its classes, or a class that inherits from one."""
    if isinstance(value, type):
        return any(isinstance(sys.modules.get(kind.__module__), _StandIn) for kind in value.__mro__)
    return isinstance(value, _StandIn)
