"""Common parts of all range sensors: beams, readings, and the order of a scan."""

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.bodies.sensors import hits, noise
from irsim_gym.bodies.sensors.casting import cast_bodies, cast_discs, cast_segments
from irsim_gym.bodies.sensors.cell_scan import scan_cells
from irsim_gym.bodies.sensors.reports import scan_points
from irsim_gym.bodies.sensors.scan_tables import ScanTables
from irsim_gym.simulator.cell_maps.cell_rays import N_FLOATS, N_INTEGERS
from irsim_gym.simulator.geometry.polygons import contains_point
from irsim_gym.simulator.geometry.ray_chunks import BLOCK, CHUNK, DISCS, ROUNDS, SIDES, Eye
from irsim_gym.simulator.world.arrays import aligned
from irsim_gym.simulator.world.names import Floats, Group, Model, Outline, Pose, Rays, Shard, State, kind, option

FULL_TURN = 2.0 * np.pi


def range_problems(options: Any) -> Iterator[tuple[str, str]]:
    """Yield key and message of invalid or conflicting options of a range sensor."""
    if options.range_min > options.range_max:
        yield "range_min", f"must not exceed range_max, got {options.range_min:g} and {options.range_max:g}"


def sweep(options: Any) -> float:
    """Return the angle between first and last beam [rad]: ``angle_range``, at most a full turn."""
    return float(min(options.angle_range, FULL_TURN))


def beam_angles(options: Any) -> Floats:
    """Return the beams' directions in the sensor frame [rad], shape ``(n_beams,)``; a single beam looks ahead."""
    half = 0.5 * sweep(options)
    return np.linspace(-half, half, options.number) if options.number > 1 else np.zeros(1)


@kind
class RangeSensor:
    """What range sensors have in common."""

    reading: ClassVar[str] = "ranges"

    number: int = option(100, ge=1, le=100_000, meaning="Number of beams.", consequence="Few: thin things are missed.")
    angle_range: float = option(
        np.pi,
        ge=0.0,
        unit="rad",
        meaning="Angle between first and last beam; at most 2 pi, where both look the same way.",
        consequence="Degrees instead of radians give a full turn.",
    )
    range_min: float = option(0.0, ge=0.0, unit="m", meaning="Shorter ranges are this value and marked invalid.")
    range_max: float = option(10.0, gt=0.0, unit="m", meaning="Maximum range; a beam that hits nothing reports this.")
    scan_time: float = option(0.1, gt=0.0, unit="s", meaning="Duration of a scan; for information only.")
    noise: bool = option(False, meaning="Add noise to ranges and directions; beams that hit nothing keep their range.")
    std: float = option(0.2, ge=0.0, unit="m", meaning="Standard deviation of the range noise.")
    angle_std: float = option(0.02, ge=0.0, unit="rad", meaning="With noise, standard deviation of the directions.")
    offset: Pose = option((0.0, 0.0, 0.0), unit="m, m, rad", meaning="Mount pose in the body frame.")

    problems = range_problems
    angles = beam_angles
    points = staticmethod(scan_points)


def prepare(group: Group, outlines: list[Outline], model: Model, n_slots: int, *, finds_hits: bool = False) -> None:
    """Allocate the tables of a group of range sensors, and its readings by name.

    These are ``ranges`` [m], shape ``(n_worlds, n_members, n_beams)``, ``angles`` [rad], shape ``(n_beams,)``,
    ``cast_angles`` [rad], shape ``(n_rows, n_beams)``, and with ``finds_hits`` also ``hit``, see ``ScanTables``.

    Args:
        group: The members.
        outlines: Each member's own outline, for ``footprint``: the distance [m] from the sensor to it along
            each beam, shape ``(n_members, n_beams)``, 0 where the sensor stands outside.
        model: The constants, allocated.
        n_slots: Number of shards, each with a scratch row of its own.
        finds_hits: Whether to find which body each beam hits.
    """
    first, angles = group.options[0], beam_angles(group.options[0])
    n_worlds, n_members, n_beams = len(model.present), len(group.members), len(angles)
    # Tables of beams hold whole blocks; the places after the last beam look ahead (direction 0), and nobody reads them.
    padded, spread = -(-n_beams // BLOCK) * BLOCK, angles[-1] - angles[0]
    directions = np.concatenate([angles, np.zeros(padded - n_beams)])
    # Without noise, all members look in the same directions at all times and share one row.
    n_rows = n_worlds * n_members if first.noise else 1
    names = "offset", "range_min", "range_max", "std", "angle_std"
    numbers = {name: np.array([getattr(option, name) for option in group.options], np.float64) for name in names}
    ranges = np.tile(numbers["range_max"].astype(np.float32)[None, :, None], (n_worlds, 1, n_beams))
    tables = group.tables = ScanTables(
        members=group.members,
        offset=np.tile(numbers["offset"], (n_worlds, 1, 1)),
        range_min=numbers["range_min"],
        range_max=numbers["range_max"],
        cast_min=np.zeros(n_members) if first.noise or finds_hits else numbers["range_min"],
        range_std=numbers["std"],
        angle_std=numbers["angle_std"],
        first=float(angles[0]),
        density=0.0 if first.noise or spread == 0.0 else float((n_beams - 1) / spread),
        angles=angles,
        cast_angles=np.tile(angles, (n_rows, 1)),
        beams_x=np.tile(np.cos(directions).astype(np.float32), (n_rows, 1)),
        beams_y=np.tile(np.sin(directions).astype(np.float32), (n_rows, 1)),
        ranges=ranges,
        # Empty, not None: tables of one type, for which kernels are compiled once.
        hit=np.full(ranges.shape if finds_hits else (0, 0, 0), -1, np.int64),
        ends=np.zeros((n_slots, 4 * CHUNK)),
        limits=np.zeros((n_slots, CHUNK)),
        discs=aligned((n_slots,), DISCS),
        sides=aligned((n_slots,), SIDES),
        rounds=aligned((n_slots,), ROUNDS),
        rays=aligned((n_slots, 3 * padded), np.float32),
        inverse=np.zeros((n_slots, padded), np.float32),
        nearest=np.zeros((n_slots, padded if finds_hits else 0), np.float32),
        walk_floats=aligned((n_slots, N_FLOATS), np.float32),
        walk_integers=aligned((n_slots, N_INTEGERS), np.int32),
    )
    footprint = np.array([own_extent(group, k, outline) for k, outline in enumerate(outlines)])
    group.arrays = {"angles": angles, "cast_angles": tables.cast_angles, "ranges": ranges, "footprint": footprint}
    if finds_hits:
        group.arrays["hit"] = tables.hit


def own_extent(group: Group, k: int, outline: Outline) -> Rays:
    """Return the distance [m] from member k's sensor to its own outline along each beam, shape ``(n_beams,)``.

    Code for discs and for segments is compiled only for outlines that have them.
    """
    x, y, turn = map(float, group.options[k].offset)
    eye = Eye(x, y, float(np.cos(turn)), float(np.sin(turn)))
    beams_x, beams_y = group.tables.beams_x[0], group.tables.beams_y[0]
    inverse = np.zeros_like(beams_x)
    if inside(outline, x, y):
        if len(outline.segments):
            cast_segments(outline.segments, eye, beams_x, beams_y, inverse)
        if len(outline.discs):
            cast_discs(outline.discs, eye, beams_x, beams_y, inverse)
    extent: Rays = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0.0)
    return extent[: len(group.tables.angles)]


def inside(outline: Outline, x: float, y: float) -> bool:
    """Return whether a point of the body frame lies inside the outline."""
    offsets = outline.discs[:, :2] - [x, y]
    if bool(np.any(np.sum(offsets * offsets, axis=1) <= outline.discs[:, 2] * outline.discs[:, 2])):
        return True
    return outline.solid and bool(contains_point(outline.segments, 0, len(outline.segments), (x, y)))


def scan(group: Group, model: Model, state: State, shard: Shard) -> None:
    """Write the ranges of the members and, if ``prepare`` was told to find hits, which body each beam hits."""
    worlds, slot, tables = shard.worlds, shard.slot, group.tables
    is_noisy, finds_hits = group.options[0].noise, "hit" in group.arrays
    if is_noisy:
        noise.draw_directions(worlds, tables, state)
    cast_bodies(worlds, slot, tables, model, state)
    if (cells := model.cells) is not None:
        scan_cells(worlds, slot, tables, cells, model, state)
    if finds_hits:
        hits.find_hits(worlds, slot, tables, model, state)
    if is_noisy:
        noise.add_range_noise(worlds, tables, state)
    elif finds_hits:
        hits.raise_ranges(worlds, tables)
