"""Neighbors: position and motion of the nearest other robots."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.simulator.world.names import Floats, Ints, Model, Rays, Shard, State, Struct, kernel, kind, option
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.tasks.observations.bodies.nearest_bodies import moving
from irsim_gym.tasks.terms import Columns, EpisodeState, Mirrored, Simulation, diagonal, signed, unit
from irsim_gym.tasks.terms.term import Bound, Needs, Term

WIDTH = 6


@dataclass
class Robots(Struct):
    """The robots, and scratch memory for the nearest ones found so far, nearest first.

    Attributes:
        bodies: Bodies of the robots, shape ``(n_robots,)``.
        distance: Squared distances of the nearest ones [m2], shape ``(n_slots, count)``.
        found: Bodies of the nearest ones, -1 for none, shape ``(n_slots, count)``.
    """

    bodies: Ints
    distance: Floats
    found: Ints


@kind
class Neighbors:
    """The nearest other robots, nearest first, six numbers each; zeros for missing robots.

    The numbers are x, y of its origin in the agent's frame, divided by ``range``; its velocity relative to the agent in
    the agent's frame, divided by ``speed``; its reach (radius of the disc around its origin that encloses it), divided
    by ``range``; and 1 if there is a robot. Robots whose origin is farther away than ``range`` are not seen. Learners
    and robots with a behaviour are observed alike.
    """

    needs_goal: ClassVar[bool] = False
    needs: ClassVar[Needs] = ("bodies",)

    count: int = option(6, ge=1, le=64, meaning="Number of robots observed.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="Range of view; default: the world's diagonal.")
    speed: float = option(2.0, gt=0.0, unit="m/s", meaning="Relative speed that reads 1; faster speeds are clipped.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Robots:
        """Return the robots, and scratch memory."""
        shape = (simulation.shards.n_slots, self.count)
        return Robots(np.array(simulation.scenario.robots, np.int64), np.zeros(shape), np.zeros(shape, np.int64))

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds, six for each robot."""
        low = np.array([-1.0, -1.0, -1.0, -1.0, 0.0, 0.0], np.float32)
        return np.tile(low, self.count), np.ones(WIDTH * self.count, np.float32)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        far = self.range or diagonal(model.bounds)
        over, pace = f"x / {far:.3g} m", f"v / {self.speed:g} m/s, relative to the robot"
        columns = [
            Columns("nearest other robot: its origin, how far ahead", over),
            Columns("nearest other robot: how far to the left", over),
            Columns("nearest other robot: speed ahead", pace),
            Columns("nearest other robot: speed to the left", pace),
            Columns("nearest other robot: its reach", over),
            Columns("nearest other robot: 1 if there is one, else 0, and all its other numbers 0"),
        ]
        rest = Columns(f"the same six of each of the {self.count - 1} next nearest", count=WIDTH * (self.count - 1))
        return [*columns, rest] if self.count > 1 else columns

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        return signed(1.0, -1.0, 1.0, -1.0, 1.0, 1.0, times=self.count)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the robots' numbers."""
        write_neighbors(shard.worlds, shard.slot, term.bound, term.arrays, model, state, episode)


@kernel
def write_neighbors(
    worlds: Ints, slot: int, term: Bound, robots: Robots, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write six numbers for each of the nearest robots.

    Reads: term (agents, column, options), robots (bodies, distance, found), model (bounds, present, reach), state
        (pose, stopped, twist).
    Writes: robots (distance, found), episode (observation).
    """
    options, distance, found = term.options[0], robots.distance[slot], robots.found[slot]
    far = diagonal(model.bounds) if np.isnan(options.range) else options.range
    for w in worlds:
        reach = model.reach[row_of(model.reach, w)]
        for a in range(term.agents.shape[0]):
            own = term.agents[a]
            distance[:], found[:] = far * far, -1
            for b in robots.bodies:
                if b != own and model.present[w, b]:
                    dx, dy = state.pose[w, b, 0] - state.pose[w, own, 0], state.pose[w, b, 1] - state.pose[w, own, 1]
                    insert(dx * dx + dy * dy, b, distance, found)
            row = episode.observation[w, a, term.column : term.column + WIDTH * found.shape[0]]
            for k in range(found.shape[0]):
                describe(w, own, found[k], far, options.speed, reach, state, row[WIDTH * k :])


@kernel
def insert(squared: float, body: int, distance: Floats, found: Ints) -> None:
    """Insert a body into the sorted list of the nearest ones; among equal distances, the earlier body stays first."""
    k = distance.shape[0] - 1
    if squared >= distance[k]:
        return
    while k > 0 and squared < distance[k - 1]:
        distance[k], found[k] = distance[k - 1], found[k - 1]
        k -= 1
    distance[k], found[k] = squared, body


@kernel
def describe(w: int, own: int, body: int, far: float, speed: float, reach: Floats, state: State, out: Rays) -> None:
    """Write the six numbers of a body, clipped to [-1, 1]; zeros for none (-1).

    Reads: state (pose, stopped, twist).
    Writes: out.
    """
    for c in range(WIDTH):
        out[c] = np.float32(0.0)
    if body < 0:
        return
    cosine, sine = np.cos(state.pose[w, own, 2]), np.sin(state.pose[w, own, 2])
    dx, dy = state.pose[w, body, 0] - state.pose[w, own, 0], state.pose[w, body, 1] - state.pose[w, own, 1]
    vx = moving(w, body, 0, state) - moving(w, own, 0, state)
    vy = moving(w, body, 1, state) - moving(w, own, 1, state)
    out[0], out[1] = unit((dx * cosine + dy * sine) / far), unit((dy * cosine - dx * sine) / far)
    out[2], out[3] = unit((vx * cosine + vy * sine) / speed), unit((vy * cosine - vx * sine) / speed)
    out[4] = unit(reach[body] / far)
    out[5] = np.float32(1.0)
