"""The random outline generator of polygons and linestrings."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from irsim_gym.base.options import kind, option, unordered_ranges
from irsim_gym.simulator.world.names import Floats, Ints, Model, State, Words, chain, integer, kernel, normal, uniform

STEP_TRIES = 32
"""Maximum number of draws of the angles between vertices."""
LEAST_DISTANCE = 0.01
FARTHEST_SHARE = 2.0
"""Least and greatest distance of a vertex from the centre, in mean radii."""
MOST_VERTICES = 1000
"""Maximum number of vertices."""


@kind
class VertexShape:
    """What polygons and linestrings have in common: vertices that are given, or drawn as IR-SIM draws them."""

    vertices: tuple[tuple[float, float], ...] | None = option(
        None, min_length=2, unit="m", meaning="Points in the body frame; needed unless random_shape is true."
    )
    random_shape: bool = option(False, meaning="Draw the outline at each reset.")
    is_convex: bool = option(False, meaning="Make random outlines convex.")
    wheelbase: float | None = option(None, ge=0.0, unit="m", meaning="Axle distance; does not move the outline.")
    number: int = option(1, meaning="Outlines per body: always 1; use the entry's number for several bodies.")
    center_range: tuple[float, float, float, float] = option(
        (0.0, 0.0, 0.0, 0.0), unit="m", meaning="Bounds of a random outline's centre: x, y, x, y."
    )
    avg_radius_range: tuple[float, float] = option((0.1, 1.0), unit="m", meaning="Bounds of vertices' mean distance.")
    irregularity_range: tuple[float, float] = option((0.0, 1.0), meaning="Bounds of the angles' irregularity, 0 to 1.")
    spikeyness_range: tuple[float, float] = option((0.0, 1.0), meaning="Bounds of the distances' deviation, 0 to 1.")
    num_vertices_range: tuple[int, int] = option((4, 10), meaning="Bounds of the number of vertices, upper excluded.")

    @property
    def is_random(self) -> bool:
        """True if the outline differs between levels."""
        return self.random_shape

    def given(self) -> Floats | None:
        """Return the given vertices [m], shape ``(n, 2)``; None for a random outline."""
        return None if self.random_shape or self.vertices is None else np.array(self.vertices, np.float64)

    def largest(self) -> Floats:
        """Return the sides of a regular polygon: as many, and as far away, as those of a random outline can be."""
        # The upper bound of the number is excluded.
        angles = 2.0 * np.pi * np.arange(self.num_vertices_range[1] - 1) / (self.num_vertices_range[1] - 1)
        x_min, y_min, x_max, y_max = self.center_range
        off_center = np.hypot(max(abs(x_min), abs(x_max)), max(abs(y_min), abs(y_max)))
        farthest = off_center + FARTHEST_SHARE * self.avg_radius_range[1]
        return chain(farthest * np.stack([np.cos(angles), np.sin(angles)], axis=1), closed=True)


def outline_problems(options: VertexShape) -> Iterator[tuple[str, str]]:
    """Yield key and message of what cannot be in the options of a polygon or linestring."""
    if options.vertices is None and not options.random_shape:
        yield "vertices", "is required unless random_shape is true"
    if options.number != 1:
        yield "number", "a body has one outline: write number beside shape, not in it"
    yield from unordered_ranges(options, "avg_radius_range", least=1e-3)
    yield from unordered_ranges(options, "irregularity_range", "spikeyness_range", least=0.0)
    for key in ("irregularity_range", "spikeyness_range"):
        if getattr(options, key)[1] > 1.0:
            yield key, f"must lie between 0 and 1, got up to {getattr(options, key)[1]:g}"
    low, high = options.num_vertices_range
    if not 3 <= low < high <= MOST_VERTICES:
        message = f"must be [low, high] with 3 <= low < high <= {MOST_VERTICES} (high is excluded), got [{low}, {high}]"
        yield "num_vertices_range", message
    x_min, y_min, x_max, y_max = options.center_range
    if x_min > x_max or y_min > y_max:
        yield "center_range", "must be [x_min, y_min, x_max, y_max] with min <= max"


@kernel
def draw_outlines(worlds: Ints, members: Ints, params: Any, closed: bool, model: Model, state: State) -> None:
    """Write a random outline for each member: its segments, their count and its reach.

    The generator is IR-SIM's: a centre, a mean radius R, irregularity, spikeyness and a number of vertices are
    drawn; angle steps differ by the irregularity, distances are normal about R with deviation spikeyness * R,
    clipped to [0.01 R, 2 R] (IR-SIM: [0, 2 R], where two vertices in the centre would pinch the outline).

    Reads: model (local_segments, segment_start), state (random).
    Writes: model (local_segments, reach, segment_count), state (random).
    """
    for w in worlds:
        for k in range(members.shape[0]):
            b = members[k]
            # Vertices come into the first two columns; the last two are scratch until the ends of the sides are known.
            rows = model.local_segments[w, model.segment_start[b] :]
            n = draw_vertices(state.random, w, params[k], rows)
            if params[k].is_convex:
                n = hull(rows, n)
            for v in range(n):
                rows[v, 2], rows[v, 3] = rows[(v + 1) % n, 0], rows[(v + 1) % n, 1]
            # An open chain leaves out the side from the last vertex to the first.
            model.segment_count[w, b] = n if closed else n - 1
            largest = 0.0
            for v in range(n):
                largest = max(largest, rows[v, 0] * rows[v, 0] + rows[v, 1] * rows[v, 1])
            model.reach[w, b] = np.sqrt(largest)


@kernel
def draw_vertices(random: Words, w: int, bounds: Any, rows: Floats) -> int:
    """Write vertices into the first two columns of ``rows``, counter-clockwise; return their number."""
    x = uniform(random, w, bounds.center_range[0], bounds.center_range[2])
    y = uniform(random, w, bounds.center_range[1], bounds.center_range[3])
    radius = uniform(random, w, bounds.avg_radius_range[0], bounds.avg_radius_range[1])
    irregularity = uniform(random, w, bounds.irregularity_range[0], bounds.irregularity_range[1])
    spikeyness = uniform(random, w, bounds.spikeyness_range[0], bounds.spikeyness_range[1])
    n = integer(random, w, bounds.num_vertices_range[0], bounds.num_vertices_range[1])
    draw_angle_steps(random, w, n, irregularity, rows)
    angle = uniform(random, w, 0.0, 2.0 * np.pi)
    for v in range(n):
        distance = normal(random, w, radius, spikeyness * radius)
        distance = min(max(distance, LEAST_DISTANCE * radius), FARTHEST_SHARE * radius)
        rows[v, 0], rows[v, 1] = x + distance * np.cos(angle), y + distance * np.sin(angle)
        # The third column holds the steps that draw_angle_steps wrote.
        angle += rows[v, 2]
    return n


@kernel
def draw_angle_steps(random: Words, w: int, n: int, irregularity: float, rows: Floats) -> None:
    """Write n angles that sum to 2 pi into the third column of ``rows``.

    A step of more than pi would let the outline cross itself; such draws are repeated, in the end evenly spaced.
    """
    even = 2.0 * np.pi / n
    for attempt in range(STEP_TRIES):
        # The last attempt is an even one, so that it succeeds.
        spread = irregularity * even if attempt < STEP_TRIES - 1 else 0.0
        total = 0.0
        for v in range(n):
            rows[v, 2] = uniform(random, w, even - spread, even + spread)
            total += rows[v, 2]
        largest = 0.0
        for v in range(n):
            # Scaled so that the steps close the turn.
            rows[v, 2] *= 2.0 * np.pi / total
            largest = max(largest, rows[v, 2])
        if largest <= np.pi:
            return


@kernel
def hull(rows: Floats, n: int) -> int:
    """Replace the n vertices in the first two columns by their convex hull; return its size (Jarvis 1973)."""
    first = 0
    for v in range(n):
        # Copies, so that the first columns are free for the result.
        rows[v, 2], rows[v, 3] = rows[v, 0], rows[v, 1]
        # The leftmost vertex, of several the lowest, is on the hull.
        if rows[v, 2] < rows[first, 2] or (rows[v, 2] == rows[first, 2] and rows[v, 3] < rows[first, 3]):
            first = v
    current, size = first, 0
    while size < n:
        rows[size, 0], rows[size, 1] = rows[current, 2], rows[current, 3]
        size += 1
        following = 0 if current != 0 else 1
        for v in range(n):
            dx, dy = rows[following, 2] - rows[current, 2], rows[following, 3] - rows[current, 3]
            ex, ey = rows[v, 2] - rows[current, 2], rows[v, 3] - rows[current, 3]
            turn = dx * ey - dy * ex
            # To the right of all others seen so far; of vertices in a line, the farthest.
            if turn < 0.0 or (turn == 0.0 and ex * ex + ey * ey > dx * dx + dy * dy):
                following = v
        current = following
        if current == first:
            break
    return size
