"""Finds levels of a file that begin badly: in something that stands still, outside the world, or at the goal."""

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

    Only centres of bodies are tested; a start beside a wall that its outline touches is not found.
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
            (_in_walls(place, scenario, levels, body), "in something that stands still"),
        ):
            found = np.flatnonzero(flags & levels.present[:, k]).tolist()
            if found:
                more = f" and {len(found) - MOST_TOLD} more" if len(found) > MOST_TOLD else ""
                yield name, f"starts {what} in level {', '.join(map(str, found[:MOST_TOLD]))}{more}"


def _outside(place: Floats, world: WorldSpec) -> Flags:
    low, size = np.array(world.offset), np.array((world.width, world.height))
    return np.asarray(((place < low) | (place > low + size)).any(axis=1))


def _at_goal(levels: LevelSet, k: int, body: BodySpec) -> Flags:
    """Return the levels in which a body's only goal is where it starts."""
    goals = levels.goal[:, k, :, :2].copy()
    if len(body.goal) == 1:
        goals[np.isnan(goals[:, 0, 0]), 0] = body.goal[0][:2]
    distance = np.hypot(*(goals[:, 0] - levels.start[:, k, :2]).T)
    has_more = np.isfinite(goals[:, 1:, 0]).any(axis=1) | (len(body.goal) > 1)
    return np.asarray((distance < body.goal_threshold) & ~has_more & (body.arrive_mode == "position"))


def _in_walls(place: Floats, scenario: Scenario, levels: LevelSet, body: BodySpec) -> Flags:
    """Return the levels in which a centre lies in an occupied cell, or in a body that stands still."""
    found = np.zeros(levels.count, np.bool_)
    if body.unobstructed or scenario.world.collision_mode == "unobstructed":
        return found
    cells = scenario.occupied[None] if levels.cells is None and scenario.occupied is not None else levels.cells
    if cells is not None and scenario.occupied is not None:
        shape, world = np.array(cells.shape[1:]), scenario.world
        at = np.floor((place - world.offset) / (world.width, world.height) * shape).astype(np.int64)
        inside = ((at >= 0) & (at < shape)).all(axis=1)
        column, row = np.clip(at, 0, shape - 1).T
        found |= inside & cells[np.arange(levels.count) % len(cells), column, row]
    for other in scenario.bodies:
        if other.static and not other.unobstructed and other is not body and other.shape is not None:
            found |= _in_body(place, levels, other)
    return found


def _in_body(place: Floats, levels: LevelSet, other: BodySpec) -> Flags:
    """Return the levels in which points lie in a body: in one of its discs, or within its sides."""
    own = levels.bodies.index(other.name) if other.name in levels.bodies else None
    if own is None and (other.state is None or other.shape.is_random):
        return np.zeros(levels.count, np.bool_)
    pose = np.broadcast_to(np.array(other.state), (levels.count, 3)) if own is None else levels.start[:, own]
    cosine, sine = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    x, y = (place - pose[:, :2]).T
    points = np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=1)
    if own is not None and levels.shaped[own]:
        discs, disc_level = _rows_of(levels.discs, levels.disc_start, own)
        sides, side_level = _rows_of(levels.segments, levels.segment_start, own)
        is_solid = True
    else:
        outline, everyone = other.shape.outline(), np.arange(levels.count)
        discs, disc_level = np.tile(outline.discs, (levels.count, 1)), np.repeat(everyone, len(outline.discs))
        sides, side_level = np.tile(outline.segments, (levels.count, 1)), np.repeat(everyone, len(outline.segments))
        is_solid = outline.solid
    found, crossed = np.zeros(levels.count, np.bool_), np.zeros(levels.count, np.int64)
    found[disc_level[np.hypot(*(points[disc_level] - discs[:, :2]).T) < discs[:, 2]]] = True
    # A ray to the right leaves a closed outline an odd number of times from within.
    px, py = points[side_level].T
    x0, y0, x1, y1 = sides.T
    spans = (y0 > py) != (y1 > py)
    at = x0 + (py - y0) * (x1 - x0) / np.where(spans, y1 - y0, 1.0)
    np.add.at(crossed, side_level[spans & (px < at)], 1)
    present = np.ones(levels.count, np.bool_) if own is None else levels.present[:, own]
    return np.asarray((found | (is_solid & (crossed % 2 == 1))) & present)


def _rows_of(rows: Floats, starts: NDArray[np.int64], k: int) -> tuple[Floats, NDArray[np.int64]]:
    """Return the rows that a file gives a body in all levels, and the level of each."""
    counts = starts[:, k + 1] - starts[:, k]
    level = np.repeat(np.arange(len(starts)), counts)
    first = np.repeat(starts[:, k] - np.cumsum(counts) + counts, counts)
    return rows[first + np.arange(len(level))], level
