"""Which bodies are in a body's field of view, a sector with a width and a depth."""

import numpy as np

from irsim_gym.simulator.levels.body_measures import measure_into
from irsim_gym.simulator.world.names import Flags, Floats, Ints, Model, State, kernel, row_of


def detect(worlds: Ints, body: int, fov: float, depth: float, model: Model, state: State, detected: Flags) -> None:
    """Write who is in a body's field of view.

    Bodies count as the discs around their origins that have the size of the least circle around their footprint.
    Unobstructed bodies are detected too; absent ones, the occupancy map and the body itself are not. Nothing hides
    what lies behind it.

    Args:
        worlds: The worlds to treat.
        body: The body that looks.
        fov: Width of the sector, centred on the heading [rad].
        depth: Radius of the sector [m].
        model: Constants of the worlds.
        state: State of the worlds.
        detected: Written, shape ``(n_worlds, n_bodies)``.
    """
    radius, centroid = np.zeros(model.radius.shape), np.zeros(model.centroid.shape)
    everyone = np.arange(model.present.shape[1], dtype=np.int64)
    measure_into(worlds, everyone, model, radius, centroid)
    find_in_sector(worlds, body, fov, depth, model, state, radius, detected)


@kernel
def find_in_sector(
    worlds: Ints, body: int, fov: float, depth: float, model: Model, state: State, radius: Floats, detected: Flags
) -> None:
    """Write which discs reach into a sector.

    Reads: model (map_frame, present), state (pose).
    Writes: detected.
    """
    for w in worlds:
        x, y, heading = state.pose[w, body, 0], state.pose[w, body, 1], state.pose[w, body, 2]
        for b in range(model.present.shape[1]):
            detected[w, b] = False
            if b == body or b == model.map_frame[0].body or not model.present[w, b] or not model.present[w, body]:
                continue
            dx, dy, size = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y, radius[row_of(radius, w), b]
            distance = np.sqrt(dx * dx + dy * dy)
            if distance - size > depth:
                continue
            # Half of the angle under which the disc is seen; from within the disc, a quarter turn to each side.
            half_width = np.arcsin(size / distance) if size < distance else 0.5 * np.pi
            turn = np.arctan2(dy, dx) - heading
            # The disc reaches into the sector if the nearer of its two edges does.
            bearing = abs(turn - 2.0 * np.pi * np.floor((turn + np.pi) / (2.0 * np.pi)))
            detected[w, b] = bearing - half_width <= 0.5 * fov
