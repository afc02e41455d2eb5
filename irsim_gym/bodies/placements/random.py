"""random: uniform in a box, clear of all obstacles, with reachable goals."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from irsim_gym.base.options import crossed_bounds, kind, option
from irsim_gym.bodies.placements.free_space import confirm_ways, length_option, length_problems, way_grids
from irsim_gym.bodies.placements.manual import world_box
from irsim_gym.bodies.placements.random_draws import DrawTables, draw_members
from irsim_gym.bodies.placements.several_goals import goals_option, misfit_of_goals
from irsim_gym.simulator.paths.grid import Grid
from irsim_gym.simulator.world.names import Floats, Group, Ints, Model, Pose, Shard, State

MARGIN = 0.5
"""Distance of the default bounds from the edge of the world [m]."""
WISHED_DISTANCE = 1.0
"""Default distance between members of an entry, if there is room for it [m]."""
FULLEST = 0.45
"""Share of a plane that randomly placed discs cover without many draws; they never cover more than 0.547 of it
(Feder, Journal of Theoretical Biology 87, 1980).
"""
COARSE, FINE = 1.0, 0.5
"""Cell sizes, relative to the reach of the body whose path is searched."""


@kind
class RandomPlacement:
    """Uniform draws without overlap. Too many failed draws raise an error that names the body."""

    is_random: ClassVar[bool] = True
    roams: ClassVar[bool] = True
    gives_goal: ClassVar[bool] = True

    range_low: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Lower bounds; by default the world drawn in by 0.5 m, and -pi."
    )
    range_high: tuple[float, float, float] | None = option(
        None, unit="m, m, rad", meaning="Upper bounds; by default the world drawn in by 0.5 m, and pi."
    )
    goal_low: Pose | None = option(None, unit="m, m, rad", meaning="Lower bounds of goals; default: those of starts.")
    goal_high: Pose | None = option(None, unit="m, m, rad", meaning="Upper bounds of goals; default: those of starts.")
    min_distance: float | None = option(
        None,
        ge=0.0,
        unit="m",
        meaning="Minimum distance between the origins (and between the goals) of one entry. Default: 1 m, or 0 if "
        "there is no room for that.",
        consequence="As clearance.",
    )
    clearance: float = option(
        0.0,
        ge=0.0,
        unit="m",
        meaning="Surface distance kept from everything else, also by bodies that are placed later.",
        consequence="Large in a full world: levels take long to draw, or cannot be.",
    )
    min_goal_distance: float = option(
        0.0, ge=0.0, unit="m", meaning="Least way to the goal.", consequence="Too large: an error names the body."
    )
    reachable: bool = option(False, meaning="Draw only goals that a disc around the body can reach past static ones.")
    goals: int = goals_option()
    min_way_length: float = length_option("min_way_length")
    max_way_length: float | None = length_option("max_way_length")

    def problems(self) -> Iterator[tuple[str, str]]:
        """Yield key and message of invalid or conflicting options."""
        yield from length_problems(self.min_way_length, self.max_way_length)
        if self.range_low is not None and self.range_high is not None:
            yield from crossed_bounds(self.range_low, self.range_high)
        if self.goal_low is not None and self.goal_high is not None:
            yield from crossed_bounds(self.goal_low, self.goal_high, "goal_low", "goal_high")

    @property
    def n_goals(self) -> int:
        """Number of goals of each member."""
        return self.goals

    @property
    def ensures_way(self) -> bool:
        """Whether all levels have a path from start to goal, and from each goal to the next."""
        return self.reachable or self.min_way_length > 0.0 or self.max_way_length is not None

    @staticmethod
    def prepare(group: Group, model: Model, n_slots: int) -> str | None:
        """Compute the bounds, allocate the grid for searching paths, and return what does not fit."""
        options = group.options[0]
        low, high, goal_low, goal_high = bounds = _bounds(options, model)
        for name, lower, upper in (("range", low, high), ("goal", goal_low, goal_high)):
            if np.any(lower > upper):
                ends = [[round(float(value), 6) for value in bound] for bound in (lower, upper)]
                missing = f"the world less {MARGIN} m" if name == "range" else "that of the starts"
                return f"{name}_low {ends[0]} exceeds {name}_high {ends[1]}; what is not given is {missing}"
        if (misfit := misfit_of_goals(group, model)) is not None:
            return misfit
        most = float(np.hypot(*np.maximum(np.abs(goal_high - low), np.abs(high - goal_low))[:2]))
        if options.min_goal_distance > most:
            distance = f"min_goal_distance {options.min_goal_distance:g}"
            return f"{distance} exceeds the distance between the farthest start and goal, {most:.3g} m"
        corners = np.array([*(bound[:2] for bound in bounds), model.bounds[:2], model.bounds[2:]])
        # The grid covers the world, and the boxes of starts and goals where these go beyond it.
        area = (*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())
        min_distance = options.min_distance
        if min_distance is None:
            count = len(group.members)
            has_room = _has_room(count, low, high) and _has_room(count * options.goals, goal_low, goal_high)
            min_distance = WISHED_DISTANCE if has_room else 0.0
        everyone = np.arange(len(model.role))
        spacing, clearance, away = float(min_distance), float(options.clearance), float(options.min_goal_distance)
        model.kept_clearance[group.members] = clearance
        # Where no way is searched for, grids of a few cells save memory.
        reach = float(np.max(model.bounds[2:] - model.bounds[:2]))
        if options.ensures_way:
            reach = float(np.min(model.reach[:, group.members]))
        limits = np.array([options.min_way_length, options.max_way_length or np.inf])
        grids = [Grid.over(area, share * reach) for share in (COARSE, FINE)]
        is_member = np.isin(everyone, group.members)
        numbers = spacing, clearance, away, options.ensures_way
        tables = DrawTables(*bounds, *numbers, limits, is_member, group.members, everyone)
        group.tables = tables, way_grids(grids, n_slots, len(everyone), limits.tolist())
        return None

    @staticmethod
    def draw(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Draw starts and goals; ``failed[w]`` becomes body + 1 if a member finds no place."""
        tables, grids = group.tables
        grids = grids.of_slot(shard.slot)
        draw_members(shard.worlds, tables, grids, model, state, model.cells, failed)

    @staticmethod
    def confirm(group: Group, model: Model, state: State, shard: Shard, failed: Ints) -> None:
        """Set ``failed`` where bodies that were placed later block a member's way, or make it too long."""
        tables, grids = group.tables
        grids = grids.of_slot(shard.slot)
        confirm_ways(shard.worlds, group.members, tables.limits, grids, model, state, model.cells, failed)


def _has_room(count: int, low: Floats, high: Floats) -> bool:
    """Return whether ``count`` points with distances of ``WISHED_DISTANCE`` fit into a box."""
    # Discs of half the distance about the points, which stick out of the box by their radius on each side.
    width, height = high[:2] - low[:2] + WISHED_DISTANCE
    return bool(count * np.pi * (WISHED_DISTANCE / 2.0) ** 2 <= FULLEST * width * height)


def _bounds(options: RandomPlacement, model: Model) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the lower and upper bounds of the starts and of the goals."""
    low, high = world_box(model, MARGIN)
    low = low if options.range_low is None else np.array(options.range_low, np.float64)
    high = high if options.range_high is None else np.array(options.range_high, np.float64)
    goal_low = low if options.goal_low is None else np.array(options.goal_low, np.float64)
    goal_high = high if options.goal_high is None else np.array(options.goal_high, np.float64)
    return low, high, goal_low, goal_high
