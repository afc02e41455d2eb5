"""Radius and centroid of footprints, for code that treats a body as a disc."""

import numpy as np

from irsim_gym.simulator.geometry.measures import CORNERS, centre_of_mass, corner_points, least_circle
from irsim_gym.simulator.world.names import Floats, Ints, Model, kernel, row_of


def measure(worlds: Ints, bodies: Ints, model: Model) -> None:
    """Write ``model.radius`` and ``model.centroid`` of bodies from their outlines."""
    measure_into(worlds, bodies, model, model.radius, model.centroid)


def measure_into(worlds: Ints, bodies: Ints, model: Model, radius: Floats, centroid: Floats) -> None:
    """Write radius and centroid of bodies from their outlines, in arrays shaped as the model's."""
    measure_bodies(worlds, bodies, model, radius, centroid)


def measured(model: Model, world: int, body: int) -> tuple[Floats, Floats]:
    """Return arrays shaped as ``model.radius`` and ``model.centroid``, up to date for one body, as these may not be."""
    radius, centroid = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
    row = world % len(radius)
    measure_into(np.array([row], np.int64), np.array([body], np.int64), model, radius, centroid)
    return radius, centroid


@kernel(allocates=True)
def measure_bodies(worlds: Ints, bodies: Ints, model: Model, radius: Floats, centroid: Floats) -> None:
    """Write the radius of the least circle around each footprint, and the centre of its area.

    Reads: model (disc_count, disc_start, local_discs, local_segments, segment_count, segment_start, solid).
    Writes: radius, centroid.
    """
    points = np.empty((2 * model.local_segments.shape[1] + CORNERS * model.local_discs.shape[1], 2))
    # Where all worlds share their outlines, there is one row to measure, however many worlds are given.
    n_rows = worlds.shape[0] if radius.shape[0] > 1 else min(worlds.shape[0], 1)
    for i in range(n_rows):
        row = worlds[i] % radius.shape[0]
        for b in bodies:
            start, disc = model.segment_start[b], model.disc_start[b]
            sides = model.local_segments[row_of(model.local_segments, row)][start : start + model.segment_count[row, b]]
            rounds = model.local_discs[row_of(model.local_discs, row)][disc : disc + model.disc_count[row, b]]
            centroid[row, b, 0], centroid[row, b, 1] = centre_of_mass(sides, rounds, model.solid[b])
            if sides.shape[0] == 0 and rounds.shape[0] == 1:
                radius[row, b] = rounds[0, 2]
            else:
                radius[row, b] = least_circle(points, corner_points(sides, rounds, points))[2]
