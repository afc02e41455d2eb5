"""What range sensors see of the obstacle map: a pass of its own after the one over bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import CellMap, Flags, Floats, Ints, Rays
from irsim_gym.geometry.cell_rays import cast_cells
from irsim_gym.jit import kernel


@kernel
def scan_cells(
    worlds: Ints,
    members: Ints,
    params: Any,
    beams_x: Rays,
    beams_y: Rays,
    cells: CellMap,
    present: Flags,
    pose: Floats,
    ranges: Rays,
) -> None:
    """Shorten the ranges of all members in all given worlds to the nearest occupied cell, not below range_min.

    Args:
        worlds: The worlds to treat.
        members: Body of each sensor, shape ``(n_members,)``.
        params: Records of the sensors' options.
        beams_x: Unit directions in the sensor frame, at least ``n_beams``.
        beams_y: As ``beams_x``.
        cells: The map.
        present: Which bodies exist, shape ``(n_worlds, n_bodies)``.
        pose: Poses [m, m, rad], shape ``(n_worlds, n_bodies, 3)``.
        ranges: Changed [m], shape ``(n_worlds, n_members, n_beams)``.
    """
    frame, squares = cells
    own = int(frame[4])
    for i in range(worlds.shape[0]):
        w = worlds[i]
        if not present[w, own]:
            continue
        for k in range(members.shape[0]):
            mount, body = params[k].offset, pose[w, members[k]]
            cosine, sine = np.cos(body[2]), np.sin(body[2])
            x = body[0] + cosine * mount[0] - sine * mount[1]
            y = body[1] + sine * mount[0] + cosine * mount[1]
            row = ranges[w, k]
            cast_cells(frame, squares, x, y, body[2] + mount[2], beams_x, beams_y, row)
            shortest = params[k].range_min
            for j in range(row.shape[0]):
                row[j] = max(row[j], np.float32(shortest))
