"""Levels from a file (``levels``), which are copied into the worlds instead of being drawn."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.rng import level_stream, stream_base
from irsim_gym.scenario.specs.level_set import LevelSet
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.cell_maps.world_maps import lay_cells
from irsim_gym.simulator.world.names import CellMaps, Flags, Floats, Ints, Model, Outline, State, Struct, Words, kernel


@dataclass(repr=False)
class LevelTable(Struct):
    """The levels of a file, for the bodies of a simulation.

    Attributes:
        bodies: Body of each column, shape ``(n,)``.
        shaped: Whether its outline is the file's, shape ``(n,)``.
        start: Poses [m, m, rad], shape ``(n_levels, n, 3)``.
        goal: Goals in order [m, m, rad], shape ``(n_levels, n, n_goals, 3)``: the file's, else the scenario's own; NaN
            for none.
        present: Bodies that the level has, shape ``(n_levels, n)``.
        segments: Sides of outlines [m], shape ``(n_segments, 4)``.
        segment_rows: First row of each body's segments and the row after the last, shape ``(n_levels, n, 2)``.
        discs: Discs of outlines [m], shape ``(n_discs, 3)``.
        disc_rows: The same for discs.
        cells: Occupied cells of the map, shape ``(n_levels, columns, rows)``; no level where the file gives none.
        line: Scratch for ``lay_cells``, shape ``(n_slots, columns)``.
        random: Random streams at the start, shape ``(n_levels,)``.
        no_ranges: What is drawn of numbers of bodies: nothing, shape ``(0, 3)``.
    """

    bodies: Ints
    shaped: Flags
    start: Floats
    goal: Floats
    present: Flags
    segments: Floats
    segment_rows: Ints
    discs: Floats
    disc_rows: Ints
    cells: Flags
    line: Floats
    random: Words
    no_ranges: Ints


def lay_levels(scenario: Scenario, model: Model, n_slots: int) -> LevelTable | None:
    """Return the levels of a scenario's file; None where levels are drawn. Bodies that are gone are left out.

    Args:
        scenario: The scenario.
        model: Its constants, with the goals that the scenario itself gives.
        n_slots: Number of slots.
    """
    levels = scenario.levels
    is_mapped = levels is not None and levels.cells is not None and scenario.occupied is not None
    if levels is None:
        return None
    number = {body.name: b for b, body in enumerate(scenario.bodies)}
    columns = np.array([k for k, name in enumerate(levels.bodies) if name in number], np.int64)
    bodies = np.array([number[levels.bodies[k]] for k in columns], np.int64)
    # Each level writes the goals of all bodies, so that those of the level before never stay.
    waypoints = model.waypoints[0, bodies, : levels.goal.shape[2]]
    goals = levels.goal[:, columns, : waypoints.shape[1]]
    return LevelTable(
        bodies=bodies,
        shaped=levels.shaped[columns],
        start=np.ascontiguousarray(levels.start[:, columns]),
        goal=np.where(np.isnan(goals[..., :1]), waypoints, goals),
        present=np.ascontiguousarray(levels.present[:, columns]),
        segments=levels.segments,
        segment_rows=_rows(levels.segment_start, columns),
        discs=levels.discs,
        disc_rows=_rows(levels.disc_start, columns),
        cells=levels.cells if is_mapped and levels.cells is not None else np.zeros((0, 1, 1), np.bool_),
        line=np.zeros((n_slots, levels.cells.shape[1] if levels.cells is not None else 1)),
        random=_streams(levels, scenario.name),
        no_ranges=np.zeros((0, 3), np.int64),
    )


def _rows(starts: Ints, columns: Ints) -> Ints:
    return np.ascontiguousarray(np.stack([starts[:, columns], starts[:, columns + 1]], axis=2))


def _streams(levels: LevelSet, name: str) -> Words:
    """Return the random streams of all levels: the file's, else those that the scenario's own levels begin with."""
    if levels.random is not None:
        return levels.random
    streams = np.zeros(levels.count, np.uint64)
    for split, (first, count) in levels.splits.items():
        base = stream_base(name, split)
        streams[first : first + count] = [level_stream(base, level) for level in range(count)]
    return streams


def varied_outlines(scenario: Scenario) -> Flags:
    """Return which bodies have another outline, or map, in each level, shape ``(n_bodies,)``."""
    levels = scenario.levels
    shaped = set() if levels is None else {levels.bodies[k] for k in np.flatnonzero(levels.shaped)}
    resized = any(item.acts_on == "outline" for item in scenario.disturbances)
    varied = np.array([body.shape.is_random or body.name in shaped for body in scenario.bodies], np.bool_)
    for b in scenario.robots:
        varied[b] |= resized or any(item.acts_on == "outline" for item in scenario.bodies[b].disturbances)
    if scenario.occupied is not None and levels is not None:
        varied[-1] = levels.cells is not None
    return varied


def given_bodies(scenario: Scenario) -> Flags:
    """Return which bodies a file of levels places, shape ``(n_bodies,)``."""
    names = () if scenario.levels is None else scenario.levels.bodies
    return np.array([body.name in names for body in scenario.bodies], np.bool_)


def roomy_outlines(scenario: Scenario) -> list[Outline]:
    """Return the outline of each body; if a file shapes it, with enough rows for all levels."""
    outlines = [body.shape.outline() for body in scenario.bodies]
    levels = scenario.levels
    if levels is None:
        return outlines
    number = {body.name: b for b, body in enumerate(scenario.bodies)}
    for k in np.flatnonzero(levels.shaped):
        b = number.get(levels.bodies[k])
        if b is None:
            continue
        segments, discs = (np.diff(rows, axis=1)[:, k] for rows in (levels.segment_start, levels.disc_start))
        outline = outlines[b]
        if segments.max() > len(outline.segments) or discs.max() > len(outline.discs):
            # Room for the outline of any level, which is written over these rows.
            longest = levels.outline(int(segments.argmax()), int(k))[0], levels.outline(int(discs.argmax()), int(k))[1]
            outlines[b] = Outline(*longest, solid=outline.solid)
    return outlines


@kernel
def copy_maps(worlds: Ints, slot: int, levels: LevelTable, cells: CellMaps, model: Model) -> None:
    """Write the map of each world's level.

    Reads: levels (cells, line), model (level_stream).
    Writes: levels (line), cells.
    """
    for w in worlds:
        lay_cells(cells, w, levels.cells[np.int64(model.level_stream[w])], levels.line[slot])


@kernel
def copy_levels(worlds: Ints, levels: LevelTable, model: Model, state: State) -> None:
    """Write what the file says of each world's level, whose row is in ``model.level_stream``.

    Reads: levels (bodies, disc_rows, discs, goal, present, random, segment_rows, segments, shaped, start), model
        (disc_start, level_stream, local_discs, local_segments, segment_start).
    Writes: model (disc_count, local_discs, local_segments, present, reach, segment_count, waypoints), state (placed,
        pose, random).
    """
    for w in worlds:
        row = np.int64(model.level_stream[w])
        state.random[w] = levels.random[row]
        for k in range(levels.bodies.shape[0]):
            b = levels.bodies[k]
            model.present[w, b], state.placed[w, b] = levels.present[row, k], levels.present[row, k]
            for axis in range(3):
                state.pose[w, b, axis] = levels.start[row, k, axis]
            for i in range(levels.goal.shape[2]):
                for axis in range(3):
                    model.waypoints[w, b, i, axis] = levels.goal[row, k, i, axis]
            if levels.shaped[k]:
                copy_outline(w, b, levels.segment_rows[row, k], levels.disc_rows[row, k], levels, model)


@kernel
def copy_outline(w: int, b: int, segment_rows: Ints, disc_rows: Ints, levels: LevelTable, model: Model) -> None:
    """Write the outline of body b of world w, and its reach.

    Reads: levels (discs, segments), model (disc_start, local_discs, local_segments, segment_start).
    Writes: model (disc_count, local_discs, local_segments, reach, segment_count).
    """
    farthest2, reach = 0.0, 0.0
    model.segment_count[w, b] = segment_rows[1] - segment_rows[0]
    for i in range(segment_rows[0], segment_rows[1]):
        side = model.local_segments[w, model.segment_start[b] + i - segment_rows[0]]
        for axis in range(4):
            side[axis] = levels.segments[i, axis]
        farthest2 = max(farthest2, side[0] * side[0] + side[1] * side[1], side[2] * side[2] + side[3] * side[3])
    model.disc_count[w, b] = disc_rows[1] - disc_rows[0]
    for i in range(disc_rows[0], disc_rows[1]):
        disc = model.local_discs[w, model.disc_start[b] + i - disc_rows[0]]
        for axis in range(3):
            disc[axis] = levels.discs[i, axis]
        reach = max(reach, np.sqrt(disc[0] * disc[0] + disc[1] * disc[1]) + disc[2])
    model.reach[w, b] = max(np.sqrt(farthest2), reach)
