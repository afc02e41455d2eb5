"""What bodies weigh, where their centre of mass is, and the convex pieces that they consist of."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Records
from irsim_gym.base.errors import Problem, ScenarioError
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.geometry.polygons import is_convex
from irsim_gym.simulator.levels.body_measures import measure_into
from irsim_gym.simulator.levels.level_table import roomy_outlines, varied_outlines
from irsim_gym.simulator.world.model import NO_DRIVE
from irsim_gym.simulator.world.names import Model, Outline, Struct, chain, kernel, record_type, row_of

COASTS = 5
"""The drive of a body without one, beside those of ``simulator.world.model``."""
SUBSTANCE = record_type("mass inverse grip friction restitution tau given", passive=np.bool_, drive=np.int64)
"""Mass [kg] and its inverse, 0 for what nobody pushes; the greatest force of friction with the ground [N]; coefficients
of friction and restitution; time constant of the drive [s]; the given moment of inertia [kg m2], NaN: from the outline;
whether the body has no drive; how its velocity reads.
"""
DRAWN = "contact needs convex outlines where levels draw them: give the shape is_convex: true, or set unobstructed"


@dataclass(repr=False)
class Matter(Struct):
    """The masses and pieces of all bodies; ``world*`` is one row if all worlds share it.

    Attributes:
        gravity: Gravity [m/s2].
        substance: What they are made of, shape ``(n_bodies,)``.
        coasting: Bodies that move without a drive, shape ``(n,)``.
        pushable: Bodies that can be pushed, likewise.
        varied: Bodies whose outline levels draw, likewise.
        radius: Radius of the least circle around each footprint [m], shape ``(world*, n_bodies)``.
        centre: Centre of mass in the body frame [m], shape ``(world*, n_bodies, 2)``.
        inertia: Moment of inertia about it [kg m2], shape ``(world*, n_bodies)``.
        first_piece: First piece of each body, and the number of all, shape ``(n_bodies + 1,)``.
        first_corner: First corner of each piece, and the number of all, shape ``(n_pieces + 1,)``.
        n_corners: Corners of each piece: 1 of a disc, 2 of a segment, 0 where there is none, ``(world*, n_pieces)``.
        rounding: Radius of each piece that is a disc, else 0 [m], likewise.
        corners: Corners in the body frame [m], shape ``(world*, n_corners, 2)``.
        map_box: Box around the occupied cells: x0, y0, x1, y1 [m]; the world where levels draw the map.
        edge_rank: Order of the horizontal and the vertical edges of cells, shape ``(2, columns + 1, rows + 1)``; no
            column where levels draw the map.
    """

    gravity: float
    substance: Records
    coasting: Ints
    pushable: Ints
    varied: Ints
    radius: Floats
    centre: Floats
    inertia: Floats
    first_piece: Ints
    first_corner: Ints
    n_corners: Ints
    rounding: Floats
    corners: Floats
    map_box: Floats
    edge_rank: Ints


def is_weighed(scenario: Scenario) -> bool:
    """Return whether the masses of bodies matter: they push each other, or coast."""
    return scenario.world.collision_mode == "contact" or any(body.coasts for body in scenario.bodies)


def weigh_anew(scenario: Scenario, model: Model, matter: Matter | None) -> Matter:
    """Return the masses of bodies, made now if there are none."""
    return lay_matter(scenario, model) if matter is None else matter


def lay_matter(scenario: Scenario, model: Model) -> Matter:
    """Return the masses of bodies, and their pieces if they push each other.

    Raises:
        ScenarioError: Levels draw an outline that may not be convex.
    """
    bodies, pushes = scenario.bodies, scenario.world.collision_mode == "contact"
    outlines, varied = roomy_outlines(scenario), varied_outlines(scenario)
    if pushes:
        _refuse_drawn(scenario, outlines, varied)
    pieces = [
        _pieces(outline) if pushes and not body.unobstructed else []
        for body, outline in zip(bodies, outlines, strict=True)
    ]
    flat = [piece for own in pieces for piece in own]
    rows, n_bodies, counts = len(model.radius), len(bodies), [len(corners) for corners, _ in flat]
    n_maps = len(model.map_n_boxes)
    shape = (
        (2, *(np.array(scenario.occupied.shape) + 1)) if scenario.occupied is not None and n_maps == 1 else (2, 0, 0)
    )
    substance = np.array([_substance(scenario, b) for b in range(n_bodies)], SUBSTANCE)
    matter = Matter(
        gravity=scenario.world.gravity,
        substance=substance,
        coasting=np.array([b for b, body in enumerate(bodies) if body.coasts], np.int64),
        pushable=np.flatnonzero((substance["inverse"] > 0.0) & ~model.unobstructed),
        varied=np.flatnonzero(varied & (np.arange(n_bodies) != model.map_frame[0].body)),
        radius=np.zeros((rows, n_bodies)),
        centre=np.zeros((rows, n_bodies, 2)),
        inertia=np.zeros((rows, n_bodies)),
        first_piece=np.cumsum([0, *map(len, pieces)]),
        first_corner=np.cumsum([0, *counts]),
        n_corners=np.tile(np.array(counts, np.int64), (rows, 1)),
        rounding=np.tile(np.array([radius for _, radius in flat], np.float64), (rows, 1)),
        corners=np.tile(np.concatenate([np.zeros((0, 2)), *(corners for corners, _ in flat)]), (rows, 1, 1)),
        map_box=model.bounds.copy(),
        edge_rank=np.zeros(shape, np.int64),
    )
    everyone, worlds = np.arange(n_bodies, dtype=np.int64), np.arange(rows, dtype=np.int64)
    weigh(worlds, everyone, matter, model)
    for b, outline in enumerate(outlines):
        if outline.parts:
            _weigh_union(b, outline, matter)
    if pushes and scenario.occupied is not None and n_maps == 1:
        _rank_edges(scenario.occupied, matter.edge_rank)
        x, y, width, height, _ = model.map_frame.item()
        cells = np.argwhere(scenario.occupied)
        if len(cells):
            ends = cells.min(axis=0), cells.max(axis=0) + 1
            matter.map_box[:] = np.array([x, y] * 2) + np.concatenate(ends) * np.array([width, height] * 2)
    return matter


def _refuse_drawn(scenario: Scenario, outlines: Sequence[Outline], varied: Flags) -> None:
    problems = []
    for body, outline, is_varied in zip(scenario.bodies, outlines, varied, strict=True):
        is_safe = body.shape.is_random and getattr(body.shape, "is_convex", True)
        if is_varied and not body.unobstructed and outline.solid and len(outline.segments) and not is_safe:
            problems.append(Problem(body.line, f"{body.name}.shape", DRAWN))
    if problems:
        raise ScenarioError(scenario.file or scenario.name, problems)


def _substance(scenario: Scenario, b: int) -> tuple[Any, ...]:
    body, world = scenario.bodies[b], scenario.world
    friction, restitution = (
        getattr(world, key) if getattr(body, key) is None else getattr(body, key) for key in ("friction", "restitution")
    )
    # The option ``tau`` of a drive from outside is its own.
    tau = getattr(body.kinematics, "tau", None) if hasattr(body.kinematics, "drive") else None
    inverse = 0.0 if body.static else 1.0 / body.mass
    grip = friction * body.mass * world.gravity if friction > 0.0 else 0.0
    given = np.nan if body.inertia is None else body.inertia
    tau = world.drive_tau if tau is None else tau
    drive = COASTS if body.kinematics is None else getattr(body.kinematics, "drive", NO_DRIVE)
    return body.mass, inverse, grip, friction, restitution, tau, given, drive == COASTS, drive


def _pieces(outline: Outline) -> list[tuple[Floats, float]]:
    """Return corners ``(n, 2)`` [m] and radius [m] of the convex pieces of an outline."""
    found = [(disc[None, :2], float(disc[2])) for disc in outline.discs if not outline.parts]
    loops = outline.parts or ([outline.segments[:, :2]] if outline.solid and len(outline.segments) else [])
    found += [(part, 0.0) for loop in loops for part in _convex_parts(np.ascontiguousarray(loop))]
    return found if outline.solid else [(segment.reshape(2, 2), 0.0) for segment in outline.segments]


def _convex_parts(corners: Floats) -> list[Floats]:
    """Return a polygon, or the triangles that it consists of if it is not convex."""
    import shapely

    if is_convex(corners):
        return [corners]
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(corners)))
    return [shapely.get_coordinates(triangle)[:-1] for triangle in triangles]


def _weigh_union(b: int, outline: Outline, matter: Matter) -> None:
    """Write centre and inertia of a body of several parts: those of their union, if it is one polygon."""
    import shapely

    union: Any = shapely.union_all([shapely.Polygon(part) for part in outline.parts])
    centre, stuff = shapely.get_coordinates(union.centroid)[0], matter.substance[b]
    square = 0.5 * float(shapely.minimum_bounding_radius(union)) ** 2
    if union.geom_type == "Polygon":
        sides = chain(shapely.get_coordinates(union.exterior)[:-1], closed=True)
        square = polar_moment(sides, float(centre[0]), float(centre[1]))
    given = float(stuff["given"])
    matter.centre[:, b], matter.inertia[:, b] = centre, stuff["mass"] * square if np.isnan(given) else given


def _rank_edges(occupied: Flags, rank: Ints) -> None:
    """Write the order of the edges between occupied and free cells: along the rings of the boundary of their union."""
    import shapely

    boxes = [shapely.box(i, j, i + 1, j + 1) for i, j in np.argwhere(occupied)]
    rings = shapely.get_parts(shapely.union_all(boxes).boundary)
    count = 0
    for ring in rings:
        points = shapely.get_coordinates(ring).astype(np.int64)
        for (ax, ay), (bx, by) in pairwise(points):
            rank[int(ax == bx), min(ax, bx), min(ay, by)] = count
            count += 1


def renew_matter(worlds: Ints, matter: Matter, model: Model) -> None:
    """Write what follows from the outlines that levels draw."""
    if len(matter.varied):
        weigh(worlds, matter.varied, matter, model)
        cut_outlines(worlds, matter, model)


def weigh(worlds: Ints, bodies: Ints, matter: Matter, model: Model) -> None:
    """Write radius, centre and inertia of bodies from their outlines."""
    measure_into(worlds, bodies, model, matter.radius, matter.centre)
    weigh_bodies(worlds, bodies, matter, model)


@kernel
def weigh_bodies(worlds: Ints, bodies: Ints, matter: Matter, model: Model) -> None:
    """Write moments of inertia, from the mass and the outline where none is given.

    Reads: matter (centre, radius, substance), model (disc_count, local_segments, segment_count, segment_start, solid).
    Writes: matter (inertia).
    """
    for i in range(min(worlds.shape[0], matter.inertia.shape[0])):
        row = row_of(matter.inertia, worlds[i])
        for b in bodies:
            stuff, start = matter.substance[b], model.segment_start[b]
            n_segments, n_discs = model.segment_count[row, b], model.disc_count[row, b]
            radius = matter.radius[row, b]
            square = 0.5 * radius * radius
            if model.solid[b] and n_discs == 0 and n_segments > 0:
                sides = model.local_segments[row_of(model.local_segments, row)][start : start + n_segments]
                square = polar_moment(sides, matter.centre[row, b, 0], matter.centre[row, b, 1])
            matter.inertia[row, b] = stuff.mass * square if np.isnan(stuff.given) else stuff.given


@kernel
def polar_moment(sides: Floats, x: float, y: float) -> float:
    """Return the polar moment of an area about a point, divided by the area [m2].

    Args:
        sides: Its sides: x0, y0, x1, y1 [m], shape ``(n, 4)``.
        x: The point [m], as ``y``.
        y: See ``x``.
    """
    total, area = 0.0, 0.0
    for k in range(sides.shape[0]):
        ax, ay, bx, by = sides[k, 0] - x, sides[k, 1] - y, sides[k, 2] - x, sides[k, 3] - y
        cross = ax * by - bx * ay
        total += cross * (ax * ax + ax * bx + bx * bx + ay * ay + ay * by + by * by)
        area += cross
    return total / (6.0 * area)


@kernel
def inverse_inertia(matter: Matter, w: int, b: int) -> float:
    """Return the inverse of a body's moment of inertia [1/(kg m2)]; 0 for what nobody turns.

    Reads: matter (inertia, substance).
    """
    inertia = matter.inertia[row_of(matter.inertia, w), b]
    return 1.0 / inertia if matter.substance[b].inverse > 0.0 and inertia < np.inf else 0.0


@kernel
def gyration(matter: Matter, w: int, b: int) -> float:
    """Return a body's radius of gyration [m]; 0 if its mass or its moment of inertia is infinite.

    Reads: matter (inertia, substance).
    """
    mass, inertia = matter.substance[b].mass, matter.inertia[row_of(matter.inertia, w), b]
    return np.sqrt(inertia / mass) if mass < np.inf and inertia < np.inf else 0.0


@kernel
def cut_outlines(worlds: Ints, matter: Matter, model: Model) -> None:
    """Write the pieces of the bodies whose outline levels draw.

    Reads: matter (first_corner, first_piece, varied), model (disc_count, disc_start, local_discs, local_segments,
        segment_count, segment_start, solid).
    Writes: matter (corners, n_corners, rounding).
    """
    for w in worlds:
        for b in matter.varied:
            first, start = matter.first_piece[b], model.segment_start[b]
            n_segments, n_discs = model.segment_count[w, b], model.disc_count[w, b]
            for k in range(first, matter.first_piece[b + 1]):
                matter.n_corners[w, k] = 0
            for d in range(min(n_discs, matter.first_piece[b + 1] - first)):
                disc = model.local_discs[w, model.disc_start[b] + d]
                corner = matter.corners[w, matter.first_corner[first + d]]
                corner[0], corner[1] = disc[0], disc[1]
                matter.n_corners[w, first + d], matter.rounding[w, first + d] = 1, disc[2]
            for s in range(n_segments if matter.first_piece[b + 1] > first else 0):
                side = model.local_segments[w, start + s]
                if model.solid[b]:
                    corner = matter.corners[w, matter.first_corner[first] + s]
                    corner[0], corner[1] = side[0], side[1]
                    matter.n_corners[w, first] = n_segments
                else:
                    for end in range(2):
                        corner = matter.corners[w, matter.first_corner[first + s] + end]
                        corner[0], corner[1] = side[2 * end], side[2 * end + 1]
                    matter.n_corners[w, first + s] = 2
