"""What range sensors see of the obstacle map: a pass of its own after the one over bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from irsim_gym.arraytypes import CellMap, Ints, Labels, Rays
from irsim_gym.geometry.cell_rays import cast_cells
from irsim_gym.jit import kernel
from irsim_gym.sensors.casting import mount_pose
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState


@kernel
def scan_cells(
    worlds: Ints,
    members: Ints,
    params: Any,
    beams_x: Rays,
    beams_y: Rays,
    cells: CellMap,
    model: WorldModel,
    state: WorldState,
    floats: Rays,
    integers: Labels,
    ranges: Rays,
) -> None:
    """Shorten the ranges of all members in all given worlds to the nearest occupied cell, not below range_min.

    Args:
        worlds: The worlds to treat.
        members: Body of each sensor, shape ``(n_members,)``.
        params: Records of the sensors' options.
        beams_x: Unit directions in the sensor frame, shape ``(n_rows, n_padded)``: one row for all, or one for each
            world and member.
        beams_y: As ``beams_x``.
        cells: The map.
        floats: Scratch, see ``cell_rays``.
        integers: Scratch, see ``cell_rays``.
        ranges: Changed [m], shape ``(n_worlds, n_members, n_beams)``.
    """
    own = cells.body
    for w in worlds:
        if not model.present[w, own]:
            continue
        for k in range(members.shape[0]):
            pose = mount_pose(state.pose[w, members[k]], params[k].offset)
            turned = w * members.shape[0] + k if beams_x.shape[0] > 1 else 0
            row = ranges[w, k]
            cast_cells(cells, pose, beams_x[turned], beams_y[turned], floats, integers, row)
            shortest = np.float32(params[k].range_min)
            for j in range(row.shape[0]):
                row[j] = row[j] if row[j] > shortest else shortest
