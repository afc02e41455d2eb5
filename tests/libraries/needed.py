"""Libraries as the tests get them: in the version that their page is about."""

from __future__ import annotations

import importlib
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType

import library_pages as pages
import pytest

PACKAGES = {"sbx": "sbx-rl", "sample_factory": "sample-factory", "pufferlib": "pufferlib-core", "own_loops": "torch"}
"""Packages that are not named as their module."""


def skip_without(name: str) -> None:
    """Skip the test where a library is not installed, or in another version than its page names, if it has a page."""
    try:
        here = version(PACKAGES.get(name, name))
    except PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    told = pages.HEAD.match(pages.text_of(name)) if name in pages.names() else None
    if told and told[2] and here != told[2]:
        pytest.skip(f"{name} {here} is here, the page is about {told[2]}")


def library(name: str) -> ModuleType:
    """Import a library, or skip the test where it is not there.

    A library that is there but cannot be imported fails, which ``pytest.importorskip`` would skip.
    """
    skip_without(name.partition(".")[0])
    return importlib.import_module(name)
