"""Exact free travel: how far the agent can drive straight, computed from the outlines around it."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from irsim_gym.simulator.cell_maps.cells import segment_cells_distance
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.world.names import Cells, Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, row_of
from irsim_gym.tasks.observations.bodies.nearest_bodies import span
from irsim_gym.tasks.observations.scan.free_travel import ObservesTravel, directions, shorten, way_columns
from irsim_gym.tasks.observations.scan.ranges import encode, range_code
from irsim_gym.tasks.terms import Bound, Columns, EpisodeState, Needs, Simulation, Term

NEAR_ENOUGH = 0.01
"""Gap [m] below which a disc counts as touching a map's occupied cells."""
LONGEST_WALK = 256
"""Maximum number of steps along a map; longer walks lead along a wall, closer than 0.1 m."""


class Place(NamedTuple):
    """A disc whose free travel is measured: position [m], cosine and sine of the heading, radius [m]."""

    x: float
    y: float
    cosine: float
    sine: float
    radius: float


@dataclass
class Directions(Struct):
    """The observed directions.

    Attributes:
        ahead_x: Directions in the body frame, shape ``(n_directions,)``.
        ahead_y: As ``ahead_x``.
        radius: Radius of the disc around each agent [m], shape ``(n_agents,)``.
    """

    ahead_x: Rays
    ahead_y: Rays
    radius: Floats


@kind
class ExactFreeTravel(ObservesTravel):
    """``free_travel`` for agents without a range sensor, computed from outlines and the map.

    It sees through walls and in all directions, but not bodies that are ``unobstructed``.
    """

    needs: ClassVar[Needs] = ("bodies",)

    def arrays(self, simulation: Simulation, agents: Ints) -> Directions:
        """Return the directions in the body frame and the radii of the discs around the agents."""
        return Directions(*directions(self.directions), simulation.model.reach[:, agents].max(axis=0) + self.margin)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the codes of the longest distance and of contact."""
        return self.coded_bounds(self.horizon, self.directions)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        return way_columns(self, term.arrays, agent, self.horizon)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the directions' codes."""
        write_ways(shard.worlds, term.bound, term.arrays, model, model.cells, state, episode)


@kernel
def write_ways(
    worlds: Ints, term: Bound, ways: Directions, model: Model, cells: Cells, state: State, episode: EpisodeState
) -> None:
    """Write the encoded free distance in each direction.

    Reads: term (agents, column, options), ways (ahead_x, ahead_y, radius), model (disc_count, disc_start, present,
        reach, segment_count, segment_start, unobstructed), state (discs, pose, segments), episode (observation).
    Writes: episode (observation).
    """
    options, column, far = term.options[0], term.column, term.options[0].horizon
    code = range_code(options, far)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            body, radius = term.agents[a], ways.radius[a]
            row = episode.observation[w, a, column : column + ways.ahead_x.shape[0]]
            row[:] = np.float32(far)
            x, y, heading = state.pose[w, body, 0], state.pose[w, body, 1], state.pose[w, body, 2]
            place = Place(x, y, np.cos(heading), np.sin(heading), radius)
            for b in range(model.present.shape[1]):
                if b == body or model.unobstructed[b] or not model.present[w, b]:
                    continue
                dx, dy = state.pose[w, b, 0] - x, state.pose[w, b, 1] - y
                seen = far + radius + model.reach[row_of(model.reach, w), b]
                if dx * dx + dy * dy >= seen * seen:
                    continue
                first, last = span(model.disc_start, model.disc_count, w, b)
                for d in range(first, last):
                    stop_at_disc(state.discs[w, d], place, far, ways, row)
                first, last = span(model.segment_start, model.segment_count, w, b)
                for s in range(first, last):
                    stop_at_segment(state.segments[w, s], place, far, ways, row)
            stop_at_cells(cells, w, place, ways, row)
            encode(row, code)


@kernel
def stop_at_disc(disc: Floats, place: Place, far: float, ways: Directions, row: Rays) -> None:
    """Shorten the distances that another disc limits.

    Reads: ways (ahead_x, ahead_y).
    Writes: row.
    """
    dx, dy, radius = disc[0] - place.x, disc[1] - place.y, disc[2] + place.radius
    x = np.float32(dx * place.cosine + dy * place.sine)
    y = np.float32(dy * place.cosine - dx * place.sine)
    shorten(x, y, np.float32(radius * radius), np.float32(far), ways.ahead_x, ways.ahead_y, row)


@kernel
def stop_at_segment(segment: Floats, place: Place, far: float, ways: Directions, row: Rays) -> None:
    """Shorten the distances that a segment limits: by its two ends, and by its side.

    Reads: ways (ahead_x, ahead_y).
    Writes: row.
    """
    cosine, sine, radius, ahead_x, ahead_y = place.cosine, place.sine, place.radius, ways.ahead_x, ways.ahead_y
    ax, ay = segment[0] - place.x, segment[1] - place.y
    ux, uy = segment[2] - segment[0], segment[3] - segment[1]
    length = np.sqrt(ux * ux + uy * uy)
    px, py = ax * cosine + ay * sine, ay * cosine - ax * sine
    qx, qy = px + ux * cosine + uy * sine, py + uy * cosine - ux * sine
    own_2, far_32 = np.float32(radius * radius), np.float32(far)
    shorten(np.float32(px), np.float32(py), own_2, far_32, ahead_x, ahead_y, row)
    shorten(np.float32(qx), np.float32(qy), own_2, far_32, ahead_x, ahead_y, row)
    if length == 0.0:
        return
    along_x, along_y = (qx - px) / length, (qy - py) / length
    # The normal points from the disc to the segment's line, which the disc touches when it has closed ``gap``.
    side = 1.0 if px * along_y - py * along_x >= 0.0 else -1.0
    normal_x, normal_y = side * along_y, -side * along_x
    gap = px * normal_x + py * normal_y - radius
    start = px * along_x + py * along_y
    for j in range(row.shape[0]):
        towards = ahead_x[j] * normal_x + ahead_y[j] * normal_y
        if towards <= 0.0:
            continue
        way = max(gap, 0.0) / towards
        # Where on the segment the disc touches, from its first end [m].
        place_along = way * (ahead_x[j] * along_x + ahead_y[j] * along_y) - start
        if way < row[j] and 0.0 <= place_along <= length:
            row[j] = np.float32(way)


@kernel
def stop_at_cells(cells: Cells, w: int, place: Place, ways: Directions, row: Rays) -> None:
    """Shorten the distances that the map of world w limits; each step is as long as the clearance allows.

    Reads: ways (ahead_x, ahead_y).
    Writes: row.
    """
    if cells is None:
        return
    world_map = map_of(cells, w)
    cosine, sine, radius, ahead_x, ahead_y = place.cosine, place.sine, place.radius, ways.ahead_x, ways.ahead_y
    for j in range(row.shape[0]):
        dx, dy = ahead_x[j] * cosine - ahead_y[j] * sine, ahead_x[j] * sine + ahead_y[j] * cosine
        way, before = 0.0, -np.inf
        for _ in range(LONGEST_WALK):
            x, y = place.x + way * dx, place.y + way * dy
            # No cell is nearer than ``room``, so the disc may move that far in any direction (sphere tracing, Hart
            # 1996). In contact it goes on in small steps while the room grows: a disc at a wall may move away from it.
            room = segment_cells_distance(world_map, x, y, x, y, radius + row[j]) - radius
            if room < NEAR_ENOUGH and room <= before:
                row[j] = np.float32(max(way, 0.0))
                break
            way, before = way + max(room, NEAR_ENOUGH), room
            if way >= row[j]:
                break
