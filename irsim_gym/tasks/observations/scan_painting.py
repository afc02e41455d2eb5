"""A scan as a picture: what the latest beams of a range sensor know of the places around an agent."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from irsim_gym.arraytypes import Bytes, Floats, Ints, Rays
from irsim_gym.engine import Simulation
from irsim_gym.jit import kernel
from irsim_gym.raster.sheets import paint
from irsim_gym.tasks.observations.painting import LINE, View, add_side, clear, view_from
from irsim_gym.tasks.observations.ranges import shared_sensors

UNKNOWN = 127
"""What is shown where no beam has been."""
WIDEST = 0.05
"""A beam knows of places up to this angle aside, and not beyond the middle between it and the next one [rad]."""


def scan_tables(simulation: Simulation, agents: Ints, name: str) -> dict[str, NDArray[Any]]:
    """Return the agents' live ranges and beams.

    ``beams`` holds unit vectors in the body frame, shape ``(n_agents, n_beams, 2)``; ``spread`` half the width of a
    beam for each metre, and 1 where neighbours touch, else 0, ``(2,)``; ``mount`` the sensor's place in the body frame
    [m], ``(n_agents, 2)``; ``far`` the greatest range [m], ``(n_agents,)``; ``free`` value and opacity of free places.
    """
    group, members = shared_sensors(simulation, agents, name)
    angles, mounts = group.arrays["angles"], [group.options[k] for k in members]
    half = 0.5 * (angles[-1] - angles[0]) / (len(angles) - 1) if len(angles) > 1 else np.inf
    turned = np.array([angles + mount.offset[2] for mount in mounts])
    return {
        "ranges": group.arrays["ranges"],
        "members": members,
        "mount": np.array([mount.offset[:2] for mount in mounts], np.float64),
        "beams": np.stack([np.cos(turned), np.sin(turned)], axis=-1),
        "spread": np.array([np.tan(min(half, WIDEST)), half <= WIDEST]),
        "far": np.array([mount.range_max for mount in mounts], np.float32),
        "free": np.array([0.0, 1.0]),
    }


@kernel
def paint_scan(
    worlds: Ints,
    agents: Ints,
    rotated: bool,
    scale: float,
    pose: Floats,
    members: Ints,
    mount: Floats,
    beams: Floats,
    spread: Floats,
    far: Rays,
    ranges: Rays,
    free: Floats,
    box: Ints,
    white: Floats,
    sheet: Rays,
    image: Bytes,
) -> None:
    """Paint what a scan knows into the first channel and clear the others: free, occupied, ``UNKNOWN``.

    Args:
        worlds: The worlds to treat.
        agents: Body of each agent.
        rotated: See ``OccupancyImage``.
        scale: Pixels per metre.
        pose: Poses of the bodies.
        members: Each agent's row in ``ranges``.
        mount: See ``scan_tables``.
        beams: See ``scan_tables``.
        spread: See ``scan_tables``.
        far: See ``scan_tables``.
        ranges: Readings [m], ``(n_worlds, n_members, n_beams)``.
        free: Value and opacity of what is free.
        box: The whole picture.
        white: Value and opacity of what is hit.
        sheet: Empty before and after.
        image: Written, ``(n_worlds, n_agents, pixels, pixels, n_channels)``.
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            picture, at = image[w, a], pose[w, agents[a]]
            clear(picture, 0)
            first = picture[:, :, :1]
            clear(first, UNKNOWN)
            view = view_from(at, rotated, scale, picture.shape[0])
            cosine, sine = np.cos(at[2]), np.sin(at[2])
            x = at[0] + cosine * mount[a, 0] - sine * mount[a, 1]
            y = at[1] + sine * mount[a, 0] + cosine * mount[a, 1]
            scan, directions = ranges[w, members[a]], beams[a]
            add_fan(sheet, box, view, x, y, cosine, sine, directions, spread, scan)
            paint(first, sheet, box, free, False)
            add_hits(sheet, box, view, x, y, cosine, sine, directions, spread, far[a], scan)
            paint(first, sheet, box, white, False)


@kernel
def add_fan(
    sheet: Rays,
    box: Ints,
    view: View,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    beams: Floats,
    spread: Floats,
    scan: Rays,
) -> None:
    """Add what the beams of a scan have passed through to a sheet.

    Args:
        sheet: Where it is added.
        box: The whole picture.
        view: What the picture shows.
        x: Place of the sensor [m].
        y: Place of the sensor [m].
        cosine: Of the body's heading.
        sine: Of the body's heading.
        beams: Unit vectors in the body frame, ``(n_beams, 2)``.
        spread: See ``scan_tables``.
        scan: Ranges [m], ``(n_beams,)``.
    """
    at_x, at_y = x, y
    for k in range(scan.shape[0]):
        ahead_x, ahead_y = cosine * beams[k, 0] - sine * beams[k, 1], sine * beams[k, 0] + cosine * beams[k, 1]
        end_x, end_y, half = x + scan[k] * ahead_x, y + scan[k] * ahead_y, scan[k] * spread[0]
        if k > 0 and spread[1] == 0.0:
            add_side(sheet, box, view, at_x, at_y, x, y)
            at_x, at_y = x, y
        right_x, right_y = end_x + half * ahead_y, end_y - half * ahead_x
        add_side(sheet, box, view, at_x, at_y, right_x, right_y)
        at_x, at_y = end_x - half * ahead_y, end_y + half * ahead_x
        add_side(sheet, box, view, right_x, right_y, at_x, at_y)
    add_side(sheet, box, view, at_x, at_y, x, y)


@kernel
def add_hits(
    sheet: Rays,
    box: Ints,
    view: View,
    x: float,
    y: float,
    cosine: float,
    sine: float,
    beams: Floats,
    spread: Floats,
    far: np.float32,
    scan: Rays,
) -> None:
    """Add what the beams of a scan have hit: a piece of wall as wide as a beam, at least a pixel, behind each end."""
    for k in range(scan.shape[0]):
        if scan[k] >= far:
            continue
        ahead_x, ahead_y = cosine * beams[k, 0] - sine * beams[k, 1], sine * beams[k, 0] + cosine * beams[k, 1]
        near, distant, half = scan[k], scan[k] + LINE / view[4], max(scan[k] * spread[0], 0.5 / view[4])
        ax, ay, bx, by = x + near * ahead_x, y + near * ahead_y, x + distant * ahead_x, y + distant * ahead_y
        aside_x, aside_y = half * ahead_y, -half * ahead_x
        add_side(sheet, box, view, ax + aside_x, ay + aside_y, bx + aside_x, by + aside_y)
        add_side(sheet, box, view, bx + aside_x, by + aside_y, bx - aside_x, by - aside_y)
        add_side(sheet, box, view, bx - aside_x, by - aside_y, ax - aside_x, ay - aside_y)
        add_side(sheet, box, view, ax - aside_x, ay - aside_y, ax + aside_x, ay + aside_y)
