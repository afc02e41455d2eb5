"""Paints a scan as an image: what the latest beams of a range sensor show around an agent."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.rendering.raster.sheets import paint
from irsim_gym.tasks.observations.images.painting import LINE, Canvas, Paints, add_side, clear, view_from
from irsim_gym.tasks.observations.scan.ranges import shared_sensors
from irsim_gym.tasks.terms import Bound, Simulation, State, Struct, kernel

UNKNOWN = 127
"""Value of pixels that no beam has seen."""
WIDEST = 0.05
"""Maximum half width of a beam [rad]; it also ends halfway to the neighbouring beam."""


@dataclass
class ScanBeams(Struct):
    """The agents' live ranges and beams.

    Attributes:
        ranges: Readings [m], shape ``(n_worlds, n_members, n_beams)``.
        members: Each agent's row in ``ranges``, shape ``(n_agents,)``.
        mount: Position of the sensor in the body frame [m], shape ``(n_agents, 2)``.
        directions: Unit vectors in the body frame, shape ``(n_agents, n_beams, 2)``.
        spread: Half width of a beam per metre of range.
        do_touch: Whether neighbouring beams touch.
        far: Maximum range [m], shape ``(n_agents,)``.
    """

    ranges: Rays
    members: Ints
    mount: Floats
    directions: Floats
    spread: float
    do_touch: bool
    far: Rays


class Sensor(NamedTuple):
    """Position of a sensor in the world [m], and cosine and sine of its body's heading."""

    x: float
    y: float
    cosine: float
    sine: float


def beams_of(simulation: Simulation, agents: Ints, name: str) -> ScanBeams:
    """Return the agents' live ranges and beams."""
    group, members = shared_sensors(simulation, agents, name)
    angles, mounts = group.arrays["angles"], [group.options[k] for k in members]
    # Half of the angle between neighbouring beams; a single beam is as wide as WIDEST lets it be.
    half = 0.5 * (angles[-1] - angles[0]) / (len(angles) - 1) if len(angles) > 1 else np.inf
    turned = np.array([angles + mount.offset[2] for mount in mounts])
    at = np.array([mount.offset[:2] for mount in mounts], np.float64)
    far = np.array([mount.range_max for mount in mounts], np.float32)
    ways = np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    wide: dict[str, Any] = {"spread": float(np.tan(min(half, WIDEST))), "do_touch": bool(half <= WIDEST)}
    return ScanBeams(ranges=group.arrays["ranges"], members=members, mount=at, directions=ways, far=far, **wide)


@kernel
def paint_scan(
    worlds: Ints, slot: int, term: Bound, beams: ScanBeams, paints: Paints, state: State, image: Bytes
) -> None:
    """Paint a scan into the first channel (free, occupied, ``UNKNOWN``), and clear the others.

    Reads: term (agents, options), beams (directions, do_touch, far, members, mount, ranges, spread), paints (box,
        colours, sheets), state (pose).
    Writes: paints (sheets), image.

    Args:
        worlds: The worlds to treat.
        slot: Slot of the calling thread.
        term: An ``OccupancyImage``.
        beams: The agents' sensors.
        paints: The colours free and occupied, in this order.
        state: Poses of the bodies.
        image: Output, ``(n_worlds, n_agents, pixels, pixels, n_channels)``.
    """
    options, box, sheet = term.options[0], paints.box, paints.sheets[slot]
    scale = options.pixels / options.metres
    for w in worlds:
        for a in range(term.agents.shape[0]):
            picture, at, mount = image[w, a], state.pose[w, term.agents[a]], beams.mount[a]
            clear(picture, 0)
            first = picture[:, :, :1]
            clear(first, UNKNOWN)
            canvas = Canvas(sheet, box, view_from(at, options.rotated != 0, scale, picture.shape[0]))
            cosine, sine = np.cos(at[2]), np.sin(at[2])
            x = at[0] + cosine * mount[0] - sine * mount[1]
            y = at[1] + sine * mount[0] + cosine * mount[1]
            sensor, scan = Sensor(x, y, cosine, sine), beams.ranges[w, beams.members[a]]
            add_fan(canvas, sensor, beams, a, scan)
            paint(first, sheet, box, paints.colours[0], False)
            add_hits(canvas, sensor, beams, a, scan)
            paint(first, sheet, box, paints.colours[1], False)


@kernel
def add_fan(canvas: Canvas, sensor: Sensor, beams: ScanBeams, a: int, scan: Rays) -> None:
    """Add the area that the beams of agent ``a`` have passed; ``scan`` holds its ranges [m], ``(n_beams,)``.

    Reads: beams (directions, do_touch, spread).
    """
    x, y, cosine, sine = sensor
    directions, eye, at = beams.directions[a], (x, y), (x, y)
    for k in range(scan.shape[0]):
        ahead_x = cosine * directions[k, 0] - sine * directions[k, 1]
        ahead_y = sine * directions[k, 0] + cosine * directions[k, 1]
        end_x, end_y, half = x + scan[k] * ahead_x, y + scan[k] * ahead_y, scan[k] * beams.spread
        # Beams that do not touch are triangles of their own: back to the sensor between two of them.
        if k > 0 and not beams.do_touch:
            add_side(canvas, at, eye)
            at = eye
        right = end_x + half * ahead_y, end_y - half * ahead_x
        add_side(canvas, at, right)
        at = end_x - half * ahead_y, end_y + half * ahead_x
        add_side(canvas, right, at)
    add_side(canvas, at, eye)


@kernel
def add_hits(canvas: Canvas, sensor: Sensor, beams: ScanBeams, a: int, scan: Rays) -> None:
    """Add the hits of a scan: behind each end, a piece of wall as wide as the beam, but at least one pixel.

    Reads: beams (directions, far, spread).
    """
    x, y, cosine, sine = sensor
    directions, far, scale = beams.directions[a], beams.far[a], canvas.camera.scale
    for k in range(scan.shape[0]):
        if scan[k] >= far:
            continue
        ahead_x = cosine * directions[k, 0] - sine * directions[k, 1]
        ahead_y = sine * directions[k, 0] + cosine * directions[k, 1]
        near, distant, half = scan[k], scan[k] + LINE / scale, max(scan[k] * beams.spread, 0.5 / scale)
        ax, ay, bx, by = x + near * ahead_x, y + near * ahead_y, x + distant * ahead_x, y + distant * ahead_y
        aside_x, aside_y = half * ahead_y, -half * ahead_x
        near_right, far_right = (ax + aside_x, ay + aside_y), (bx + aside_x, by + aside_y)
        far_left, near_left = (bx - aside_x, by - aside_y), (ax - aside_x, ay - aside_y)
        add_side(canvas, near_right, far_right)
        add_side(canvas, far_right, far_left)
        add_side(canvas, far_left, near_left)
        add_side(canvas, near_left, near_right)
