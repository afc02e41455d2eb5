"""Many bodies that push each other for long: nothing overlaps, gets out, becomes NaN, or hangs.

But for what a robot presses together, such as several bodies into a corner: 32 sweeps do not always part them, and they
overlap for as long as the robot drives on. ir-sim does the same, as ``tests/parity`` compares.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.simulator.world.outline import outline_rows

N_WORLDS = 20
TOLERANCE = 2e-5
"""Overlaps of up to 1e-5 m are no contact; another 1e-5 m may be left where bodies are squeezed from several sides."""


def crowd(size: float, robots: int, bodies: int) -> Any:
    """Return worlds with walls, robots of two kinds that wander, and discs, boxes and triangles of several masses."""
    room = {"range_low": [0.5, 0.5, -3.1], "range_high": [size - 0.5, size - 0.5, 3.1]}
    place, wander = {"name": "random", "min_distance": 0, **room}, {"name": "dash", "wander": True, **room}
    driven = {"number": robots, "distribution": place, "behavior": wander, "mass": 4}
    loose = {"number": bodies, "distribution": place, "mass": [0.5, 1, 2]}
    world = {"width": size + 4, "height": size + 4, "offset": [-2, -2], "collision_mode": "contact"}
    wall = {"name": "rectangle", "length": size + 4, "width": 2}
    half, far, upright = size / 2, size + 1, float(np.pi / 2)
    sides = [[half, -1, 0], [half, far, 0], [-1, half, upright], [far, half, upright]]
    triangle = {"name": "polygon", "vertices": [[-0.3, -0.2], [0.3, -0.2], [0, 0.35]]}
    data = {
        "world": world,
        "robot": [
            {**driven, "kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}},
            {**driven, "kinematics": {"name": "omni"}, "shape": {"name": "rectangle", "length": 0.4, "width": 0.3}},
        ],
        "obstacle": [
            {"number": 4, "shape": wall, "state": sides},
            {**loose, "shape": {"name": "circle", "radius": 0.25}},
            {**loose, "shape": {"name": "rectangle", "length": 0.5, "width": 0.35}},
            {**loose, "shape": triangle, "friction": 0.05, "restitution": 0.8},
        ],
    }
    simulation = ig.compile(ig.load_scenario(data), N_WORLDS)
    simulation.reset(seed=0)
    return simulation


def outlines(simulation: Any, w: int) -> list[Any]:
    shapes = []
    for b in range(simulation.model.present.shape[1]):
        segments, discs = outline_rows(simulation.model, simulation.state, w, b)
        is_disc = len(discs) > 0
        shapes.append(
            shapely.Point(discs[0, :2]).buffer(discs[0, 2], 64) if is_disc else shapely.Polygon(segments[:, :2])
        )
    return shapes


def overlaps(shapes: list[Any]) -> list[tuple[int, int]]:
    """Return the pairs of bodies that overlap: what they share is wider than the tolerance."""
    found = []
    for one, other in zip(*shapely.STRtree(shapes).query(shapes, "intersects"), strict=True):
        shared = shapes[one].intersection(shapes[other])
        if one < other and 2.0 * shared.area > TOLERANCE * shared.length:
            found.append((int(one), int(other)))
    return found


def pressed(told: Any, robots: list[int], walls: list[int]) -> set[int]:
    """Return the robots, and all that they touch, directly or through others."""
    reached, size = set(robots), 0
    while size < len(reached):
        size = len(reached)
        for a, b in zip(told["a"].tolist(), told["b"].tolist(), strict=True):
            if (a in reached and a not in walls) or (b in reached and b not in walls):
                reached |= {a, b}
    return reached


def play(simulation: Any, steps: int, looks: int, size: float) -> None:
    """Step, and look at one of the worlds now and then."""
    push, pose, touches, squeezed = simulation.parts.pushing, simulation.state.pose, 0, 0
    walls = np.flatnonzero(simulation.model.stands).tolist()
    robots = np.flatnonzero(simulation.model.driven).tolist()
    for step in range(steps):
        simulation.step()
        touches += int(push.felt["touches"].sum())
        if step % (steps // looks):
            continue
        assert np.isfinite(pose).all()
        assert np.isfinite(simulation.state.velocity).all()
        w = step // (steps // looks) % N_WORLDS
        pairs = [pair for pair in overlaps(outlines(simulation, w)) if not set(pair) <= set(walls)]
        squeezed += bool(pairs)
        assert {b for pair in pairs for b in pair} <= pressed(push.reports[w, : push.n_reports[w]], robots, walls)
        free = np.delete(pose[w, :, :2], walls, axis=0)
        assert ((free > 0) & (free < size)).all(), (step, w)
    assert squeezed <= 0.02 * looks
    assert touches > 0.1 * steps * pose[:, :, 0].size


def test_a_hundred_thousand_steps_of_a_crowd() -> None:
    play(crowd(3.5, 1, 2), 100_000 // N_WORLDS, 500, 3.5)


@pytest.mark.slow
def test_a_million_steps_of_a_larger_crowd() -> None:
    play(crowd(6.0, 2, 5), 1_000_000 // N_WORLDS, 5000, 6.0)


def test_pairs_are_all_whose_boxes_meet() -> None:
    """In worlds of some hundred bodies, against all pairs; two bodies that nobody pushes are none."""
    simulation = crowd(9.0, 5, 30)
    push, names = simulation.parts.pushing, simulation.parts.names
    assert len(names) > 100
    walls = set(np.flatnonzero(simulation.model.stands).tolist())
    for _ in range(30):
        simulation.step()
        boxes, margin = push.boxes[0], push.margin[0]
        low, high = boxes[:, None, :2] - margin, boxes[:, None, 2:] + margin
        meets = ((boxes[None, :, :2] <= high) & (boxes[None, :, 2:] >= low)).all(axis=2)
        expected = [(i, j) for i, j in np.argwhere(np.triu(meets, 1)).tolist() if not {i, j} <= walls]
        pairs = push.pairs[0, : push.counts[0, 0]]
        assert list(zip(pairs["a"].tolist(), pairs["b"].tolist(), strict=True)) == expected
        assert len(expected) > 20
