"""Stands for tf2_ros: transforms that a test sets."""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import LifecycleNode
from rclpy.time import Time


class TransformException(Exception):  # noqa: N818
    """A transform is not known."""


class Buffer:
    """Knows transforms by target and source."""

    def __init__(self) -> None:
        self.known: dict[tuple[str, str], Any] = {}

    def lookup_transform(self, target_frame: str, source_frame: str, time: Time) -> Any:
        """Return the newest one, which a time of zero asks for."""
        assert time.nanoseconds == 0
        try:
            return self.known[target_frame, source_frame]
        except KeyError:
            raise TransformException(f'"{source_frame}" does not exist') from None


class TransformListener:
    """Listens for a buffer."""

    def __init__(self, buffer: Buffer, node: LifecycleNode) -> None:
        self.buffer, self.node = buffer, node
