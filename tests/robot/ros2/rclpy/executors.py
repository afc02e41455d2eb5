"""Runs nodes."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.lifecycle import LifecycleNode


class SingleThreadedExecutor:
    """Does what a test sets: ``turns`` are called one after another, then a signal comes."""

    turns: tuple[Callable[[LifecycleNode], object], ...] = ()

    def __init__(self) -> None:
        self.nodes: list[LifecycleNode] = []
        self.left = list(self.turns)

    def add_node(self, node: LifecycleNode) -> bool:
        """Take a node."""
        self.nodes.append(node)
        return True

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Do what comes next."""
        if not self.left:
            raise KeyboardInterrupt
        self.left.pop(0)(self.nodes[0])
