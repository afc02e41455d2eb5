"""Ways that the robots of a team share: each knows its own way, and where the ways of the others lead past it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Labels, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.geometry.angles import turned
from irsim_gym.jit import kernel
from irsim_gym.paths.cell_lines import is_clear
from irsim_gym.paths.grid import centre
from irsim_gym.paths.scan_marks import beam_end, eye_of
from irsim_gym.paths.wavefront import STRAIGHT
from irsim_gym.scenario.options import kind, option
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.mirrored import Mirrored, signed
from irsim_gym.tasks.observations.ranges import WITHOUT_SENSOR
from irsim_gym.tasks.observations.seen_grid import CELL, EVERY, SeenGrid, forget_seen, note_all
from irsim_gym.tasks.observations.seen_ways import SeenWays, clear_levels, find_way, narrow_ways
from irsim_gym.tasks.observations.way_on_seen_map import write_ways_seen
from irsim_gym.tasks.outcome import RUNNING
from irsim_gym.tasks.scaling import unit
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns
from irsim_gym.world.model import Model
from irsim_gym.world.rows import row_of
from irsim_gym.world.state import State

MARGIN = 0.1
"""Hits up to this distance outside the disc around a robot are hits of the robot [m]."""
TINY = 1e-12
"""Least length of a vector whose direction is written [m]."""
OWN, WIDTH = 3, 10
"""Number of columns of the agent's own way, and of all columns."""


@dataclass
class TeamWays(Struct):
    """The agents' ways over maps without robots.

    Attributes:
        ways: The maps, and the costs of ways over them.
        robots: Bodies whose hits are left out of the maps, shape ``(n_robots,)``.
        points: Points of each agent's way, from the agent on [m], shape ``(n_worlds, n_agents, n_points, 2)``.
        count: Number of these points; 0 without a way, after an arrival and after the end, shape ``(n_worlds,
            n_agents)``.
        rest: Length of the whole way [m], shape ``(n_worlds, n_agents)``.
    """

    ways: SeenWays
    robots: Ints
    points: Floats
    count: Labels
    rest: Floats


@kind
class SharedWays:
    """The agent's own way, and the way of another learner that leads past it: robots that tell each other their ways.

    The ways are the shortest ones to the next goal on the maps from each learner's own scans, as in
    ``way_on_seen_map``, but without robots: hits of robots, whose places are known to each other, are left out. So a
    way leads on behind a robot that stands in it. The first three columns are those of ``way_on_seen_map``. The others
    tell of the way that comes within ``width`` of the agent on its first ``ahead`` metres, of several the one that
    leads past it soonest; they are 0 without one. Learners that have arrived or whose episodes have ended have no way.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = True
    needs_scan: ClassVar[bool] = True

    cell: float | None = CELL
    every: int = EVERY
    ahead: float = option(4.0, gt=0.0, unit="m", meaning="Length of the part of another's way that is looked at.")
    width: float = option(0.9, gt=0.0, unit="m", meaning="Distance of a way from the agent up to which it leads past.")
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def arrays(self, simulation: Simulation, agents: Ints) -> TeamWays:
        """Return the maps, the ways, and scratch memory."""
        seen = SeenGrid.over(self, simulation, agents, "shared_ways", follows=False)
        shape = simulation.n_worlds, len(agents)
        seen.skipped = np.zeros((*shape, seen.scan.ranges.shape[2]), np.bool_)
        return TeamWays(
            ways=SeenWays.over(seen, simulation.shards.n_slots, 0.0),
            robots=np.array(simulation.scenario.robots, np.int64),
            points=np.zeros((*shape, int(self.ahead / seen.grid.cell) + 2, 2)),
            count=np.zeros(shape, np.int32),
            rest=np.zeros(shape),
        )

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the ten elements."""
        return np.array([-1, -1, 0, 0, 0, -1, -1, -1, -1, 0], np.float32), np.ones(WIDTH, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> Sequence[Columns]:
        """Return the meaning of the columns."""
        full = float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
        point, other = "of the direction of its own way, as if there were no robots", "another's way past the robot"
        return [
            Columns(f"cosine {point}", "1 straight ahead, -1 straight behind"),
            Columns(f"sine {point}", "1 to the left, -1 to the right"),
            Columns("length s of that way", f"s / {full:.3g} m, at most 1; 1 where there is none"),
            Columns(f"{other}: 1 if there is one, else 0, and all following numbers 0"),
            Columns(f"{other}: how far along it s the nearest point lies", f"s / {self.ahead:g} m"),
            Columns(f"{other}: cosine of its direction there", "1 straight ahead, -1 straight behind"),
            Columns(f"{other}: sine of its direction there", "1 to the left, -1 to the right"),
            Columns(f"{other}: how far ahead x the nearest point lies", f"x / {self.width:g} m"),
            Columns(f"{other}: how far to the left y it lies", f"y / {self.width:g} m"),
            Columns(f"{other}: its whole length s", f"s / {full:.3g} m, at most 1"),
        ]

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear the maps and ways."""
        ways = term.arrays.ways
        forget_seen(shard.worlds, ways.seen, episode)
        clear_levels(shard.worlds, ways, episode)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Add the latest scans to the maps, find the ways, and write the ten elements."""
        shared = term.arrays
        ways = shared.ways
        skip_robots(shard.worlds, term.bound, shared, ways.seen, model, state, episode)
        note_all(shard.worlds, shard.slot, term.bound, ways.seen, state, episode)
        narrow_ways(shard.worlds, term.bound, ways, model, episode)
        write_ways_seen(shard.worlds, shard.slot, term.bound, ways, model, state, episode)
        find_points(shard.worlds, shard.slot, term.bound, shared, ways, state, episode)
        write_others(shard.worlds, term.bound, shared, model, state, episode)


@kernel
def skip_robots(
    worlds: Ints, term: Bound, shared: TeamWays, seen: SeenGrid, model: Model, state: State, episode: EpisodeState
) -> None:
    """Flag the beams that hit a robot, in scans that are about to be added to a map.

    Reads: term (agents), shared (robots), seen (every, grid, scan), model (present, reach), state (pose), episode
        (steps).
    Writes: seen (skipped).
    """
    scan, grid = seen.scan, seen.grid
    for w in worlds:
        reach = model.reach[row_of(model.reach, w)]
        for a in range(term.agents.shape[0]):
            if episode.steps[w, a] % seen.every != 0:
                continue
            own = term.agents[a]
            eye, readings = eye_of(scan, a, state.pose[w, own], grid), scan.ranges[w, scan.sensors[a]]
            for i in range(readings.shape[0]):
                x, y = beam_end(scan, eye, scan.sensors[a], i, float(readings[i]))
                skipped = False
                for b in shared.robots:
                    dx = grid.origin_x + x * grid.cell - state.pose[w, b, 0]
                    dy = grid.origin_y + y * grid.cell - state.pose[w, b, 1]
                    far = reach[b] + MARGIN
                    skipped = skipped or (b != own and model.present[w, b] and dx * dx + dy * dy < far * far)
                seen.skipped[w, a, i] = skipped


@kernel
def find_points(
    worlds: Ints, slot: int, term: Bound, shared: TeamWays, ways: SeenWays, state: State, episode: EpisodeState
) -> None:
    """Find the first points and the lengths of the agents' ways.

    Reads: term (agents), ways (least, levels, queues, seen, target, way), state (goal, pose), episode (arrival,
        outcome).
    Writes: shared (count, points, rest), ways (least, queues, target, way).
    """
    grid, way = ways.seen.grid, ways.way[slot]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            shared.count[w, a] = 0
            if episode.arrival[w, a] > 0 or episode.outcome[w, a] != RUNNING:
                continue
            b, points = term.agents[a], shared.points[w, a]
            here, there = (state.pose[w, b, 0], state.pose[w, b, 1]), (state.goal[w, b, 0], state.goal[w, b, 1])
            if is_clear(here, there, grid, ways.levels[w, a]):
                dx, dy = there[0] - here[0], there[1] - here[1]
                far = np.sqrt(dx * dx + dy * dy)
                shared.rest[w, a] = far
                count = min(points.shape[0], int(far / grid.cell) + 1)
                for k in range(count):
                    part = k * grid.cell / far if far > 0.0 else 0.0
                    points[k, 0], points[k, 1] = here[0] + part * dx, here[1] + part * dy
                shared.count[w, a] = count
                continue
            n_cells = find_way(ways, slot, w, a, here, there)
            if n_cells == 0:
                continue
            # Costs are whole numbers, STRAIGHT for a step of one cell.
            shared.rest[w, a] = ways.least[w, a].reshape(-1)[way[0]] * (grid.cell / STRAIGHT)
            count = min(points.shape[0], n_cells + 1)
            points[0, 0], points[0, 1] = here
            for k in range(1, count):
                points[k, 0], points[k, 1] = centre(grid, way[k - 1] // grid.columns, way[k - 1] % grid.columns)
            shared.count[w, a] = count


@kernel
def write_others(
    worlds: Ints, term: Bound, shared: TeamWays, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the seven elements of the way of another agent that leads past each agent soonest.

    Reads: term (agents, column, options), shared (count, points, rest), model (bounds), state (direction, pose).
    Writes: episode (observation).
    """
    ahead, width = term.options[0].ahead, term.options[0].width
    across, up = model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]
    full = np.sqrt(across * across + up * up)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b, row = term.agents[a], episode.observation[w, a, term.column + OWN : term.column + WIDTH]
            x, y, soonest = state.pose[w, b, 0], state.pose[w, b, 1], np.inf
            cosine, sine = turned(state.pose[w, b, 2], state.direction[w, b])
            row[:] = np.float32(0.0)
            for other in range(term.agents.shape[0]):
                points = shared.points[w, other, : shared.count[w, other]]
                if other == a or points.shape[0] < 2:
                    continue
                at, along, squared = nearest_point(points, x, y, ahead)
                if squared > width * width or along >= soonest:
                    continue
                soonest = along
                before, after = points[max(at - 1, 0)], points[min(at + 1, points.shape[0] - 1)]
                vx, vy, dx, dy = after[0] - before[0], after[1] - before[1], points[at, 0] - x, points[at, 1] - y
                long = max(np.sqrt(vx * vx + vy * vy), TINY)
                row[0], row[1] = np.float32(1.0), unit(along / ahead)
                row[2], row[3] = unit((vx * cosine + vy * sine) / long), unit((vy * cosine - vx * sine) / long)
                row[4], row[5] = unit((dx * cosine + dy * sine) / width), unit((dy * cosine - dx * sine) / width)
                row[6] = unit(shared.rest[w, other] / full)


@kernel
def nearest_point(points: Floats, x: float, y: float, ahead: float) -> tuple[int, float, float]:
    """Return which point is nearest to a place, the length up to it [m], and its squared distance [m2].

    Args:
        points: Points of a path [m], shape ``(n, 2)``.
        x: The place [m].
        y: The place [m].
        ahead: Points farther along the path are left out [m].
    """
    best, at, along, driven = np.inf, 0, 0.0, 0.0
    for k in range(points.shape[0]):
        if k > 0:
            dx, dy = points[k, 0] - points[k - 1, 0], points[k, 1] - points[k - 1, 1]
            driven += np.sqrt(dx * dx + dy * dy)
        if driven > ahead:
            break
        dx, dy = points[k, 0] - x, points[k, 1] - y
        if dx * dx + dy * dy < best:
            best, at, along = dx * dx + dy * dy, k, driven
    return at, along, best
