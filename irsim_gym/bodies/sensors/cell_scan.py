"""Casts beams against the obstacle map, in a pass of its own after the one over bodies."""

import numpy as np

from irsim_gym.bodies.sensors.scan_tables import ScanTables, beam_row, mount_pose
from irsim_gym.simulator.cell_maps.cell_rays import cast_cells
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.world.names import CellMaps, Ints, Model, State, kernel


@kernel
def scan_cells(worlds: Ints, slot: int, tables: ScanTables, cells: CellMaps, model: Model, state: State) -> None:
    """Shorten the ranges of all members in all given worlds to the nearest occupied cell, not below ``cast_min``.

    Reads: tables (beams_x, beams_y, cast_min, members, offset, ranges, walk_floats, walk_integers), model (present),
        state (pose).
    Writes: tables (ranges, walk_floats, walk_integers).
    """
    map_body, floats, integers = cells.body, tables.walk_floats[slot], tables.walk_integers[slot]
    for w in worlds:
        if not model.present[w, map_body]:
            continue
        world_map = map_of(cells, w)
        for k in range(tables.members.shape[0]):
            pose = mount_pose(state.pose[w, tables.members[k]], tables.offset[w, k])
            row, ranges = beam_row(w, k, tables), tables.ranges[w, k]
            cast_cells(world_map, pose, tables.beams_x[row], tables.beams_y[row], floats, integers, ranges)
            shortest = np.float32(tables.cast_min[k])
            for j in range(ranges.shape[0]):
                ranges[j] = ranges[j] if ranges[j] > shortest else shortest
