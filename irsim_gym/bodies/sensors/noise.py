"""Noise of range sensors, in the directions of beams and in ranges.

Each scan draws a fixed number of random numbers from the stream of the world, whatever the beams hit: first for the
directions of all members, then for their ranges.
"""

import numpy as np

from irsim_gym.bodies.sensors.scan_tables import ScanTables, beam_row
from irsim_gym.simulator.world.names import Ints, State, kernel, normal


@kernel
def draw_directions(worlds: Ints, tables: ScanTables, state: State) -> None:
    """Write each beam's nominal direction plus noise, and its unit vector, for all members.

    Reads: tables (angle_std, angles), state (random).
    Writes: tables (beams_x, beams_y, cast_angles), state (random).
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            deviation, row = tables.angle_std[k], beam_row(w, k, tables)
            if deviation <= 0.0:
                continue
            for j in range(tables.angles.shape[0]):
                angle = normal(state.random, w, tables.angles[j], deviation)
                tables.cast_angles[row, j] = angle
                tables.beams_x[row, j], tables.beams_y[row, j] = np.float32(np.cos(angle)), np.float32(np.sin(angle))


@kernel
def add_range_noise(worlds: Ints, tables: ScanTables, state: State) -> None:
    """Add noise to the ranges below range_max, then clip them to [range_min, range_max].

    Reads: tables (range_max, range_min, range_std, ranges), state (random).
    Writes: tables (ranges), state (random).
    """
    for w in worlds:
        for k in range(tables.members.shape[0]):
            shortest, farthest = np.float32(tables.range_min[k]), np.float32(tables.range_max[k])
            ranges = tables.ranges[w, k]
            for j in range(ranges.shape[0]):
                # Drawn for free beams, too, see above.
                error = np.float32(normal(state.random, w, 0.0, tables.range_std[k]))
                if ranges[j] < farthest:
                    ranges[j] = min(max(ranges[j] + error, shortest), farthest)
