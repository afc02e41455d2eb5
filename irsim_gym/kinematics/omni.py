"""Omnidirectional drive without rotation. Its options are known; it does not run yet."""

from __future__ import annotations

from typing import ClassVar, Literal

from irsim_gym.scenario.options import kind, option


@kind
class Omni:
    """Moves in any direction and keeps its heading; command: two velocities [m/s]."""

    command_names: ClassVar[tuple[str, ...]] = ("x", "y")
    state_size: ClassVar[int] = 3

    frame: Literal["world", "body"] = option("world", meaning="Frame of the command: the world's, or forward and left.")
    noise: bool = option(False, meaning="Add motion noise.")
    alpha: tuple[float, ...] = option(
        (0.03, 0.03), min_length=2, max_length=4, meaning="Variances of the motion noise along the two axes."
    )
