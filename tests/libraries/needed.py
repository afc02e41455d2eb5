"""Libraries as the tests get them."""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from types import ModuleType

import pytest


def library(name: str) -> ModuleType:
    """Import a library, or skip the test where it is not installed.

    A library that is there but cannot be imported fails, which ``pytest.importorskip`` would skip.
    """
    if find_spec(name.partition(".")[0]) is None:
        pytest.skip(f"{name} is not installed")
    return importlib.import_module(name)
