"""Stands for rclpy: what the node of an export uses of it, with the arguments that it has in ROS 2."""

from rclpy.signals import SignalHandlerOptions

log: list[str] = []
"""What was called."""


def init(*, signal_handler_options: SignalHandlerOptions | None = None) -> None:
    """Begin."""
    log.append(f"init {signal_handler_options and signal_handler_options.name}")


def shutdown() -> None:
    """End."""
    log.append("shutdown")
