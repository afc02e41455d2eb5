"""Compound: the union of simpler shapes. Its options are known; it does not run yet."""

from __future__ import annotations

from typing import Literal

from irsim_gym.scenario.options import kind, option


@kind
class CompoundPart:
    """One part of a compound."""

    name: Literal["circle", "rectangle", "polygon"] = option(meaning="Shape of the part.")
    pose: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), unit="m, m, rad", meaning="Pose of the part in the body frame."
    )
    radius: float = option(0.2, gt=0.0, unit="m", meaning="Radius of a circle.")
    length: float = option(1.0, gt=0.0, unit="m", meaning="Size of a rectangle along its x axis.")
    width: float = option(1.0, gt=0.0, unit="m", meaning="Size of a rectangle along its y axis.")
    vertices: tuple[tuple[float, float], ...] | None = option(
        None, min_length=3, unit="m", meaning="Corners of a polygon in the part's frame."
    )


@kind
class Compound:
    """The union of several shapes that move as one."""

    parts: tuple[CompoundPart, ...] = option(min_length=1, meaning="The shapes.")
    wheelbase: float | None = option(None, gt=0.0, unit="m", meaning="Axle distance; does not move the outline.")
