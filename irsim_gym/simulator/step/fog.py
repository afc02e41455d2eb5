"""``fog_map``: the cells of the world that robots have seen so far. Only users and the renderer read it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.world.names import ROBOT, Flags, Floats, Group, Ints, Model, Rays, Shard, State, Struct, kernel

CELL = 0.1
"""Side of a cell [m] if neither the file nor a map gives it."""
BEYOND = 1e-3
"""Distance of a beam's last point behind its end, relative to the spacing of the others: inside the hit body."""


@dataclass(repr=False)
class FogCells(Struct):
    """The cells of all worlds, from the left and from the bottom.

    Attributes:
        x: Left end [m].
        y: Lower end [m].
        width: Width of a cell [m].
        height: Height of a cell [m].
        explored: Cells that were seen, shape ``(n_worlds, columns, rows)``.
    """

    x: float
    y: float
    width: float
    height: float
    explored: Flags


@dataclass(repr=False)
class Scans(Struct):
    """A group of range sensors.

    Attributes:
        members: Body of each sensor, shape ``(n_members,)``.
        chosen: Numbers of the sensors that belong to robots, shape ``(n,)``.
        offset: Mount poses in the body frame [m, m, rad], shape ``(n_members, 3)``.
        angles: Directions in the sensor frame [rad], shape ``(n_rows, n_beams)``: one row for all, or one for each
            world and member.
        ranges: Readings [m], shape ``(n_worlds, n_members, n_beams)``.
    """

    members: Ints
    chosen: Ints
    offset: Floats
    angles: Floats
    ranges: Rays


@dataclass(repr=False)
class Watchers(Struct):
    """Robots without a range sensor but with a field of view.

    Attributes:
        bodies: The robots, shape ``(n,)``.
        width: Width of each field of view [rad], shape ``(n,)``.
        depth: Depth of each field of view [m], shape ``(n,)``.
    """

    bodies: Ints
    width: Floats
    depth: Floats


@dataclass
class FogMap:
    """What was seen, and by whom.

    Attributes:
        cells: What was seen.
        scans: Range sensors.
        watchers: Robots that see by their field of view.
    """

    cells: FogCells
    scans: list[Scans]
    watchers: Watchers


def lay_fog(scenario: Scenario, sensors: Sequence[Group], model: Model) -> FogMap | None:
    """Return the fog over a scenario's worlds, None where the file asks for none."""
    world = scenario.world
    if not world.fog_map:
        return None
    cell = world.fog_map_resolution or (model.cells.width if model.cells is not None else CELL)
    columns, rows = max(1, round(world.width / cell)), max(1, round(world.height / cell))
    scanning = {int(b) for group in sensors if group.kind.reading == "ranges" for b in group.members}
    watching = [
        (b, float(body.fov), float(body.fov_radius))
        for b, body in enumerate(scenario.bodies)
        if body.role == "robot" and b not in scanning and body.fov is not None and body.fov_radius is not None
    ]
    bodies, widths, depths = zip(*watching, strict=True) if watching else ((), (), ())
    (x, y), explored = world.offset, np.zeros((len(model.present), columns, rows), np.bool_)
    return FogMap(
        FogCells(float(x), float(y), world.width / columns, world.height / rows, explored),
        [_scans(group, model) for group in sensors if group.kind.reading == "ranges" and "cast_angles" in group.arrays],
        Watchers(np.array(bodies, np.int64), np.array(widths, np.float64), np.array(depths, np.float64)),
    )


def _scans(group: Group, model: Model) -> Scans:
    chosen = np.flatnonzero(model.role[group.members] == ROBOT)
    offset = np.array([options.offset for options in group.options], np.float64)
    return Scans(group.members, chosen, offset, group.arrays["cast_angles"], group.arrays["ranges"])


def cover(fog: FogMap, shard: Shard) -> None:
    """Forget what was seen in the shard's worlds."""
    cover_cells(shard.worlds, fog.cells)


@kernel
def cover_cells(worlds: Ints, cells: FogCells) -> None:
    """Mark all cells of the worlds as not seen.

    Writes: cells (explored).
    """
    for w in worlds:
        cells.explored[w, :, :] = False


def reveal(fog: FogMap, model: Model, state: State, shard: Shard) -> None:
    """Note what the robots' sensors see now."""
    for scans in fog.scans:
        reveal_beams(shard.worlds, scans, fog.cells, model, state)
    if len(fog.watchers.bodies):
        reveal_views(shard.worlds, fog.watchers, fog.cells, model, state)


@kernel
def reveal_beams(worlds: Ints, scans: Scans, cells: FogCells, model: Model, state: State) -> None:
    """Mark the cells under points of each beam, half a cell apart and just behind its end.

    IR-SIM does the same, except that its last point is the end itself, where rounding decides whether a wall is seen.

    Reads: scans (angles, chosen, members, offset, ranges), cells (height, width, x, y), model (present), state (pose).
    Writes: cells (explored).
    """
    step = 0.5 * min(cells.width, cells.height)
    for w in worlds:
        for k in scans.chosen:
            b, mount = scans.members[k], scans.offset[k]
            if not model.present[w, b]:
                continue
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            x = state.pose[w, b, 0] + cosine * mount[0] - sine * mount[1]
            y = state.pose[w, b, 1] + sine * mount[0] + cosine * mount[1]
            # Only noisy sensors have directions of their own in each world; the others share one row.
            row = w * scans.members.shape[0] + k if scans.angles.shape[0] > 1 else 0
            for j in range(scans.ranges.shape[2]):
                angle = state.pose[w, b, 2] + mount[2] + scans.angles[row, j]
                along_x, along_y, far = np.cos(angle), np.sin(angle), np.float64(scans.ranges[w, k, j])
                for n in range(int(far / step) + 2):
                    # The last n exceeds the range: its point is moved back to just behind the end of the beam.
                    way = min(n * step, far + BEYOND * step)
                    mark(w, x + way * along_x, y + way * along_y, cells)


@kernel
def reveal_views(worlds: Ints, watchers: Watchers, cells: FogCells, model: Model, state: State) -> None:
    """Mark the cells whose centres lie in the fields of view; nothing hides what is behind it.

    Reads: watchers (bodies, depth, width), cells (height, width, x, y), model (present), state (pose).
    Writes: cells (explored).
    """
    for w in worlds:
        for k in range(watchers.bodies.shape[0]):
            b, half, depth = watchers.bodies[k], 0.5 * watchers.width[k], watchers.depth[k]
            if not model.present[w, b]:
                continue
            for column in range(cells.explored.shape[1]):
                for row in range(cells.explored.shape[2]):
                    dx = cells.x + (column + 0.5) * cells.width - state.pose[w, b, 0]
                    dy = cells.y + (row + 0.5) * cells.height - state.pose[w, b, 1]
                    if dx * dx + dy * dy > depth * depth:
                        continue
                    # Bearing of the cell's centre from the heading, wrapped to [-pi, pi).
                    turn = (np.arctan2(dy, dx) - state.pose[w, b, 2] + np.pi) % (2.0 * np.pi) - np.pi
                    if abs(turn) <= half or half >= np.pi or (dx == 0.0 and dy == 0.0):
                        cells.explored[w, column, row] = True


@kernel
def mark(w: int, x: float, y: float, cells: FogCells) -> None:
    """Mark the cell that a point [m] lies in, if there is one.

    Reads: cells (height, width, x, y).
    Writes: cells (explored).
    """
    column, row = np.floor((x - cells.x) / cells.width), np.floor((y - cells.y) / cells.height)
    if 0.0 <= column < cells.explored.shape[1] and 0.0 <= row < cells.explored.shape[2]:
        cells.explored[w, int(column), int(row)] = True
