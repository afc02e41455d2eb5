"""ORCA's choices against pyrvo, and what they promise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from orca_scenes import draw_scene, our_velocities, peer_velocities

BOX = [(4.0, 4.0), (6.0, 4.2), (6.5, 6.0), (4.1, 6.3)]
BENT = [(1.0, 1.0), (3.0, 2.0), (2.5, 4.0)]
STRAIGHT = [(8.0, 1.0), (8.0, 9.0)]


def compare(rng: np.random.Generator, n_scenes: int, spacing: float, **given: Any) -> tuple[int, int]:
    """Return how many choices differ by more than pyrvo's float32 explains, and how many there are."""
    apart, total = 0, 0
    for _ in range(n_scenes):
        scene = draw_scene(rng, int(rng.integers(2, 20)), spacing, **given)
        gap = np.abs(our_velocities(scene) - peer_velocities(scene)).max(axis=1)
        apart, total = apart + int((gap > 1e-4).sum()), total + len(gap)
    return apart, total


@pytest.mark.parametrize(
    ("spacing", "given"),
    [
        (0.7, {}),
        (0.45, {}),  # discs with their margins overlap
        (0.7, {"options": {"maxNeighbors": 3, "neighborDist": 4.0}, "speed": 0.6}),
        (0.7, {"options": {"timeHorizon": 2.0}, "step_time": 0.25}),
    ],
)
def test_choices_among_discs_are_those_of_pyrvo(spacing: float, given: dict[str, Any]) -> None:
    # Where no velocity is permitted and half-planes are nearly parallel, float32 may lead elsewhere.
    apart, total = compare(np.random.default_rng(5), 16, spacing, **given)
    assert apart <= 1
    assert total > 100


@pytest.mark.parametrize(
    "walls", [{"polygons": [BOX]}, {"lines": [BENT]}, {"lines": [STRAIGHT]}, {"polygons": [BOX], "lines": [STRAIGHT]}]
)
@pytest.mark.parametrize("horizon", [10.0, 1.0])
def test_choices_beside_walls_are_those_of_pyrvo(walls: dict[str, Any], horizon: float) -> None:
    apart, total = compare(np.random.default_rng(6), 12, 0.7, options={"timeHorizonObst": horizon}, **walls)
    assert apart <= 1
    assert total > 80
