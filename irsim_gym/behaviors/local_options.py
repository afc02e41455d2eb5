"""Options that local planners share: what they see, which path they follow, and what a way costs."""

from __future__ import annotations

from typing import Literal

from irsim_gym.scenario.options import option

Path = Literal["straight", "map", "seen"]

PATH = option(
    "seen",
    meaning="The path to follow: straight to the goal; the shortest around all that never moves and the map; or a "
    "short one around what its own scans have shown.",
)
PATH_CLEARANCE = option(0.1, ge=0.0, unit="m", meaning="How far a path keeps from obstacles, or less where it has to.")
MEMORY = option(60.0, gt=0.0, unit="s", meaning="How long path seen remembers what a scan has shown.")
LOOKAHEAD = option(
    4.0,
    gt=0.0,
    unit="m",
    meaning="So much of the path counts.",
    consequence="Less than it can drive in the time that is looked ahead: it goes slower.",
)
FORWARD_POINT = option(
    0.3,
    ge=0.0,
    unit="m",
    meaning="Ways of diff and acker are measured so far ahead of the body, or less near the goal, so that turns count.",
)
PADDING = option(
    0.02, ge=0.0, unit="m", meaning="Added to the footprint; who is nearer already may go where it is no nearer."
)
OBSTACLE_RANGE = option(2.5, gt=0.0, unit="m", meaning="Hits farther from the sensor are not seen.")
SPACING = option(
    0.02, ge=0.0, unit="m", meaning="A hit nearer than this to the one of the beam before it is passed over."
)
INFLATION_RADIUS = option(
    0.5, ge=0.0, unit="m", meaning="Obstacles farther than this from the padded footprint cost nothing."
)
COST_SCALING = option(5.0, ge=0.0, unit="1/m", meaning="How fast the cost of obstacles falls with the distance.")
