"""Noise of range sensors: beams that are cast a little off their directions, and ranges that are a little off.

Each scan takes a fixed number of draws from the world's own stream, whatever the beams meet: first the directions of
all members, then their ranges.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Rays, Words
from irsim_gym.jit import kernel
from irsim_gym.rng import normal
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.state import WorldState


def prepare(group: Group) -> None:
    """Let beams be cast down to distance 0, since noise comes before the lower bound, and keep the deviations [m]."""
    cast = group.params.copy()
    cast["range_min"] = 0.0
    group.arrays["cast_params"] = cast
    # In a record, the name "std" is hidden by a method of numpy's.
    group.arrays["deviation"] = np.array([option.std for option in group.options])


def turn_beams(group: Group, state: WorldState, shard: Shard) -> None:
    """Draw the directions in which the beams of this scan are cast."""
    table = group.arrays
    draw_directions(
        shard.worlds,
        group.params,
        table["angles"],
        state.random,
        table["cast_angles"],
        table["beams_x"],
        table["beams_y"],
    )


def blur_ranges(group: Group, state: WorldState, shard: Shard) -> None:
    """Add noise to the ranges of beams that hit, and bring all into the sensor's band."""
    add_range_noise(shard.worlds, group.params, group.arrays["deviation"], state.random, group.arrays["ranges"])


@kernel
def draw_directions(
    worlds: Ints, params: Any, angles: Floats, random: Words, cast_angles: Floats, beams_x: Rays, beams_y: Rays
) -> None:
    """Write each beam's nominal direction plus noise, and its unit vector, for all members."""
    for w in worlds:
        for k in range(params.shape[0]):
            deviation = params[k].angle_std
            if deviation <= 0.0:
                continue
            row = w * params.shape[0] + k
            for j in range(angles.shape[0]):
                angle = normal(random, w, angles[j], deviation)
                cast_angles[row, j] = angle
                beams_x[row, j], beams_y[row, j] = np.float32(np.cos(angle)), np.float32(np.sin(angle))


@kernel
def add_range_noise(worlds: Ints, params: Any, deviation: Floats, random: Words, ranges: Rays) -> None:
    """Blur the ranges below range_max, then clip them to [range_min, range_max]."""
    for w in worlds:
        for k in range(params.shape[0]):
            shortest, farthest = np.float32(params[k].range_min), np.float32(params[k].range_max)
            for j in range(ranges.shape[2]):
                error = np.float32(normal(random, w, 0.0, deviation[k]))
                if ranges[w, k, j] < farthest:
                    ranges[w, k, j] = min(max(ranges[w, k, j] + error, shortest), farthest)
