"""Radius and centroid of footprints, for those who look at a body as a disc."""

from __future__ import annotations

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints
from irsim_gym.geometry.measures import CORNERS, centre_of_mass, corner_points, least_circle
from irsim_gym.jit import kernel
from irsim_gym.world.model import WorldModel


def measure(worlds: Ints, bodies: Ints, model: WorldModel) -> None:
    """Write ``model.radius`` and ``model.centroid`` of bodies from their outlines."""
    measure_into(worlds, bodies, model, model.radius, model.centroid)


def measure_into(worlds: Ints, bodies: Ints, model: WorldModel, radius: Floats, centroid: Floats) -> None:
    """Write radius and centroid of bodies from their outlines, in arrays shaped as the model's."""
    measure_bodies(
        worlds,
        bodies,
        model.solid,
        model.segment_start,
        model.segment_count,
        model.local_segments,
        model.disc_start,
        model.disc_count,
        model.local_discs,
        radius,
        centroid,
    )


def measured(model: WorldModel, world: int, body: int) -> tuple[Floats, Floats]:
    """Return arrays as ``model.radius`` and ``model.centroid`` that are up to date for one body, whoever else asks."""
    radius, centroid = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
    row = world % len(radius)
    measure_into(np.array([row], np.int64), np.array([body], np.int64), model, radius, centroid)
    return radius, centroid


@kernel(allocates=True)
def measure_bodies(
    worlds: Ints,
    bodies: Ints,
    solid: Flags,
    segment_start: Ints,
    segment_count: Ints,
    local_segments: Floats,
    disc_start: Ints,
    disc_count: Ints,
    local_discs: Floats,
    radius: Floats,
    centroid: Floats,
) -> None:
    """Write the radius of the least circle around each footprint, and the centre of its area."""
    points = np.empty((2 * local_segments.shape[1] + CORNERS * local_discs.shape[1], 2))
    n_rows = worlds.shape[0] if radius.shape[0] > 1 else min(worlds.shape[0], 1)
    for i in range(n_rows):
        row = worlds[i] % radius.shape[0]
        for k in range(bodies.shape[0]):
            b = bodies[k]
            start, disc = segment_start[b], disc_start[b]
            own = local_segments[row % local_segments.shape[0], start : start + segment_count[row, b]]
            rounds = local_discs[row % local_discs.shape[0], disc : disc + disc_count[row, b]]
            centroid[row, b, 0], centroid[row, b, 1] = centre_of_mass(own, rounds, solid[b])
            if own.shape[0] == 0 and rounds.shape[0] == 1:
                radius[row, b] = rounds[0, 2]
            else:
                radius[row, b] = least_circle(points, corner_points(own, rounds, points))[2]
