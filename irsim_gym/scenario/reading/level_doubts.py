"""Finds levels of a file that begin badly: in an occupied cell, outside the world, or at the goal."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.scenario.specs.spec import BodySpec, Scenario
from irsim_gym.scenario.specs.world_spec import WorldSpec

MOST_TOLD = 3
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


def level_doubts(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Yield remarks about starts in a scenario's file of levels, each with the name of its body.

    Only centres of bodies are tested, and against cells alone: what touches outlines is for ``levels certify`` to find.
    """
    levels = scenario.levels
    if levels is None:
        return
    bodies = {body.name: body for body in scenario.bodies}
    for k, name in enumerate(levels.bodies):
        body = bodies.get(name)
        if body is None or body.static:
            continue
        place = levels.start[:, k, :2]
        for flags, what in (
            (_outside(place, scenario.world), "outside the world"),
            (_at_goal(levels, k, body), "at the goal, closer than its goal_threshold"),
            (_in_cells(place, scenario, levels, body), "in an occupied cell"),
        ):
            level_numbers = np.flatnonzero(flags & levels.present[:, k]).tolist()
            if level_numbers:
                more = f" and {len(level_numbers) - MOST_TOLD} more" if len(level_numbers) > MOST_TOLD else ""
                yield name, f"starts {what} in level {', '.join(map(str, level_numbers[:MOST_TOLD]))}{more}"


def _outside(place: Floats, world: WorldSpec) -> Flags:
    end = np.add(world.offset, (world.width, world.height))
    return np.asarray(((place < world.offset) | (place > end)).any(axis=1))


def _at_goal(levels: LevelSet, k: int, body: BodySpec) -> Flags:
    """Return the levels in which the only goal of a body, which has a drive to go there, is where it starts."""
    goals = levels.goal[:, k, :, :2].copy()
    if len(body.goal) == 1:
        goals[np.isnan(goals[:, 0, 0]), 0] = body.goal[0][:2]
    distance = np.hypot(*(goals[:, 0] - levels.start[:, k, :2]).T)
    has_more = np.isfinite(goals[:, 1:, 0]).any(axis=1) | (len(body.goal) > 1)
    counts = body.arrive_mode == "position" and not body.coasts
    return np.asarray((distance < body.goal_threshold) & ~has_more & counts)


def _in_cells(place: Floats, scenario: Scenario, levels: LevelSet, body: BodySpec) -> Flags:
    """Return the levels in which a centre lies in an occupied cell."""
    world = scenario.world
    if scenario.occupied is None or body.unobstructed or world.collision_mode == "unobstructed":
        return np.zeros(levels.count, np.bool_)
    cells = scenario.occupied[None] if levels.cells is None else levels.cells
    shape = np.array(cells.shape[1:])
    at = np.floor((place - world.offset) / (world.width, world.height) * shape).astype(np.int64)
    inside = ((at >= 0) & (at < shape)).all(axis=1)
    column, row = np.clip(at, 0, shape - 1).T
    return np.asarray(inside & cells[np.arange(levels.count) % len(cells), column, row])
