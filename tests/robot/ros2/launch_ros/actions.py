"""Nodes that are started."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class Node:
    """A node."""

    def __init__(
        self,
        *,
        package: str,
        executable: str,
        name: str,
        namespace: str | None = None,
        output: str = "log",
        parameters: Sequence[Any] = (),
        remappings: Sequence[tuple[str, Any]] = (),
    ) -> None:
        self.package, self.executable, self.name = package, executable, name
        self.parameters, self.remappings = list(parameters), dict(remappings)


class LifecycleNode(Node):
    """A node with a life cycle."""
