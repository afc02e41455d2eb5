"""Options that local planners share: goals, perception, path and costs."""

from typing import Literal

from irsim_gym.base.options import kind, option
from irsim_gym.scenario.specs.wander_goals import RenewsGoals


@kind
class LocalPlanner(RenewsGoals):
    """The common options of ``dwa`` and ``mppi``."""

    path: Literal["straight", "map", "seen"] = option(
        "seen",
        meaning="The path to follow: straight (to the goal), map (the shortest one around the map and all that never "
        "moves), or seen (a short one around what its own scans have shown).",
    )
    path_clearance: float = option(
        0.1, ge=0.0, unit="m", meaning="Distance of a path from obstacles, where there is room for it."
    )
    memory: float = option(60.0, gt=0.0, unit="s", meaning="How long path seen remembers what a scan has shown.")
    lookahead: float = option(
        4.0,
        gt=0.0,
        unit="m",
        meaning="Length of the part of the path that counts.",
        consequence="Shorter than what it can drive in the time that it looks ahead: it drives slower.",
    )
    forward_point: float = option(
        0.3,
        ge=0.0,
        unit="m",
        meaning="For diff and acker, ways are measured at a point this far ahead of the body, or less near the goal, "
        "so that turns count.",
    )
    footprint_padding: float = option(
        0.02,
        ge=0.0,
        unit="m",
        meaning="Added to the footprint. A body that is nearer to something already may move if it gets no nearer.",
    )
    obstacle_range: float = option(2.5, gt=0.0, unit="m", meaning="Hits farther from the sensor are ignored.")
    spacing: float = option(
        0.02, ge=0.0, unit="m", meaning="A hit closer than this to that of the beam before is ignored."
    )
    inflation_radius: float = option(
        0.5, ge=0.0, unit="m", meaning="Obstacles farther than this from the padded footprint cost nothing."
    )
    cost_scaling: float = option(
        5.0, ge=0.0, unit="1/m", meaning="How fast the cost of obstacles falls with the distance."
    )
    path_weight: float = option(0.5, ge=0.0, meaning="Weight of the distance from the path.")
    goal_weight: float = option(1.0, ge=0.0, meaning="Weight of the rest of the path.")
