"""The shortest path in a scenario, or in a world by hand, in one call."""

import math

from numpy.typing import ArrayLike

from irsim_gym.base.arraytypes import Floats
from irsim_gym.base.errors import NoWayError
from irsim_gym.live.planning.path_planner import point
from irsim_gym.live.session.level_source import ScenarioSource
from irsim_gym.live.session.roster import Reference
from irsim_gym.live.world import World
from irsim_gym.simulator.cell_paths.queries import FINE, blocking_bodies, fixed_bodies


def plan(
    world_or_scenario: World | ScenarioSource,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    robot: Reference | None = None,
    radius: float | None = None,
    clearance: float = 0.0,
    resolution: float = FINE,
    seed: int | None = None,
) -> Floats:
    """Return the points of a shortest path around everything that never moves.

    The path consists of straight lines on which a disc touches nothing, which is tested exactly. It is that of
    ``World.path``, about 0.1 % longer than the shortest one. Bodies that can move are ignored.

    Args:
        world_or_scenario: A world from ``irsim_gym.load`` at its present moment, or what ``load`` takes: a shipped
            name, an id, the path of a YAML file, or the same as plain data.
        start: x and y [m]; further numbers are ignored, so a state will do; flat or a column.
        goal: Likewise.
        robot: Name or number of the body that gives the radius (default: the first robot).
        radius: Radius of the disc [m], instead of that of a body.
        clearance: Distance of the disc from all obstacles [m].
        resolution: Side of the cells of the search [m]. A gap that is hardly wider than the disc may be missed.
        seed: Level of a scenario that draws its levels. A world has a level already.

    Returns:
        The points from start to goal [m], shape ``(n, 2)``, at least two.

    Raises:
        NoWayError: Start or goal is blocked, and the error says by what; or no way leads from one to the other.
        UnknownNameError: Nothing is shipped under the name, or no body has it.
        ScenarioError: The file cannot be used.
        ValueError: A point is none, the radius or clearance is negative, or the resolution is not positive; or a seed
            is given with a world.
    """
    if isinstance(world_or_scenario, World):
        if seed is not None:
            raise ValueError("a world has a level already: leave seed out, or give the scenario")
        world = world_or_scenario
    else:
        world = World(world_or_scenario, seed=seed)
    if not 0.0 <= clearance < math.inf:
        raise ValueError(f"clearance must be >= 0 [m], got {clearance!r}")
    model = world.simulation.model
    if radius is None:
        body = world.simulation.body(world.robot.name if robot is None else world[robot].name)
        radius = float(model.reach[0, body])
    size = float(radius) + clearance
    way = world.path(start, goal, size, resolution=resolution)
    if way is None:
        raise NoWayError(_why(world, size, point(start, "start"), point(goal, "goal")))
    return way


def _why(world: World, radius: float, start: tuple[float, float], goal: tuple[float, float]) -> str:
    """Return why a disc has no path."""
    model, state = world.simulation.model, world.simulation.state
    for name, (x, y) in (("start", start), ("goal", goal)):
        blocking = blocking_bodies(model, state, 0, radius, (x, y), fixed_bodies(model, 0))
        names = ", ".join("the obstacle map" if b is None else f"'{world.simulation.parts.names[b]}'" for b in blocking)
        if names:
            return f"the {name} ({x:g}, {y:g}) is nearer than {radius:g} m to {names}"
        x_min, y_min, x_max, y_max = model.bounds
        if not (x_min <= x <= x_max and y_min <= y <= y_max):
            reach = f"x from {x_min:g} to {x_max:g} and y from {y_min:g} to {y_max:g} m"
            return f"the {name} ({x:g}, {y:g}) is outside of the world, {reach}, and no straight way leads there"
    return (
        f"no way for a disc of radius {radius:g} m from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g}): "
        "take a smaller radius or clearance, or a finer resolution where a gap is narrow"
    )
