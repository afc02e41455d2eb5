"""Movable bodies: the nearest bodies that can be pushed, and where they belong."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Floats, Ints, Point, Rays
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.world.rows import row_of
from irsim_gym.tasks.observations.bodies.nearest_bodies import moving
from irsim_gym.tasks.observations.bodies.neighbors import insert
from irsim_gym.tasks.observations.own.own_body import HALF_RADIUS, share_of
from irsim_gym.tasks.observations.seen_map.way_columns import write_direction
from irsim_gym.tasks.terms import EpisodeState, Model, Shard, State, Struct, kernel, kind, option
from irsim_gym.tasks.terms.mirrored import Mirrored, signed
from irsim_gym.tasks.terms.scaling import diagonal, unit
from irsim_gym.tasks.terms.targets import OfBodies, Targets, has_goal, lies_there, way_to_target
from irsim_gym.tasks.terms.term import Bound, Needs, Term
from irsim_gym.tasks.terms.words import Columns

Scales = tuple[float, float, float]
"""Distance that reads 1 and distance of the near terms [m], and speed that reads 1 [m/s]."""
BODY, TARGET = 11, 5
"""Numbers of a body, and of its target."""


@dataclass
class Movable(Struct):
    """The bodies that can be pushed, and scratch memory for the nearest ones found so far, nearest first.

    Attributes:
        targets: The bodies, and where they belong.
        aims: Whether each has a target, 0 or 1, shape ``(n,)``.
        distance: Squared distances of the nearest ones [m2], shape ``(n_slots, count)``.
        found: Which they are of these bodies, -1 for none, shape ``(n_slots, count)``.
        grip: Greatest force of friction of every body with the ground [N], shape ``(n_bodies,)``.
    """

    targets: Targets
    aims: Ints
    distance: Floats
    found: Ints
    grip: Floats


@kind
class MovableBodies(OfBodies):
    """The bodies that can be pushed, 16 numbers each, those outside of their targets first, and the nearest first.

    The numbers are cosine and sine of the bearing of the body's origin, its distance d as ``d / range`` and
    ``exp(-d / near)``; cosine and sine of its heading relative to the agent's; its velocity relative to the agent, in
    the agent's frame, divided by ``speed``; its reach; its friction with the ground f as ``f / (f + own)``, more than
    0.5 where the agent alone cannot push it; and 1 if there is a body. Then, of the way from its origin to its target,
    the direction in the agent's frame and both distances, and 1 if it lies there; zeros without a target.
    """

    needs: ClassVar[Needs] = ("bodies",)

    count: int = option(3, ge=1, le=64, meaning="Number of bodies observed.")
    range: float | None = option(None, gt=0.0, unit="m", meaning="Range of view; default: the world's diagonal.")
    near: float = option(1.0, gt=0.0, unit="m", meaning="Distance over which near terms fall to 1/e.")
    speed: float = option(2.0, gt=0.0, unit="m/s", meaning="Relative speed that reads 1; faster speeds are clipped.")
    target: bool = option(True, meaning="Whether to show the target, the last five numbers of each body.")

    def arrays(self, simulation: Simulation, agents: Ints) -> Movable:
        """Return the bodies, and scratch memory."""
        shape, targets = (simulation.shards.n_slots, self.count), self.targets(simulation, len(agents))
        aims = [self.area is not None or has_goal(simulation.scenario, int(b)) for b in targets.bodies]
        grip = simulation.context.weighed().substance["grip"].copy()
        return Movable(targets, np.array(aims, np.int64), np.zeros(shape), np.zeros(shape, np.int64), grip)

    def bounds(self, term: Term, model: Model) -> tuple[Rays, Rays]:
        """Return the bounds of the numbers of each body."""
        way, rest = [-1.0, -1.0, 0.0, 0.0], [-1.0, -1.0, -1.0, -1.0, 0.0, 0.0, 0.0]
        low = np.tile(np.array([*way, *rest, *([*way, 0.0] if self.target else [])], np.float32), self.count)
        return low, np.ones_like(low)

    def columns(self, term: Term, model: Model, agent: int) -> list[Columns]:
        """Return the meaning of the columns."""
        far, what, left = self.range or diagonal(model.bounds), "first movable body: ", "to the left positive"
        near = f"exp(-d / {self.near:g} m)"
        columns = [
            Columns(f"{what}cosine and sine of its bearing", f"0 straight ahead, {left}", 2),
            Columns(f"{what}distance d of its origin", f"d / {far:.3g} m"),
            Columns(f"{what}nearness of its origin", near),
            Columns(f"{what}cosine and sine of its heading, relative to the robot's", left, 2),
            Columns(f"{what}speed ahead and to the left, relative to the robot", f"v / {self.speed:g} m/s", 2),
            Columns(f"{what}its reach r", f"r / (r + {HALF_RADIUS:g} m)"),
            Columns(f"{what}friction f with the ground", "f / (f + own); above 0.5, it is too heavy for the robot"),
            Columns(f"{what}1 if there is one, else 0, and all its other numbers 0"),
        ]
        aim = [
            Columns(f"{what}cosine and sine of the direction to its target", f"0 straight ahead, {left}", 2),
            Columns(f"{what}distance d from its target", f"d / {far:.3g} m, at most 1"),
            Columns(f"{what}nearness of its target", near),
            Columns(f"{what}1 if it lies in its target, else 0"),
        ]
        columns += aim if self.target else []
        width = BODY + TARGET * self.target
        rest = Columns("the same of each of the next bodies", count=width * (self.count - 1))
        return [*columns, rest] if self.count > 1 else columns

    def mirrored(self, term: Term) -> Mirrored:
        """Return the columns; what is positive to the left changes its sign."""
        own = (1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0)
        return signed(*own, *((1.0, -1.0, 1.0, 1.0, 1.0) if self.target else ()), times=self.count)

    @staticmethod
    def write(term: Term, model: Model, state: State, episode: EpisodeState, shard: Shard) -> None:
        """Write the bodies' numbers."""
        write_movable(shard.worlds, shard.slot, term.bound, term.arrays, model, state, episode)


@kernel
def write_movable(
    worlds: Ints, slot: int, term: Bound, movable: Movable, model: Model, state: State, episode: EpisodeState
) -> None:
    """Write the numbers of the first bodies, zeros where there is none.

    Reads: term (agents, column, options), movable (aims, distance, found, grip, targets), model (arrive_mode, bounds,
        goal_threshold, present, reach), state (goal, pose, stopped, twist, waypoint, waypoint_end).
    Writes: movable (distance, found), episode (observation).
    """
    options, distance, found = term.options[0], movable.distance[slot], movable.found[slot]
    bodies, area = movable.targets.bodies, movable.targets.area
    far = diagonal(model.bounds) if np.isnan(options.range) else options.range
    width = BODY + (TARGET if options.target != 0 else 0)
    for w in worlds:
        for a in range(term.agents.shape[0]):
            own = term.agents[a]
            distance[:], found[:] = np.inf, -1
            for k in range(bodies.shape[0]):
                b = bodies[k]
                dx, dy = state.pose[w, b, 0] - state.pose[w, own, 0], state.pose[w, b, 1] - state.pose[w, own, 1]
                squared = dx * dx + dy * dy
                if model.present[w, b] and squared <= far * far:
                    is_done = movable.aims[k] != 0 and lies_there(w, b, area, model, state)
                    # Bodies in their targets come behind all others.
                    insert(squared + (far * far if is_done else 0.0), k, distance, found)
            row = episode.observation[w, a, term.column : term.column + width * found.shape[0]]
            row[:] = 0.0
            scales = far, options.near, options.speed
            for i in range(found.shape[0]):
                if found[i] < 0:
                    break
                b, part = bodies[found[i]], row[width * i : width * (i + 1)]
                describe_movable(w, own, b, scales, movable.grip, model, state, part)
                if options.target != 0 and movable.aims[found[i]] != 0:
                    write_leg(
                        part[BODY:], state.pose[w, own, 2], way_to_target(w, b, area, state.goal[w, b], state), scales
                    )
                    part[BODY + 4] = np.float32(lies_there(w, b, area, model, state))


@kernel
def describe_movable(
    w: int, own: int, body: int, scales: Scales, grip: Floats, model: Model, state: State, out: Rays
) -> None:
    """Write the numbers of a body without those of its target.

    Reads: model (reach), state (pose, stopped, twist).
    Writes: out.
    """
    heading = state.pose[w, own, 2]
    cosine, sine = np.cos(heading), np.sin(heading)
    way = state.pose[w, body, 0] - state.pose[w, own, 0], state.pose[w, body, 1] - state.pose[w, own, 1]
    write_leg(out, heading, way, scales)
    out[4], out[5] = (
        np.float32(np.cos(state.pose[w, body, 2] - heading)),
        np.float32(np.sin(state.pose[w, body, 2] - heading)),
    )
    vx = moving(w, body, 0, state) - moving(w, own, 0, state)
    vy = moving(w, body, 1, state) - moving(w, own, 1, state)
    out[6], out[7] = unit((vx * cosine + vy * sine) / scales[2]), unit((vy * cosine - vx * sine) / scales[2])
    out[8] = share_of(model.reach[row_of(model.reach, w), body], HALF_RADIUS)
    out[9] = unit(grip[body] / (grip[body] + grip[own])) if grip[body] > 0.0 else np.float32(0.0)
    out[10] = np.float32(1.0)


@kernel
def write_leg(out: Rays, heading: float, way: Point, scales: Scales) -> None:
    """Write direction in the agent's frame, length and nearness of a way [m].

    Writes: out.
    """
    d = write_direction(out, (0.0, 0.0), (np.cos(heading), np.sin(heading)), way)
    out[2], out[3] = np.float32(min(d / scales[0], 1.0)), np.float32(np.exp(-d / scales[1]))
