"""Texts that are known when something is started."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class LaunchConfiguration:
    """The value of an argument."""

    def __init__(self, variable_name: str) -> None:
        self.name = variable_name


class PathJoinSubstitution:
    """A path."""

    def __init__(self, substitutions: Sequence[Any]) -> None:
        self.parts = list(substitutions)
