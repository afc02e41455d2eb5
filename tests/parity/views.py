"""Fields of view and the fog of what was explored, in both simulators."""

from __future__ import annotations

from typing import Any

import numpy as np

EDGE = 1e-9
LOST_FOG = 0.001
"""Share of the explored cells that only ir-sim may have: a sample on the edge of a cell."""
MORE_FOG = 0.02
"""Share that only we may have: beams end just within the wall that they hit (decision ``fog_ends``)."""


def compare_views(pair: Any) -> None:
    """Compare who is in whose field of view; wide bodies ahead are missed by ir-sim (decision ``field_of_view``)."""
    objects = pair.reference.objects
    for b, theirs in enumerate(objects):
        spec = pair.sim.scenario.bodies[b] if b < len(pair.sim.scenario.bodies) else None
        if spec is None or spec.fov is None or theirs.shape == "map":
            continue
        assert (spec.fov, spec.fov_radius) == (theirs.fov, theirs.fov_radius)
        found = pair.sim.detected(b)[0]
        for q, other in enumerate(objects):
            if q != b and other.shape != "map":
                compare_view(pair, theirs, other, bool(found[q]))


def compare_view(pair: Any, one: Any, other: Any, found: bool) -> None:
    """Compare whether one sees another."""
    if found == one.fov_detect_object(other):
        return
    dx, dy = (other.state[:2, 0] - one.state[:2, 0]).tolist()
    distance = float(np.hypot(dx, dy))
    bearing = abs((np.arctan2(dy, dx) - one.state[2, 0] + np.pi) % (2 * np.pi) - np.pi)
    half = np.arcsin(min(other.radius / distance, 1.0)) if distance else np.pi / 2
    if found and half - bearing > one.fov / 2:
        pair.report.decisions.add("field_of_view")
        return
    margin = (
        distance
        if distance <= EDGE
        else min(abs(abs(bearing - half) - one.fov / 2), abs(distance - other.radius - one.fov_radius))
    )
    assert margin <= EDGE, (one.name, other.name, found, bearing, half, distance)


def compare_fog(pair: Any) -> None:
    """Compare the explored cells after the last step."""
    theirs = pair.reference.env._world.fog_map
    found = pair.sim.explored
    assert (theirs is None) == (found is None)
    if theirs is None:
        return
    assert found[0].shape == theirs.explored.shape
    assert theirs.explored.sum() > 100
    ours, whole = found[0], theirs.explored
    beside = np.pad(whole, 1)
    beside = beside[:-2, 1:-1] | beside[2:, 1:-1] | beside[1:-1, :-2] | beside[1:-1, 2:] | whole
    assert np.sum(whole & ~ours) <= LOST_FOG * whole.sum()
    assert not np.any(ours & ~beside)
    assert np.sum(ours & ~whole) <= MORE_FOG * whole.sum()
    pair.report.decisions.add("fog_ends")
