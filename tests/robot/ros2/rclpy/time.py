"""A moment."""

from __future__ import annotations

from typing import Any

from standing_messages import message


class Time:
    """Nanoseconds since the beginning."""

    def __init__(self, *, seconds: int = 0, nanoseconds: int = 0) -> None:
        self.nanoseconds = 1_000_000_000 * seconds + nanoseconds

    def to_msg(self) -> Any:
        """Return it as a message."""
        msg = message("builtin_interfaces/msg/Time")()
        msg.sec, msg.nanosec = divmod(self.nanoseconds, 1_000_000_000)
        return msg
