"""Which signals rclpy handles."""

from enum import Enum


class SignalHandlerOptions(Enum):
    """Handlers."""

    NO = 0
    SIGINT = 1
    SIGTERM = 2
    ALL = 3
