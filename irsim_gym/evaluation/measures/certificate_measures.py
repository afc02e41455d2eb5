"""What a level demands of a robot: whether a path exists, its length, its width, and the minimum time."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats
from irsim_gym.simulator.cell_paths.queries import FINE, free_path_length, has_free_path, standing_bodies
from irsim_gym.simulator.world.model import ACKERMANN, DIFFERENTIAL, NO_DRIVE, Model
from irsim_gym.simulator.world.state import State

PRECISION = 1e-3
"""Precision to which the clearance of the widest path is bisected [m]."""
ROUNDING = 1e-9
"""Tolerance of ``least_steps`` [steps], so that rounding never adds a step."""


@dataclass(frozen=True)
class LevelMeasures:
    """What a level demands of one robot.

    Attributes:
        reachable: Whether a free path leads from the start through all goals in order.
        length: Length of the shortest path found [m]; infinite without one.
        straight: Length of the straight lines from the start through all goals [m].
        clearance: Clearance to standing obstacles along the widest path [m], which start and goals may bound; NaN
            without a path, infinite without obstacles.
        least_time: Lower bound of the time for the limits of speed and acceleration [s]; infinite without a path.
    """

    reachable: bool
    length: float
    straight: float
    clearance: float
    least_time: float


def measure_level(
    model: Model, state: State, world: int, body: int, *, radius: float | None = None, cell: float = FINE
) -> LevelMeasures:
    """Measure the level of a world for a disc around the origin of one body.

    Standing bodies and the map are obstacles; moving bodies are not. Paths are searched on a grid, so that a gap hardly
    wider than the disc may be missed (see ``simulator.paths.reachability``). All paths found are tested exactly to be
    free.

    Args:
        state: State at the start of the episode: outlines, and goals that are not reached yet.
        radius: Radius of the disc [m]; by default that of the disc about the body's origin that encloses its footprint.
        cell: Side of the cells [m].

    Returns:
        The measures. ``length`` is that of an existing path, about 0.1 % above the shortest, and up to 3 % if paths on
        different sides of an obstacle have nearly equal lengths; ``least_time`` is that of a path of this length.
    """
    reach = float(model.reach[world % len(model.reach), body]) if radius is None else float(radius)
    stops = np.concatenate([state.pose[world, body, None, :2], _goals(model, state, world, body)])
    blocks = standing_bodies(model, world)
    blocks[body] = False
    legs = [free_path_length(model, state, world, reach, *leg, blocks=blocks, cell=cell) for leg in pairwise(stops)]
    steps = np.diff(stops, axis=0)
    is_reachable = math.isfinite(sum(legs))
    return LevelMeasures(
        reachable=is_reachable,
        length=sum(legs),
        straight=float(np.hypot(steps[:, 0], steps[:, 1]).sum()),
        clearance=_widest(model, state, world, reach, stops, blocks, cell) if is_reachable else math.nan,
        least_time=least_steps(model, state, world, body, legs) * float(model.step_time[0]),
    )


def is_disc(model: Model, body: int) -> bool:
    """Return whether a body is a disc about its origin, in all worlds."""
    if model.segment_count[:, body].any() or (model.disc_count[:, body] != 1).any():
        return False
    return not model.local_discs[:, model.disc_start[body], :2].any()


def _goals(model: Model, state: State, world: int, body: int) -> Floats:
    """Return the goals that are not reached yet, in order, shape ``(n, 2)`` [m]."""
    if not model.has_goal[body]:
        return np.zeros((0, 2))
    return model.waypoints[world, body, int(state.waypoint[world, body]) : int(state.waypoint_end[world, body]), :2]


def _widest(model: Model, state: State, world: int, radius: float, stops: Floats, blocks: Flags, cell: float) -> float:
    """Return by how much a disc can grow until one of the paths is blocked [m]: the clearance of the widest paths."""

    def are_open(ways: Iterable[tuple[Floats, Floats]], more: float) -> bool:
        reach = radius + more
        return all(has_free_path(model, state, world, reach, *ends, blocks=blocks, cell=cell) for ends in ways)

    stands, ways = [(place, place) for place in stops], list(pairwise(stops))
    farthest = float(np.hypot(model.bounds[2] - model.bounds[0], model.bounds[3] - model.bounds[1]))
    if are_open(stands, farthest):
        return math.inf
    # Testing start and goals is cheap, and often no place on the path is narrower.
    room = _bisect(partial(are_open, stands), farthest)
    return room if are_open(ways, room) else _bisect(partial(are_open, ways), room)


def _bisect(holds: Callable[[float], bool], high: float) -> float:
    """Return the largest number up to ``high`` for which ``holds`` is true, less at most ``PRECISION``."""
    low = 0.0
    while high - low > PRECISION:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def least_steps(model: Model, state: State, world: int, body: int, legs: Sequence[float]) -> float:
    """Return the least number of steps in which a body can drive paths from goal to goal; infinite if it cannot.

    The body accelerates from its present velocity as fast as possible and never brakes, and it reaches and leaves each
    goal at its threshold: n steps of acceleration a cover n v dt + a dt^2 n (n + 1) / 2. The limits of drives from
    plugins are unknown, so one step counts as enough for them.

    Args:
        legs: Lengths of the paths [m].
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
