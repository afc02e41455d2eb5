"""``fog_map``: which cells of the world the robots have seen so far. Nothing reads it but the user and the renderer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from irsim_gym.arraytypes import Flags, Floats, Ints, Rays
from irsim_gym.jit import kernel
from irsim_gym.scenario.spec import Scenario
from irsim_gym.world.group import Group, Shard
from irsim_gym.world.model import ROBOT, WorldModel
from irsim_gym.world.state import WorldState

CELL = 0.1
"""Side of a cell [m] where neither the file nor a map says it."""
BEYOND = 1e-3
"""How far a beam's last point lies behind its end, as a share of the others' distance: in what it hits."""


@dataclass
class Fog:
    """What was seen, and by whom.

    Attributes:
        frame: x and y of the lower left corner, width and height of a cell [m], shape ``(4,)``.
        explored: Cells that were seen, shape ``(n_worlds, columns, rows)``, from the left and from the bottom.
        scans: Groups of range sensors, each with its members that belong to robots, and where all members are
            mounted in the body frame, shape ``(n_members, 3)``.
        watchers: Robots without such a sensor but with a field of view, shape ``(n,)``.
        views: Width [rad] and depth [m] of their fields of view, shape ``(n, 2)``.
    """

    frame: Floats
    explored: Flags
    scans: list[tuple[Group, Ints, Floats]]
    watchers: Ints
    views: Floats


def lay_fog(scenario: Scenario, sensors: Sequence[Group], model: WorldModel) -> Fog | None:
    """Return the fog over a scenario's worlds, None where the file asks for none."""
    world = scenario.world
    if not world.fog_map:
        return None
    cell = world.fog_map_resolution or (model.cells.width if model.cells is not None else CELL)
    columns, rows = max(1, round(world.width / cell)), max(1, round(world.height / cell))
    scanning = {int(b) for group in sensors if group.kind.reading == "ranges" for b in group.members}
    watching = {
        b: (float(body.fov), float(body.fov_radius))
        for b, body in enumerate(scenario.bodies)
        if body.role == "robot" and b not in scanning and body.fov is not None and body.fov_radius is not None
    }
    return Fog(
        frame=np.array([*world.offset, world.width / columns, world.height / rows]),
        explored=np.zeros((len(model.present), columns, rows), np.bool_),
        scans=[
            (group, np.flatnonzero(model.role[group.members] == ROBOT), _mounts(group))
            for group in sensors
            if group.kind.reading == "ranges" and "cast_angles" in group.arrays
        ],
        watchers=np.array(list(watching), np.int64),
        views=np.array(list(watching.values()), np.float64).reshape(-1, 2),
    )


def _mounts(group: Group) -> Floats:
    return np.array([options.offset for options in group.options], np.float64)


def cover(fog: Fog, shard: Shard) -> None:
    """Forget what was seen in the shard's worlds."""
    cover_cells(shard.worlds, fog.explored)


@kernel
def cover_cells(worlds: Ints, explored: Flags) -> None:
    """Mark all cells of the worlds as not seen."""
    for i in range(worlds.shape[0]):
        explored[worlds[i], :, :] = False


def reveal(fog: Fog, model: WorldModel, state: WorldState, shard: Shard) -> None:
    """Note what the robots' sensors see now."""
    for group, chosen, offsets in fog.scans:
        table = group.arrays
        reveal_beams(
            shard.worlds,
            group.members,
            chosen,
            offsets,
            table["cast_angles"],
            table["ranges"],
            model,
            state,
            fog.frame,
            fog.explored,
        )
    if len(fog.watchers):
        reveal_views(shard.worlds, fog.watchers, fog.views, model, state, fog.frame, fog.explored)


@kernel
def reveal_beams(
    worlds: Ints,
    members: Ints,
    chosen: Ints,
    offsets: Floats,
    angles: Floats,
    ranges: Rays,
    model: WorldModel,
    state: WorldState,
    frame: Floats,
    explored: Flags,
) -> None:
    """Mark the cells under points of each beam, half a cell apart and just behind its end.

    So does IR-SIM, but for the last point: it takes the end itself, where rounding decides whether a wall is seen.

    Args:
        worlds: The worlds to treat.
        members: Body of each sensor, shape ``(n_members,)``.
        chosen: Numbers of the sensors that count.
        offsets: The sensors' poses in the body frame, shape ``(n_members, 3)``.
        angles: Directions in the sensor frame [rad], shape ``(n_rows, n_beams)``: one row for all, or one for each
            world and member.
        ranges: Readings [m], shape ``(n_worlds, n_members, n_beams)``.
        frame: See ``Fog``.
        explored: Changed, see ``Fog``.
    """
    step = 0.5 * min(frame[2], frame[3])
    for w in worlds:
        for k in chosen:
            b, mount = members[k], offsets[k]
            if not model.present[w, b]:
                continue
            cosine, sine = np.cos(state.pose[w, b, 2]), np.sin(state.pose[w, b, 2])
            x = state.pose[w, b, 0] + cosine * mount[0] - sine * mount[1]
            y = state.pose[w, b, 1] + sine * mount[0] + cosine * mount[1]
            row = w * members.shape[0] + k if angles.shape[0] > 1 else 0
            for j in range(ranges.shape[2]):
                angle = state.pose[w, b, 2] + mount[2] + angles[row, j]
                along_x, along_y, far = np.cos(angle), np.sin(angle), np.float64(ranges[w, k, j])
                for n in range(int(far / step) + 2):
                    way = min(n * step, far + BEYOND * step)
                    mark(x + way * along_x, y + way * along_y, frame, explored[w])


@kernel
def reveal_views(
    worlds: Ints, watchers: Ints, views: Floats, model: WorldModel, state: WorldState, frame: Floats, explored: Flags
) -> None:
    """Mark the cells whose centres lie in the fields of view, whatever stands between.

    Args:
        worlds: The worlds to treat.
        watchers: The bodies that look.
        views: Width [rad] and depth [m] of their fields of view, shape ``(n_watchers, 2)``.
        frame: See ``Fog``.
        explored: Changed, see ``Fog``.
    """
    for w in worlds:
        for k in range(watchers.shape[0]):
            b, half, depth = watchers[k], 0.5 * views[k, 0], views[k, 1]
            if not model.present[w, b]:
                continue
            for column in range(explored.shape[1]):
                for row in range(explored.shape[2]):
                    dx = frame[0] + (column + 0.5) * frame[2] - state.pose[w, b, 0]
                    dy = frame[1] + (row + 0.5) * frame[3] - state.pose[w, b, 1]
                    if dx * dx + dy * dy > depth * depth:
                        continue
                    turn = (np.arctan2(dy, dx) - state.pose[w, b, 2] + np.pi) % (2.0 * np.pi) - np.pi
                    if abs(turn) <= half or half >= np.pi or (dx == 0.0 and dy == 0.0):
                        explored[w, column, row] = True


@kernel
def mark(x: float, y: float, frame: Floats, explored: Flags) -> None:
    """Mark the cell that a point [m] lies in, if there is one."""
    column, row = np.floor((x - frame[0]) / frame[2]), np.floor((y - frame[1]) / frame[3])
    if 0.0 <= column < explored.shape[0] and 0.0 <= row < explored.shape[1]:
        explored[int(column), int(row)] = True
