"""The tables of range sensors for kernels."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.simulator.geometry.angles import turned
from irsim_gym.simulator.geometry.ray_chunks import Eye
from irsim_gym.simulator.world.names import Floats, Ints, Labels, Rays, Records, Struct, kernel


@dataclass(repr=False)
class ScanTables(Struct):
    """A group of range sensors with equal beams.

    These are the options of all kinds of range sensors that kernels read: with records of the options themselves, the
    kernels of a world with two kinds would be compiled twice.

    The directions of member k in world w are row ``w * n_members + k`` of ``cast_angles``, ``beams_x`` and ``beams_y``,
    or the only row (``beam_row``). Arrays with a slot are scratch memory, one row for each shard; for those of
    ``CHUNK`` primitives see ``simulator.geometry.ray_chunks``.

    Attributes:
        members: Body of each sensor, shape ``(n_members,)``.
        offset: Mount poses in the body frame [m, m, rad], shape ``(n_worlds, n_members, 3)``.
        range_min: Shortest range that is reported [m], shape ``(n_members,)``.
        range_max: Range of a free beam [m], shape ``(n_members,)``.
        cast_min: Shortest range while beams are cast [m]: 0 where a later pass applies ``range_min``, shape
            ``(n_members,)``.
        range_std: Standard deviation of the range noise [m], shape ``(n_members,)``.
        angle_std: Standard deviation of the directions [rad], shape ``(n_members,)``.
        first: Direction of the first beam [rad].
        density: Beams per rad; 0 where beams are not evenly spread.
        angles: Nominal directions in the sensor frame [rad], shape ``(n_beams,)``.
        cast_angles: Directions in which beams are cast [rad], shape ``(n_rows, n_beams)``.
        beams_x: Cosines of ``cast_angles``, padded to a multiple of ``BLOCK``, shape ``(n_rows, n_padded)``.
        beams_y: Sines of ``cast_angles``, as ``beams_x``.
        ranges: The readings [m], shape ``(n_worlds, n_members, n_beams)``.
        hit: Body that each beam hits, -1 for none; shaped as ``ranges``, empty unless velocities are reported.
        ends: Ends of segments [m], one after the other: ax, ay, bx, by, shape ``(n_slots, 4 * CHUNK)``.
        limits: From which sides segments are seen, see ``prepare_segments``, shape ``(n_slots, CHUNK)``.
        discs: Discs, ``DISCS``, shape ``(n_slots,)``.
        sides: What beams need to know of the segments, ``SIDES``, shape ``(n_slots,)``.
        rounds: What beams need to know of the discs, ``ROUNDS``, shape ``(n_slots,)``.
        rays: Inverse depths and directions, see ``lay_beams``, shape ``(n_slots, 3 * n_padded)``.
        inverse: Inverse depths [1/m], shape ``(n_slots, n_padded)``.
        nearest: Inverse depths of the nearest body [1/m], shape ``(n_slots, n_padded)``; empty as ``hit`` is.
        walk_floats: See ``simulator.cell_maps.cell_rays``, shape ``(n_slots, N_FLOATS)``.
        walk_integers: See ``simulator.cell_maps.cell_rays``, shape ``(n_slots, N_INTEGERS)``.
    """

    members: Ints
    offset: Floats
    range_min: Floats
    range_max: Floats
    cast_min: Floats
    range_std: Floats
    angle_std: Floats
    first: float
    density: float
    angles: Floats
    cast_angles: Floats
    beams_x: Rays
    beams_y: Rays
    ranges: Rays
    hit: Ints
    ends: Floats
    limits: Floats
    discs: Records
    sides: Records
    rounds: Records
    rays: Rays
    inverse: Rays
    nearest: Rays
    walk_floats: Rays
    walk_integers: Labels


@kernel(inlined=True)
def beam_row(w: int, k: int, tables: ScanTables) -> int:
    """Return the row that holds the directions of member k in world w."""
    return w * tables.members.shape[0] + k if tables.beams_x.shape[0] > 1 else 0


@kernel(inlined=True)
def mount(pose: Floats, direction: Floats, offset: Floats) -> Eye:
    """Return where a sensor with a mount pose is; ``direction`` holds cosine and sine of the last heading."""
    cosine, sine = turned(pose[2], direction)
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    # A sensor that is mounted straight ahead has the heading of its body, whose cosine and sine are known.
    if offset[2] != 0.0:
        cosine, sine = np.cos(pose[2] + offset[2]), np.sin(pose[2] + offset[2])
    return Eye(x, y, cosine, sine)


@kernel
def mount_pose(pose: Floats, offset: Floats) -> tuple[float, float, float]:
    """Return the sensor's pose in the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    return x, y, pose[2] + offset[2]
