"""lidar2d: a planar scan of ranges, cast in inverse-depth form."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.geometry.polygons import contains_point
from irsim_gym.geometry.rays import inverse_depth_disc, inverse_depth_segment
from irsim_gym.geometry.segments import point_segment_distance2
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import WorldModel
from irsim_gym.world.outline import Outline
from irsim_gym.world.state import WorldState

LANES = 16


@kind
class Lidar2D:
    """A scanner of ``number`` beams, evenly spread over ``angle_range``, both ends included."""

    reading: ClassVar[str] = "ranges"

    number: int = option(100, ge=1, le=100_000, meaning="Number of beams.")
    angle_range: float = option(np.pi, ge=0.0, unit="rad", meaning="Angle between first and last beam; at most 2 pi.")
    range_min: float = option(0.0, ge=0.0, unit="m", meaning="Shorter ranges are reported as this.")
    range_max: float = option(10.0, gt=0.0, unit="m", meaning="Farther things are not seen; a free beam reports this.")
    scan_time: float = option(0.1, gt=0.0, unit="s", meaning="Duration of a scan; reported only.")
    noise: bool = option(False, meaning="Add noise to the ranges.", planned=True)
    std: float = option(0.2, ge=0.0, unit="m", meaning="Standard deviation of the range noise.")
    angle_std: float = option(0.02, ge=0.0, unit="rad", meaning="Standard deviation of the beams' directions.")
    offset: tuple[float, float, float] = option(
        (0.0, 0.0, 0.0), unit="m, m, rad", meaning="Mount pose in the body frame."
    )
    alpha: float = option(0.3, ge=0.0, le=1.0, meaning="Opacity of the drawn beams.")
    color: str = option("#CC3311", meaning="Colour of the drawn beams.")
    has_velocity: bool = option(False, meaning="Report the velocity of what each beam hits.", planned=True)
    plot: Any = option(None, meaning="Drawing options of the sensor.")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of what cannot be."""
        if self.range_min > self.range_max:
            yield "range_min", f"must not exceed range_max, got {self.range_min:g} and {self.range_max:g}"

    def group_key(self) -> tuple[Any, ...]:
        """Return what members of one group have in common: the beams."""
        return self.number, min(self.angle_range, 2.0 * np.pi)

    def angles(self) -> Floats:
        """Return the beams' directions in the sensor frame [rad], shape ``(n_beams,)``; a single beam looks ahead."""
        half = 0.5 * min(self.angle_range, 2.0 * np.pi)
        return np.linspace(-half, half, self.number) if self.number > 1 else np.zeros(1)

    @staticmethod
    def prepare(group: Group, outlines: list[Outline], model: WorldModel, n_slots: int) -> None:
        """Allocate readings ``ranges`` [m], shape ``(n_worlds, n_members, n_beams)``, and the beam table.

        Args:
            group: The members.
            outlines: Each member's own outline, for ``footprint``: the distance [m] from the sensor to it along
                each beam, shape ``(n_members, n_beams)``, 0 where the sensor stands outside.
            model: The constants, allocated.
            n_slots: Number of shards, each with a scratch row of its own.
        """
        angles = group.options[0].angles()
        padded = -(-len(angles) // LANES) * LANES
        directions = np.concatenate([angles, np.zeros(padded - len(angles))])
        n_worlds, members = len(model.present), len(group.members)
        far = np.array([option.range_max for option in group.options], np.float32)
        group.arrays = {
            "angles": angles,
            "beams_x": np.cos(directions).astype(np.float32),
            "beams_y": np.sin(directions).astype(np.float32),
            "seen": np.zeros((n_slots, model.local_segments.shape[1], 4), np.float32),
            "inverse": np.zeros((n_slots, padded), np.float32),
            "ranges": np.tile(far[None, :, None], (n_worlds, 1, len(angles))),
            "footprint": np.zeros((members, len(angles)), np.float32),
        }
        for k, outline in enumerate(outlines):
            group.arrays["footprint"][k] = own_extent(group, k, outline)

    @staticmethod
    def sense(group: Group, model: WorldModel, state: WorldState, shard: Shard) -> None:
        """Write the members' ranges."""
        scan(
            shard.worlds,
            group.members,
            group.params,
            group.arrays["beams_x"],
            group.arrays["beams_y"],
            state.pose,
            model.present,
            model.unobstructed,
            model.solid,
            model.reach,
            model.segment_start,
            model.segment_count,
            state.segments,
            model.disc_start,
            model.disc_count,
            state.discs,
            group.arrays["seen"][shard.slot],
            group.arrays["inverse"][shard.slot],
            group.arrays["ranges"],
        )


def own_extent(group: Group, k: int, outline: Outline) -> Rays:
    """Return the distance [m] from member k's sensor to its own outline along each beam, shape ``(n_beams,)``."""
    table = group.arrays
    x, y, turn = group.options[k].offset
    inverse = np.zeros_like(table["beams_x"])
    if inside(outline, x, y):
        cast_outline(x, y, np.cos(turn), np.sin(turn), outline.segments, outline.discs, *_beams(table), inverse)
    extent: Rays = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0.0)
    return extent[: len(table["angles"])]


def _beams(table: dict[str, Any]) -> tuple[Rays, Rays]:
    return table["beams_x"], table["beams_y"]


def inside(outline: Outline, x: float, y: float) -> bool:
    """Return whether a point of the body frame lies within the outline's area."""
    offsets = outline.discs[:, :2] - [x, y]
    if bool(np.any(np.sum(offsets * offsets, axis=1) <= outline.discs[:, 2] * outline.discs[:, 2])):
        return True
    return outline.solid and bool(contains_point(outline.segments, 0, len(outline.segments), x, y))


@kernel
def cast_outline(
    x: float,
    y: float,
    cosine: float,
    sine: float,
    segments: Floats,
    discs: Floats,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> None:
    """Cast the beams of a sensor at (x, y) against all rows of an outline, from both sides."""
    for s in range(segments.shape[0]):
        ax, ay, bx, by = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
        cast_segment(ax, ay, bx, by, cosine, sine, beams_x, beams_y, inverse)
    for d in range(discs.shape[0]):
        cast_disc(discs[d, 0] - x, discs[d, 1] - y, discs[d, 2], cosine, sine, beams_x, beams_y, inverse)


@kernel
def cast_segment(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    cosine: float,
    sine: float,
    beams_x: Rays,
    beams_y: Rays,
    inverse: Rays,
) -> None:
    """Cast against a segment given relative to the sensor: turned in float64, then float32."""
    inverse_depth_segment(
        np.float32(cosine * ax + sine * ay),
        np.float32(cosine * ay - sine * ax),
        np.float32(cosine * bx + sine * by),
        np.float32(cosine * by - sine * bx),
        beams_x,
        beams_y,
        inverse,
    )


@kernel
def cast_disc(
    cx: float, cy: float, radius: float, cosine: float, sine: float, beams_x: Rays, beams_y: Rays, inverse: Rays
) -> None:
    """Cast against a disc given relative to the sensor: turned in float64, then float32."""
    inverse_depth_disc(
        np.float32(cosine * cx + sine * cy),
        np.float32(cosine * cy - sine * cx),
        np.float32(radius),
        beams_x,
        beams_y,
        inverse,
    )


@kernel
def scan(
    worlds: Ints,
    members: Ints,
    params: Any,
    beams_x: Rays,
    beams_y: Rays,
    pose: Floats,
    present: Flags,
    unobstructed: Flags,
    solid: Flags,
    reach: Floats,
    segment_start: Ints,
    segment_count: Ints,
    segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    discs: Floats,
    seen: Rays,
    inverse: Rays,
    ranges: Rays,
) -> None:
    """Write the ranges of all members in all given worlds."""
    for i in range(worlds.shape[0]):
        w = worlds[i]
        reaches = reach[w % reach.shape[0]]
        n_segments, n_discs = segment_count[w % segment_count.shape[0]], disc_count[w % disc_count.shape[0]]
        rows, rounds = segments[w], discs[w]
        for k in range(members.shape[0]):
            own, far = members[k], params[k].range_max
            x, y, heading = mount_pose(pose[w, own], params[k].offset)
            cosine, sine = np.cos(heading), np.sin(heading)
            inverse[:] = np.float32(0.0)
            n_seen = 0
            for b in range(present.shape[1]):
                if b == own or unobstructed[b] or not present[w, b]:
                    continue
                near = far + reaches[b]
                dx, dy = pose[w, b, 0] - x, pose[w, b, 1] - y
                distance2 = dx * dx + dy * dy
                if distance2 > near * near:
                    continue
                for d in range(disc_start[b], disc_start[b] + n_discs[b]):
                    cast_disc(rounds[d, 0] - x, rounds[d, 1] - y, rounds[d, 2], cosine, sine, beams_x, beams_y, inverse)
                start, end = segment_start[b], segment_start[b] + n_segments[b]
                two_sided = not solid[b] or (
                    distance2 <= reaches[b] * reaches[b] and contains_point(rows, start, end - start, x, y)
                )
                sure = far - reaches[b]
                in_range = sure > 0.0 and distance2 <= sure * sure
                for s in range(start, end):
                    ax, ay, bx, by = rows[s, 0] - x, rows[s, 1] - y, rows[s, 2] - x, rows[s, 3] - y
                    if (two_sided or faces(ax, ay, bx, by)) and (in_range or is_near(ax, ay, bx, by, far)):
                        seen[n_seen, 0] = np.float32(cosine * ax + sine * ay)
                        seen[n_seen, 1] = np.float32(cosine * ay - sine * ax)
                        seen[n_seen, 2] = np.float32(cosine * bx + sine * by)
                        seen[n_seen, 3] = np.float32(cosine * by - sine * bx)
                        n_seen += 1
            cast_seen(n_seen, seen, beams_x, beams_y, inverse)
            write_ranges(inverse, params[k].range_min, far, ranges[w, k])


@kernel
def cast_seen(count: int, seen: Rays, beams_x: Rays, beams_y: Rays, inverse: Rays) -> None:
    """Cast against the first rows of ``seen``, segments in the sensor frame [m].

    A loop of its own keeps the ray kernel's vector code whole: among the tests of ``scan`` it takes twice the time.
    """
    for s in range(count):
        inverse_depth_segment(seen[s, 0], seen[s, 1], seen[s, 2], seen[s, 3], beams_x, beams_y, inverse)


@kernel
def mount_pose(pose: Floats, offset: Floats) -> tuple[float, float, float]:
    """Return the sensor's pose in the world frame."""
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    x = pose[0] + cosine * offset[0] - sine * offset[1]
    y = pose[1] + sine * offset[0] + cosine * offset[1]
    return x, y, pose[2] + offset[2]


@kernel
def faces(ax: float, ay: float, bx: float, by: float) -> bool:
    """Return whether a segment of a solid body shows its front to the origin.

    Boundaries of solid bodies run counter-clockwise, so their front lies to the right of the segment.
    """
    return (by - ay) * ax - (bx - ax) * ay <= 0.0


@kernel
def is_near(ax: float, ay: float, bx: float, by: float, far: float) -> bool:
    """Return whether a segment comes within ``far`` [m] of the origin."""
    return bool(point_segment_distance2(0.0, 0.0, ax, ay, bx, by) <= far * far)


@kernel
def write_ranges(inverse: Rays, range_min: float, range_max: float, ranges: Rays) -> None:
    """Turn inverse depths into ranges; a beam that meets nothing in range reports range_max."""
    shortest, farthest = np.float32(range_min), np.float32(range_max)
    least = np.float32(1.0) / farthest
    for i in range(ranges.shape[0]):
        depth = np.float32(1.0) / max(inverse[i], least)
        depth = farthest if inverse[i] <= least else depth
        ranges[i] = shortest if depth < shortest else depth
