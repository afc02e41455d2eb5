"""What all range sensors share: their beams, their readings, and the order in which a scan is taken."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from irsim_gym.arraytypes import Floats, Rays
from irsim_gym.geometry.cell_rays import N_FLOATS, N_INTEGERS
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.ray_chunks import BLOCK, CHUNK
from irsim_gym.sensors import hits, noise
from irsim_gym.sensors.casting import cast_bodies, cast_discs, cast_segments
from irsim_gym.sensors.cell_scan import scan_cells
from irsim_gym.sensors.room_casting import cast_room, is_small
from irsim_gym.world.arrays import aligned
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import Outline
from irsim_gym.world.state import WorldState

FULL_TURN = 2.0 * np.pi


def range_problems(options: Any) -> Iterator[tuple[str, str]]:
    """Yield key and message of what cannot be in a range sensor's options."""
    if options.range_min > options.range_max:
        yield "range_min", f"must not exceed range_max, got {options.range_min:g} and {options.range_max:g}"


def sweep(options: Any) -> float:
    """Return the angle between first and last beam [rad]: ``angle_range``, at most a full turn."""
    return float(min(options.angle_range, FULL_TURN))


def beam_angles(options: Any) -> Floats:
    """Return the beams' directions in the sensor frame [rad], shape ``(n_beams,)``; a single beam looks ahead."""
    half = 0.5 * sweep(options)
    return np.linspace(-half, half, options.number) if options.number > 1 else np.zeros(1)


def prepare(group: Group, outlines: list[Outline], model: WorldModel, n_slots: int) -> None:
    """Allocate the readings and tables of a group of range sensors.

    ``ranges`` [m] has shape ``(n_worlds, n_members, n_beams)``, ``angles`` [rad] the nominal directions in the sensor
    frame ``(n_beams,)``. ``cast_angles`` ``(n_rows, n_beams)`` and the unit vectors ``beams_x``, ``beams_y`` ``(n_rows,
    n_padded)`` are the directions in which beams are cast: one row for all, or with noise one for each world and
    member, ``w * n_members + k``. ``cast_params`` are the members' options as the casting sees them.

    Args:
        group: The members.
        outlines: Each member's own outline, for ``footprint``: the distance [m] from the sensor to it along
            each beam, shape ``(n_members, n_beams)``, 0 where the sensor stands outside.
        model: The constants, allocated.
        n_slots: Number of shards, each with a scratch row of its own.
    """
    angles = beam_angles(group.options[0])
    padded = -(-len(angles) // BLOCK) * BLOCK
    n_worlds, n_members = len(model.present), len(group.members)
    is_noisy, spread = group.options[0].noise, angles[-1] - angles[0]
    n_rows = n_worlds * n_members if is_noisy else 1
    directions = np.concatenate([angles, np.zeros(padded - len(angles))])
    far = np.array([option.range_max for option in group.options], np.float32)
    group.arrays = {
        "angles": angles,
        "cast_angles": np.tile(angles, (n_rows, 1)),
        "beams_x": np.tile(np.cos(directions).astype(np.float32), (n_rows, 1)),
        "beams_y": np.tile(np.sin(directions).astype(np.float32), (n_rows, 1)),
        "cast_params": group.params,
        "fan": np.array([angles[0], 0.0 if is_noisy or spread == 0.0 else (len(angles) - 1) / spread]),
        "near": np.zeros((n_slots, 8 * CHUNK)),
        "slopes": aligned((n_slots, 14 * CHUNK), np.float32),
        "spans": aligned((n_slots, 8 * CHUNK), np.int32),
        "rays": aligned((n_slots, 3 * padded), np.float32),
        "inverse": np.zeros((n_slots, padded), np.float32),
        "listed": np.zeros((n_slots, 3 * CHUNK), np.int64),
        "ranges": np.tile(far[None, :, None], (n_worlds, 1, len(angles))),
        "footprint": np.zeros((n_members, len(angles)), np.float32),
    }
    group.arrays["walk_floats"] = aligned((n_slots, N_FLOATS), np.float32)
    group.arrays["walk_integers"] = aligned((n_slots, N_INTEGERS), np.int32)
    if is_noisy:
        noise.prepare(group)
    for k, outline in enumerate(outlines):
        group.arrays["footprint"][k] = own_extent(group, k, outline)


def own_extent(group: Group, k: int, outline: Outline) -> Rays:
    """Return the distance [m] from member k's sensor to its own outline along each beam, shape ``(n_beams,)``.

    What most outlines do not have is not compiled for them: discs, or segments.
    """
    x, y, turn = group.options[k].offset
    beams_x, beams_y = group.arrays["beams_x"][0], group.arrays["beams_y"][0]
    inverse = np.zeros_like(beams_x)
    if inside(outline, x, y):
        if len(outline.segments):
            cast_segments(x, y, np.cos(turn), np.sin(turn), outline.segments, beams_x, beams_y, inverse)
        if len(outline.discs):
            cast_discs(x, y, np.cos(turn), np.sin(turn), outline.discs, beams_x, beams_y, inverse)
    extent: Rays = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0.0)
    return extent[: len(group.arrays["angles"])]


def inside(outline: Outline, x: float, y: float) -> bool:
    """Return whether a point of the body frame lies within the outline's area."""
    offsets = outline.discs[:, :2] - [x, y]
    if bool(np.any(np.sum(offsets * offsets, axis=1) <= outline.discs[:, 2] * outline.discs[:, 2])):
        return True
    return outline.solid and bool(contains_point(outline.segments, 0, len(outline.segments), x, y))


def scan(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write the members' ranges, and what is hit where that is asked for (``hits.prepare``)."""
    table, is_noisy = group.arrays, group.options[0].noise
    if is_noisy:
        noise.turn_beams(group, state, shard)
    cast(group, model, state, shard)
    if (cells := model.cells) is not None:
        members, params = group.members, table["cast_params"]
        scan_cells(
            shard.worlds,
            members,
            params,
            table["beams_x"],
            table["beams_y"],
            cells,
            model,
            state,
            table["walk_floats"][shard.slot],
            table["walk_integers"][shard.slot],
            table["ranges"],
        )
    if "hit" in table:
        hits.find(group, model, state, shard)
    if is_noisy:
        noise.blur_ranges(group, state, shard)
    elif "hit" in table:
        hits.clip(group, shard)


def cast(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Write what the members' beams meet of bodies."""
    table, slot = group.arrays, shard.slot
    if is_small(model):
        cast_room(
            shard.worlds,
            group.members,
            table["cast_params"],
            table["fan"],
            table["beams_x"],
            table["beams_y"],
            model,
            state,
            table["near"][slot],
            table["slopes"][slot],
            table["spans"][slot],
            table["rays"][slot],
            table["inverse"][slot],
            table["listed"][slot],
            table["ranges"],
        )
    else:
        cast_bodies(
            shard.worlds,
            group.members,
            table["cast_params"],
            table["fan"],
            table["beams_x"],
            table["beams_y"],
            model,
            state,
            table["near"][slot],
            table["slopes"][slot],
            table["spans"][slot],
            table["rays"][slot],
            table["inverse"][slot],
            table["ranges"],
        )
