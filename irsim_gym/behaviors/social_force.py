"""Social forces (Moussaid et al. 2009), alone and as a group. The options are known; they do not run yet."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar, Literal

from irsim_gym.scenario.options import crossed_bounds, kind, option

DESIRED = option(1.0, ge=0.0, meaning="Weight of the force towards the goal.")
SOCIAL = option(2.1, ge=0.0, meaning="Weight of the force away from other bodies.")
OBSTACLE = option(10.0, ge=0.0, meaning="Weight of the force away from walls.")
SIGMA = option(0.8, gt=0.0, unit="m", meaning="Distance over which the force of a wall fades.")
IMPORTANCE = option(2.0, ge=0.0, meaning="Weight of relative velocity against relative position.")
GAMMA = option(0.35, gt=0.0, unit="s", meaning="Range of the interaction for each m/s of its velocity.")
ANGULAR = option(2.0, ge=0.0, meaning="Decay of the sideways force with the angle.")
VELOCITY = option(3.0, ge=0.0, meaning="Decay of the braking force with the angle.")
RELAXATION = option(0.5, gt=0.0, unit="s", meaning="Time in which the desired velocity is taken up.")
NEIGHBORS = option(10.0, ge=0.0, unit="m", meaning="Bodies farther away than this are not seen.")
SPEED = option(1.5, gt=0.0, unit="m/s", meaning="Desired and greatest speed.")
SAFETY = option(0.0, ge=0.0, unit="m", meaning="Distance added around each body.")


@kind
class SocialForce:
    """Follow the sum of a pull to the goal and pushes from bodies and walls."""

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
    vmax: float = SPEED
    neighbor_threshold: float = NEIGHBORS
    relaxation_time: float = RELAXATION
    force_factor_desired: float = DESIRED
    force_factor_social: float = SOCIAL
    force_factor_obstacle: float = OBSTACLE
    sigma_obstacle: float = SIGMA
    lambda_importance: float = IMPORTANCE
    gamma: float = GAMMA
    n_angular: float = ANGULAR
    n_velocity: float = VELOCITY
    safety_radius: float = SAFETY

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from crossed_bounds(self.range_low, self.range_high)


@kind
class SocialForceGroup:
    """The same for all bodies of a group, which may walk together in smaller ones."""

    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")

    vmax: float = SPEED
    neighbor_threshold: float = NEIGHBORS
    relaxation_time: float = RELAXATION
    force_factor_desired: float = DESIRED
    force_factor_social: float = SOCIAL
    force_factor_obstacle: float = OBSTACLE
    sigma_obstacle: float = SIGMA
    lambda_importance: float = IMPORTANCE
    gamma: float = GAMMA
    n_angular: float = ANGULAR
    n_velocity: float = VELOCITY
    safety_radius: float = SAFETY
    social_groups: tuple[tuple[int, ...], ...] = option((), meaning="Lists of members who walk together.")
    force_factor_group_coherence: float = option(2.0, ge=0.0, meaning="Weight of the pull to the others of the list.")
    force_factor_group_repulsion: float = option(1.0, ge=0.0, meaning="Weight of the push from those too near.")
    force_factor_group_gaze: float = option(3.0, ge=0.0, meaning="Weight of the force that keeps the others in sight.")
    group_repulsion_threshold: float | None = option(
        None, ge=0.0, unit="m", meaning="Who is nearer than this is too near; by default when the bodies touch."
    )
