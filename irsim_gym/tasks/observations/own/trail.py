"""Trail: earlier positions of the agent, relative to its present pose."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.terms import Bound, EpisodeState, Needs, RobotValues, Simulation, Term, Value, forget
from irsim_gym.tasks.terms.graph import sector_flags
from irsim_gym.tasks.terms.mirrored import Mirrored, sectors_exchanged
from irsim_gym.tasks.terms.words import Columns, evenly


@dataclass
class Marks(Struct):
    """Earlier positions of agents.

    Attributes:
        places: The marks [m], shape ``(n_worlds, n_agents, n_marks, 2)``; a new mark replaces the oldest one.
        count: Number of marks so far, shape ``(n_worlds, n_agents)``.
    """

    places: Floats
    count: Ints


@kind
class Trail:
    """Nearness of the nearest mark that the agent has left, by sector: ``near / (d + near)``, or 0 without one.

    The agent leaves a mark every ``spacing`` metres. The latest marks, which lie right behind it, do not count. With
    this observation, a policy without memory can avoid places where it has been.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("odometry",)

    sectors: int = option(12, ge=1, le=360, meaning="Number of sectors; the first begins straight behind.")
    spacing: float = option(0.5, gt=0.0, unit="m", meaning="Distance driven between two marks.")
    marks: int = option(32, ge=1, le=4096, meaning="Number of marks to remember.")
    fresh: int = option(2, ge=0, meaning="Number of latest marks to ignore.")
    near: float = option(0.5, gt=0.0, unit="m", meaning="Distance of a mark that reads 0.5.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Marks:
        """Return the memory."""
        shape = (simulation.n_worlds, len(agents))
        return Marks(np.zeros((*shape, self.marks, 2)), np.zeros(shape, np.int64))

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the sectors."""
        return np.zeros(self.sectors, np.float32), np.ones(self.sectors, np.float32)

    def mirrored(self, term: Term) -> Mirrored:
        """Return the sectors from right to left."""
        return sectors_exchanged(self.sectors)

    @staticmethod
    def begin(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Clear all marks."""
        forget(term.arrays.count, 0, episode, shard)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        scale = f"{self.near:g} m / (d + {self.near:g} m), d = distance of the mark; 0 without one"
        meaning = f"nearness of the nearest place where it has been; a mark each {self.spacing:g} m of its way"
        return [Columns(meaning, scale, self.sectors, evenly(self.sectors))]

    def graph(self, term: Term, model: Model, agent: int, robot: RobotValues) -> Value:
        """Return the columns as a graph; see ``HasGraph``."""
        # Places are NaN until a mark is left there; the latest mark is first.
        marks = robot.graph.state("trail", np.full((self.marks, 2), np.nan))
        position, latest = robot.pose.columns(0, 2).spread(1), robot.ways(marks.columns(0, 1))
        is_near = latest.op("ReduceSumSquare", axes=[2]) < self.spacing**2
        marks_now = is_near.where(marks, robot.graph.join([position, marks.columns(0, self.marks - 1)]))
        robot.graph.keep("trail", marks_now)
        if self.fresh >= self.marks:
            return robot.constant(np.zeros(self.sectors))
        ways = robot.ways(marks_now.columns(self.fresh, self.marks))
        d = ways.length(2)
        nearness = (self.near / (d + self.near)).cast(np.float32).spread(1)
        if self.fresh == 0:  # the latest mark may be here: it counts as along the world's x axis
            ways = (~d.equals(0.0)).spread(2).where(ways, np.array([1.0, 0.0]))
        places = robot.turned(ways).op("Transpose", perm=[0, 2, 1])
        return sector_flags(places, self.sectors).where(nearness, 0.0).largest(2)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Leave a mark if due, and write the sectors."""
        write_trail(shard.worlds, term.bound, term.arrays, state, episode)


@kernel
def write_trail(worlds: Ints, term: Bound, marks: Marks, state: State, episode: EpisodeState) -> None:
    """Write the nearness of the nearest mark in each sector.

    Reads: term (agents, column, options), marks (count, places), state (pose), episode (observation).
    Writes: marks (count, places), episode (observation).
    """
    options, size = term.options[0], marks.places.shape[2]
    for w in worlds:
        for a in range(term.agents.shape[0]):
            b = term.agents[a]
            x, y, heading = state.pose[w, b, 0], state.pose[w, b, 1], state.pose[w, b, 2]
            places = marks.places[w, a]
            leave_mark(x, y, options.spacing, places, marks.count[w], a)
            row = episode.observation[w, a, term.column : term.column + options.sectors]
            row[:] = np.float32(0.0)
            n = marks.count[w, a]
            # The marks that are kept, but for the latest ``fresh`` ones; mark m is in row m % size.
            for m in range(max(0, n - size), n - options.fresh):
                dx, dy = places[m % size, 0] - x, places[m % size, 1] - y
                turn = (np.arctan2(dy, dx) - heading) / (2.0 * np.pi) + 0.5
                sector = min(int((turn - np.floor(turn)) * options.sectors), options.sectors - 1)
                nearness = np.float32(options.near / (np.sqrt(dx * dx + dy * dy) + options.near))
                row[sector] = max(row[sector], nearness)


@kernel
def leave_mark(x: float, y: float, spacing: float, marks: Floats, count: Ints, a: int) -> None:
    """Add a position to the marks if it is at least ``spacing`` away from the latest one."""
    n, size = count[a], marks.shape[0]
    dx, dy = marks[(n - 1) % size, 0] - x, marks[(n - 1) % size, 1] - y
    if n == 0 or dx * dx + dy * dy >= spacing * spacing:
        marks[n % size, 0], marks[n % size, 1] = x, y
        count[a] = n + 1
