"""Social forces (Moussaid et al. 2009): a body is pulled to its goal and pushed by others and by walls."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.behaviors.social_pushes import FADED, follow, planned_velocity
from irsim_gym.behaviors.steering import wanted_velocity
from irsim_gym.behaviors.surroundings import MARGIN, Scene, most_map_walls, scene_of, wall_bodies
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

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

    only_kernels: ClassVar[bool] = True
    kinematics: ClassVar[tuple[str, ...]] = ("diff", "omni")
    reads_neighbors: ClassVar[bool] = True

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

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Reserve scratch memory for what one body sees."""
        reserve(group, model, n_slots)

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands."""
        slot, arrays = shard.slot, group.arrays
        decide_social_force(
            shard.worlds,
            group.members,
            group.params,
            scene_of(model, state),
            model,
            state,
            arrays["among"],
            arrays["lines"],
            arrays["nearby"][slot],
            arrays["sides"][slot],
            arrays["nearest"][slot],
        )


def reserve(group: Group, model: WorldModel, n_slots: int) -> None:
    """Reserve what the forces need: scratch memory, and a list of bodies that walk together, empty so far."""
    reach = FADED * max(options.sigma_obstacle for options in group.options) + float(model.reach.max()) + MARGIN
    group.arrays["among"] = np.zeros(len(model.role), np.bool_)
    group.arrays["lines"] = wall_bodies(model)
    group.arrays["nearby"] = np.zeros((n_slots, len(model.role)), np.int64)
    group.arrays["sides"] = np.zeros((n_slots, most_map_walls(model, reach), 4))
    group.arrays["nearest"] = np.zeros((n_slots, 4, 3))


@kernel
def decide_social_force(
    worlds: Ints,
    members: Ints,
    params: Any,
    scene: Scene,
    model: WorldModel,
    state: WorldState,
    among: Flags,
    lines: Ints,
    nearby: Ints,
    sides: Floats,
    nearest: Floats,
) -> None:
    """Write the commands of bodies that follow social forces; those without a goal stand."""
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            state.command[w, b, 0], state.command[w, b, 1], state.command[w, b, 2] = 0.0, 0.0, 0.0
            if not model.has_goal[b] or not scene.present[w, b]:
                continue
            fastest = model.velocity_max[row_of(model.velocity_max, w), b]
            wanted_x, wanted_y = wanted_velocity(
                scene.pose[w, b, 0], scene.pose[w, b, 1], state.goal[w, b], model.drive[b], fastest
            )
            vx, vy = planned_velocity(
                scene,
                w,
                b,
                params[k],
                among,
                wanted_x,
                wanted_y,
                0.0,
                0.0,
                model.step_time[0],
                False,
                lines,
                nearby,
                sides,
                nearest,
            )
            acceleration = model.acceleration_limit[row_of(model.acceleration_limit, w), b]
            follow(
                model.drive[b],
                scene.pose[w, b, 2],
                vx,
                vy,
                state.velocity[w, b],
                fastest,
                acceleration,
                model.step_time[0],
                state.command[w, b],
            )
