"""RVO: the sampled velocity nearest to the wanted one that leads to no collision (van den Berg et al. 2008)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, ClassVar, Literal

import numpy as np

from irsim_gym.arraytypes import Floats, Ints
from irsim_gym.behaviors.free_samples import LANES, ROW_NUMBERS, nearest_free, rough_cones
from irsim_gym.behaviors.steering import to_command, wanted_velocity
from irsim_gym.behaviors.surroundings import MARGIN, Scene, look_around, most_map_walls, scene_of, wall_bodies
from irsim_gym.behaviors.velocity_obstacles import (
    CONE,
    PITCH,
    disc_cones,
    lay_samples,
    least_penalty,
    side_cones,
    write_samples,
)
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import crossed_bounds, kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import DIFFERENTIAL, WorldModel
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import WorldState

TURN_TIME, TURN_TOLERANCE, SLOW, TURN_LIMIT = 0.2, 0.1, 0.02, 1.5
"""How a differential drive follows the chosen velocity [s, rad, m/s, rad/s]."""


@kind
class Rvo:
    """Pick the sampled velocity nearest to the preferred one that leads to no collision."""

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
    vxmax: float = option(1.5, ge=0.0, le=100.0, unit="m/s", meaning="Greatest sampled velocity in x.")
    vymax: float = option(1.5, ge=0.0, le=100.0, unit="m/s", meaning="Greatest sampled velocity in y.")
    acce: float = option(
        1.0,
        gt=0.0,
        unit="m/s",
        meaning="Greatest change of each sampled velocity in a step.",
        consequence="The samples lie 0.05 m/s apart: below 0.025 a single one is left, the lowest.",
    )
    factor: float = option(1.0, ge=0.0, meaning="Weight of the time to collision where every sample collides.")
    mode: Literal["rvo", "hrvo", "vo"] = option("rvo", meaning="How the cone of forbidden velocities is placed.")
    neighbor_threshold: float = option(
        3.0,
        ge=0.0,
        unit="m",
        meaning="Bodies farther away than this are not seen: a moving one or a disc by its centre, a standing one with "
        "sides by its outline. Walls of linestrings are seen from anywhere.",
    )

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        yield from crossed_bounds(self.range_low, self.range_high)

    @staticmethod
    def prepare(group: Group, model: WorldModel, n_slots: int) -> None:
        """Reserve scratch memory for what one body sees and tries."""
        n_rounds = len(model.role) + model.local_discs.shape[1]
        n_sides = model.local_segments.shape[1]
        n_sides += max(most_map_walls(model, options.neighbor_threshold) for options in group.options)
        n_samples = _most_samples(group.params)
        group.arrays["lines"] = wall_bodies(model)
        group.arrays["nearby"] = np.zeros((n_slots, len(model.role)), np.int64)
        group.arrays["rounds"] = np.zeros((n_slots, n_rounds, 6))
        group.arrays["sides"] = np.zeros((n_slots, n_sides, 4))
        group.arrays["cones"] = np.zeros((n_slots, n_rounds + n_sides, CONE))
        group.arrays["samples"] = np.zeros((n_slots, 2, n_samples))
        group.arrays["spans"] = np.zeros((n_slots, n_rounds + n_sides, 2 * LANES))
        group.arrays["rows"] = np.zeros((n_slots, ROW_NUMBERS))
        group.arrays["order"] = np.zeros((n_slots, 2, n_samples), np.int64)

    @staticmethod
    def decide(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' commands."""
        slot, arrays = shard.slot, group.arrays
        decide_rvo(
            shard.worlds,
            group.members,
            group.params,
            scene_of(model, state),
            model,
            state,
            arrays["lines"],
            arrays["nearby"][slot],
            arrays["rounds"][slot],
            arrays["sides"][slot],
            arrays["cones"][slot],
            arrays["samples"][slot],
            arrays["order"][slot],
            arrays["spans"][slot],
            arrays["rows"][slot],
        )


def _most_samples(params: Any) -> int:
    """Return an upper bound of the number of velocities that any member tries along an axis."""
    widest = np.minimum(params["acce"], np.maximum(params["vxmax"], params["vymax"])).max()
    return int(2.0 * widest / PITCH) + 3


@kernel
def decide_rvo(
    worlds: Ints,
    members: Ints,
    params: Any,
    scene: Scene,
    model: WorldModel,
    state: WorldState,
    lines: Ints,
    nearby: Ints,
    rounds: Floats,
    sides: Floats,
    cones: Floats,
    samples: Floats,
    order: Ints,
    spans: Floats,
    rows: Floats,
) -> None:
    """Write the commands of bodies that avoid what they see."""
    for w in worlds:
        for k in range(members.shape[0]):
            b, options = members[k], params[k]
            state.command[w, b, 0], state.command[w, b, 1], state.command[w, b, 2] = 0.0, 0.0, 0.0
            if not model.has_goal[b] or not scene.present[w, b]:
                continue
            n_rounds, n_sides = look_around(
                scene, w, b, options.target_roles, options.neighbor_threshold, lines, nearby, rounds, sides
            )
            pose, fastest = scene.pose[w, b], model.velocity_max[row_of(model.velocity_max, w), b]
            wanted_x, wanted_y = wanted_velocity(pose[0], pose[1], state.goal[w, b], model.drive[b], fastest)
            vx, vy = choose_velocity(
                pose[0],
                pose[1],
                scene.twist[w, b],
                scene.radius[row_of(scene.radius, w), b] + MARGIN,
                wanted_x,
                wanted_y,
                options,
                rounds,
                n_rounds,
                sides,
                n_sides,
                cones,
                samples,
                order,
                spans,
                rows,
            )
            alone = n_rounds == 0 and n_sides == 0
            steer(model.drive[b], pose[2], vx, vy, alone, wanted_x, wanted_y, state.command[w, b])


@kernel
def choose_velocity(
    x: float,
    y: float,
    velocity: Floats,
    r: float,
    wanted_x: float,
    wanted_y: float,
    options: Any,
    rounds: Floats,
    n_rounds: int,
    sides: Floats,
    n_sides: int,
    cones: Floats,
    samples: Floats,
    order: Ints,
    spans: Floats,
    rows: Floats,
) -> tuple[float, float]:
    """Return the best of the sampled velocities [m/s]: outside of all cones, or with the least penalty."""
    vx, vy = velocity[0], velocity[1]
    first_x, step_x, n_x = lay_samples(vx, options["acce"], options.vxmax)
    first_y, step_y, n_y = lay_samples(vy, options["acce"], options.vymax)
    n_cones, mode = side_cones(x, y, r, sides, n_sides, cones, n_rounds), options.mode
    rough_cones(mode, x, y, vx, vy, r, rounds, n_rounds, cones)
    best = nearest_free(
        mode, x, y, vx, vy, r, rounds, n_rounds, cones, n_cones, first_x, step_x, n_x, first_y, step_y, n_y,
        wanted_x, wanted_y, spans, rows,
    )  # fmt: skip
    if best >= 0:
        return first_x + (best // n_y) * step_x, first_y + (best % n_y) * step_y
    write_samples(first_x, step_x, n_x, wanted_x, samples[0], order[0])
    write_samples(first_y, step_y, n_y, wanted_y, samples[1], order[1])
    disc_cones(mode, x, y, vx, vy, r, rounds, n_rounds, cones)
    best = least_penalty(
        x, y, vx, vy, r, rounds, n_rounds, sides, n_sides, options.factor, samples, n_x, n_y, wanted_x, wanted_y, order
    )
    return samples[0, best // n_y], samples[1, best % n_y]


@kernel
def steer(
    drive: int, heading: float, vx: float, vy: float, alone: bool, wanted_x: float, wanted_y: float, command: Floats
) -> None:
    """Write the command that follows the chosen velocity.

    A differential drive that would stand although nothing is near has its goal behind it, where no sampled velocity
    leads: it turns on the spot.
    """
    to_command(drive, heading, vx, vy, TURN_TIME, TURN_TOLERANCE, SLOW, TURN_LIMIT, command)
    if drive == DIFFERENTIAL and alone and command[0] == 0.0 and command[1] == 0.0:
        to_command(drive, heading, wanted_x, wanted_y, TURN_TIME, TURN_TOLERANCE, SLOW, TURN_LIMIT, command)
        command[0] = 0.0
