"""Stands for launch: keeps what it is told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class LaunchDescription:
    """What is started."""

    def __init__(self, initial_entities: Sequence[Any] = ()) -> None:
        self.entities = list(initial_entities)
