"""How a package shows its public names: they are those of its module ``face``, which is loaded when one is used."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any


def public(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package with a module ``face``.

    Args:
        package: Its dotted name.
    """

    def load(name: str) -> Any:
        if (name.startswith("__") and name != "__all__") or find_spec(f"{package}.{name}") is not None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.face"), name)

    return load
