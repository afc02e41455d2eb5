"""Ackermann steering: a car. Its options are known; it does not run yet."""

from __future__ import annotations

from typing import ClassVar, Literal

from irsim_gym.scenario.options import kind, option


@kind
class Ackermann:
    """A car, steered at its front axle; command: speed [m/s] and steering angle [rad] or yaw rate [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("linear", "steer")
    state_size: ClassVar[int] = 4

    mode: Literal["steer", "angular"] = option("steer", meaning="Second component: steering angle, or yaw rate.")
    wheelbase: float | None = option(None, gt=0.0, unit="m", meaning="Axle distance; by default the shape's.")
    noise: bool = option(False, meaning="Add motion noise.")
    alpha: tuple[float, float, float, float] = option((0.03, 0.0, 0.0, 0.03), meaning="Variances of the motion noise.")
