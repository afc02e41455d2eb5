"""Optimal reciprocal collision avoidance (van den Berg et al. 2011). Its options are known; it does not run yet."""

from __future__ import annotations

from typing import ClassVar

from irsim_gym.scenario.options import kind, option


@kind
class OrcaGroup:
    """All bodies of a group avoid each other, each taking half of the effort."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")

    neighborDist: float = option(15.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")  # noqa: N815
    maxNeighbors: int = option(10, ge=0, meaning="Greatest number of bodies that are seen.")  # noqa: N815
    timeHorizon: float = option(20.0, gt=0.0, unit="s", meaning="Collisions with bodies later than this are ignored.")  # noqa: N815
    timeHorizonObst: float = option(  # noqa: N815
        10.0, gt=0.0, unit="s", meaning="Collisions with walls later than this are ignored."
    )
    safe_radius: float = option(0.1, ge=0.0, unit="m", meaning="Distance added around each body.")
    maxSpeed: float | None = option(None, gt=0.0, unit="m/s", meaning="Greatest speed; by default the drive's.")  # noqa: N815
