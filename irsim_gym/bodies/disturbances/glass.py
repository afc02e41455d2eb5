"""glass: standing bodies that scanners see only where they look straight at them."""

from typing import Annotated, ClassVar

import numpy as np

from irsim_gym.base.arraytypes import BodyOutline, Flags, Floats
from irsim_gym.base.options import Bounds, Drawn
from irsim_gym.base.rng import mix, stream_base, uniform
from irsim_gym.bodies.sensors.scan_tables import mount_pose
from irsim_gym.simulator.geometry.segments import point_segment_distance2
from irsim_gym.simulator.world.disturbed import Disturbed
from irsim_gym.simulator.world.names import Group, Ints, Model, OwnScan, Shard, State, kernel, kind, option, outline_of

GLASS = stream_base("glass", "bodies")
NEAR = 0.1
"""A beam that ends this near to an outline [m] has hit it: noisy ranges do not end on it."""
TINY = 1e-9
"""Lower bound of lengths by which is divided [m]."""


@kind
class Glass:
    """Some standing bodies are of glass: beams that do not hit them nearly at right angles read range_max.

    What is behind glass is not seen. All robots with this disturbance agree on what is of glass; maps never are.
    """

    acts_on: ClassVar[str] = "scan"

    share: Annotated[Drawn, Bounds(0.0, 1.0)] = option(0.0, meaning="Probability, in each level, that a body is.")
    seen_within: Annotated[Drawn, Bounds(0.0, 0.5 * np.pi)] = option(
        0.3, unit="rad", meaning="Greatest angle between a beam that is reflected and the normal of the surface."
    )

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> None:
        """Make room for marks of the bodies of glass."""
        group.arrays["glass"] = np.zeros((*group.tables.count.shape, len(model.stands)), np.bool_)

    @staticmethod
    def disturb(group: Group, model: Model, state: State, shard: Shard) -> None:
        """Overwrite the ranges of beams that glass does not reflect."""
        worlds, disturbed, arrays = shard.worlds, group.tables, group.arrays
        choose_glass(worlds, disturbed, arrays["glass"], model)
        look_through(worlds, disturbed, group.scan, arrays["mounts"], arrays["glass"], model, state)


@kernel
def choose_glass(worlds: Ints, disturbed: Disturbed, glass: Flags, model: Model) -> None:
    """Draw what is of glass, ``(n_worlds, n_members, n_bodies)``, where an episode begins.

    Reads: disturbed (count, random, values), model (level_random, stands).
    Writes: disturbed (count, random), glass.
    """
    for w in worlds:
        for k in range(glass.shape[1]):
            if disturbed.count[w, k] == 0:
                # One stream for all members, and for a robot that begins anew.
                disturbed.random[w, k] = mix(model.level_random[w] ^ GLASS)
                for b in range(glass.shape[2]):
                    is_drawn = uniform(disturbed.random[w], k, 0.0, 1.0) < disturbed.values[w, k, 0]
                    glass[w, k, b] = is_drawn and model.stands[b]
            disturbed.count[w, k] += 1


@kernel
def look_through(
    worlds: Ints, disturbed: Disturbed, scan: OwnScan, mounts: Floats, glass: Flags, model: Model, state: State
) -> None:
    """Overwrite the ranges of beams that meet glass at too small an angle.

    Reads: disturbed (members, values), scan (angles, offset, range_max, ranges, sensors), model (disc_count,
        disc_start, present, segment_count, segment_start, solid), state (discs, pose, segments).
    Writes: scan (ranges).
    """
    for w in worlds:
        for k in range(scan.sensors.shape[0]):
            s, body, least = scan.sensors[k], disturbed.members[k], np.cos(disturbed.values[w, k, 1])
            x, y, heading = mount_pose(state.pose[w, body], mounts[w, s])
            for i in range(scan.ranges.shape[2]):
                far, angle = scan.ranges[w, s, i], heading + scan.angles[s, i] - scan.offset[s, 2]
                dx, dy = np.cos(angle), np.sin(angle)
                end_x, end_y = x + far * dx, y + far * dy
                for b in range(glass.shape[2]):
                    is_glass = glass[w, k, b] and model.present[w, b] and b != body and far < scan.range_max[s]
                    if is_glass and straightness(end_x, end_y, dx, dy, outline_of(model, state, w, b)) < least:
                        scan.ranges[w, s, i] = scan.range_max[s]


@kernel
def straightness(x: float, y: float, dx: float, dy: float, outline: BodyOutline) -> float:
    """Return the cosine of a beam's angle with the normal of an outline; 1 where the beam does not end on it.

    Args:
        x: Where the beam ends [m].
        y: Likewise.
        dx: Unit vector along the beam.
        dy: Likewise.
        outline: The outline.
    """
    cosine, least2, segments = 1.0, NEAR * NEAR, outline.segments
    for s in range(outline.first_segment, outline.first_segment + outline.n_segments):
        ax, ay, bx, by = segments[s, 0], segments[s, 1], segments[s, 2], segments[s, 3]
        gap2, length = point_segment_distance2(x, y, ax, ay, bx, by), np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        if gap2 < least2:
            least2, cosine = gap2, np.abs((bx - ax) * dy - (by - ay) * dx) / max(length, TINY)
    for d in range(outline.first_disc, outline.first_disc + outline.n_discs):
        ax, ay = x - outline.discs[d, 0], y - outline.discs[d, 1]
        length = np.sqrt(ax * ax + ay * ay)
        if (length - outline.discs[d, 2]) ** 2 < least2:
            least2, cosine = (length - outline.discs[d, 2]) ** 2, np.abs(ax * dx + ay * dy) / max(length, TINY)
    return float(cosine)
