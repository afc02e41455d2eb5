"""What a level asks of a robot, measured on the level itself: whether there is a way, how long, how wide, how soon."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from irsim_gym.arraytypes import Flags, Floats
from irsim_gym.paths.queries import FINE, free_path_length, has_free_path, standing_bodies
from irsim_gym.world.model import ACKERMANN, DIFFERENTIAL, NO_DRIVE, WorldModel
from irsim_gym.world.state import WorldState

PRECISION = 1e-3
"""The widest way is bisected to this [m]."""
ROUNDING = 1e-9
"""By so many steps a robot may be early in ``least_steps``, so that rounding never adds one."""


@dataclass(frozen=True)
class LevelMeasures:
    """What a level asks of one robot.

    Attributes:
        reachable: A free way leads from the start through all goals in turn.
        length: Length of the shortest one that was found [m], infinite without one.
        straight: Length of the straight way through all goals [m].
        clearance: Least distance from what stands on the widest way [m], which ends may bound; NaN without a way,
            infinite where nothing stands.
        least_time: No robot with these limits of speed and acceleration takes less time [s]; infinite without a way.
    """

    reachable: bool
    length: float
    straight: float
    clearance: float
    least_time: float

    @property
    def tortuosity(self) -> float:
        """Length of the shortest way over the straight one, at least 1; 1 where start and goals are one point."""
        return max(self.length / self.straight, 1.0) if self.straight > 0.0 else 1.0


def measure_level(
    model: WorldModel, state: WorldState, world: int, body: int, *, radius: float | None = None, cell: float = FINE
) -> LevelMeasures:
    """Measure the level that a world plays, for a disc around the origin of one body.

    What stands is in the way, bodies and the map; what moves is not. Ways are sought over cells, so that a gap hardly
    wider than the disc may be missed (see ``paths.reachability``), and all that is found is free, tested exactly.

    Args:
        model: Constants of the episode.
        state: Its beginning: outlines, and goals that are not reached yet.
        world: Which world.
        body: Who drives.
        radius: Radius of the disc [m]; by default the one about the body's origin that holds its footprint.
        cell: Side of the cells [m].

    Returns:
        The measures. ``length`` is that of a path that exists, some 0.1 % above the shortest and up to 3 % where ways
        on different sides of something are nearly equally long; ``least_time`` is that of a way of this length.
    """
    own = float(model.reach[world % len(model.reach), body]) if radius is None else float(radius)
    stops = np.concatenate([state.pose[world, body, None, :2], _goals(model, state, world, body)])
    blocks = standing_bodies(model, world)
    blocks[body] = False
    legs = [
        free_path_length(model, state, world, own, begin, end, blocks=blocks, cell=cell)
        for begin, end in pairwise(stops)
    ]
    steps = np.diff(stops, axis=0)
    is_reachable = math.isfinite(sum(legs))
    return LevelMeasures(
        reachable=is_reachable,
        length=sum(legs),
        straight=float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        clearance=_widest(model, state, world, own, stops, blocks, cell) if is_reachable else math.nan,
        least_time=least_steps(model, state, world, body, legs) * float(model.step_time[0]),
    )


def is_disc(model: WorldModel, body: int) -> bool:
    """Return whether a body is a disc about its origin, in all worlds."""
    if model.segment_count[:, body].any() or (model.disc_count[:, body] != 1).any():
        return False
    return not model.local_discs[:, model.disc_start[body], :2].any()


def _goals(model: WorldModel, state: WorldState, world: int, body: int) -> Floats:
    """Return the goals that are not reached yet, in turn, shape ``(n, 2)`` [m]."""
    if not model.has_goal[body]:
        return np.zeros((0, 2))
    return model.waypoints[world, body, int(state.waypoint[world, body]) : int(state.waypoint_end[world, body]), :2]


def _widest(
    model: WorldModel, state: WorldState, world: int, radius: float, stops: Floats, blocks: Flags, cell: float
) -> float:
    """Return by how much a disc may grow before one of the ways is closed to it [m]: the bottleneck path of all."""

    def are_open(ways: Iterable[tuple[Floats, Floats]], more: float) -> bool:
        own = radius + more
        return all(has_free_path(model, state, world, own, *ends, blocks=blocks, cell=cell) for ends in ways)

    stands, ways = [(place, place) for place in stops], list(pairwise(stops))
    farthest = float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
    if are_open(stands, farthest):
        return math.inf
    # Where the disc may stand costs little, and often nothing on the way is narrower.
    room = _bisect(partial(are_open, stands), farthest)
    return room if are_open(ways, room) else _bisect(partial(are_open, ways), room)


def _bisect(holds: Callable[[float], bool], high: float) -> float:
    """Return the greatest number for which something holds, less up to ``PRECISION``; it holds for 0 if at all."""
    low = 0.0
    while high - low > PRECISION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def least_steps(model: WorldModel, state: WorldState, world: int, body: int, legs: Sequence[float]) -> float:
    """Return how many steps a body needs at least for ways from goal to goal [m], infinite if it cannot drive them.

    It speeds up from its present velocity as fast as it may and never slows down, and each goal is reached at its
    threshold, where it is left too: n steps of acceleration a cover n v dt + a dt^2 n (n + 1) / 2. Nothing is known of
    drives of plugins, for which one step is enough.
    """
    row, dt = world % len(model.velocity_max), float(model.step_time[0])
    threshold = float(model.goal_threshold[world % len(model.goal_threshold), body])
    way = sum(max(leg - threshold * (1.0 if k == 0 else 2.0), 0.0) for k, leg in enumerate(legs))
    axes = slice(0, 1) if model.drive[body] in (DIFFERENTIAL, ACKERMANN) else slice(0, 2)
    limits = np.maximum(np.abs(model.velocity_max[row, body, axes]), np.abs(model.velocity_min[row, body, axes]))
    fastest = float(np.hypot.reduce(limits))
    sharpest = float(np.hypot.reduce(model.acceleration_limit[world % len(model.acceleration_limit), body, axes]))
    now = min(float(np.hypot.reduce(state.velocity[world, body, axes])), fastest)
    if not math.isfinite(way):
        return math.inf
    if way == 0.0 or model.drive[body] == NO_DRIVE:
        return 1.0
    if fastest == 0.0 or (sharpest == 0.0 and now == 0.0):
        return math.inf
    ramp = 0.0
    if 0.0 < sharpest < math.inf:
        ramp = math.floor((fastest - now) / (sharpest * dt) + ROUNDING)
        b, a = now * dt + 0.5 * sharpest * dt * dt, 0.5 * sharpest * dt * dt
        covered = ramp * b + ramp * ramp * a
        if way <= covered:
            return max(math.ceil((math.sqrt(b * b + 4.0 * a * way) - b) / (2.0 * a) - ROUNDING), 1.0)
        way -= covered
    constant = fastest if sharpest > 0.0 else now
    return max(ramp + math.ceil(way / (constant * dt) - ROUNDING), 1.0)
