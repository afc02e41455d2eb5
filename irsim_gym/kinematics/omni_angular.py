"""Omnidirectional drive with rotation. Its options are known; it does not run yet."""

from __future__ import annotations

from typing import ClassVar

from irsim_gym.scenario.options import kind, option


@kind
class OmniAngular:
    """Moves in any direction while turning; command: forward, left [m/s] and angular velocity [rad/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("forward", "left", "angular")
    state_size: ClassVar[int] = 3

    noise: bool = option(False, meaning="Add motion noise.")
    alpha: tuple[float, float, float] = option(
        (0.03, 0.03, 0.03), meaning="Variances of the motion noise of the three components."
    )
