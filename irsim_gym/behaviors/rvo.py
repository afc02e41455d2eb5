"""Sampled reciprocal velocity obstacles. Its options are known; it does not run yet."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, Literal

from irsim_gym.scenario.options import crossed_bounds, kind, option


@kind
class Rvo:
    """Pick the sampled velocity nearest to the preferred one that leads to no collision."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")

    wander: bool = option(False, meaning="Draw a new random goal after each arrival.")
    loop: bool = option(False, meaning="Begin again with the first goal after the last.")
    target_roles: Literal["all", "robot", "obstacle"] = option("all", meaning="Which other bodies are avoided.")
    range_low: tuple[float, float, float] = option(
        (0.0, 0.0, -math.pi), unit="m, m, rad", meaning="Lower bounds of a wandering body's goals."
    )
    range_high: tuple[float, float, float] = option(
        (10.0, 10.0, math.pi), unit="m, m, rad", meaning="Upper bounds of a wandering body's goals."
    )
    vxmax: float = option(1.5, ge=0.0, unit="m/s", meaning="Greatest sampled velocity in x.")
    vymax: float = option(1.5, ge=0.0, unit="m/s", meaning="Greatest sampled velocity in y.")
    acce: float = option(1.0, gt=0.0, unit="m/s", meaning="Greatest change of each sampled velocity in a step.")
    factor: float = option(1.0, ge=0.0, meaning="Weight of the time to collision where every sample collides.")
    mode: Literal["rvo", "hrvo", "vo"] = option("rvo", meaning="How the cone of forbidden velocities is placed.")
    neighbor_threshold: float = option(3.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from crossed_bounds(self.range_low, self.range_high)
