"""Gaps in a scan: lost beams, or free space between two bodies."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.simulator.tracks.clusters import join_beams, mend

LIMITS, NOTHING, SPACING = np.array([0.0, 6.0], np.float32), 6.0, np.radians(2.0)


def mended_scan(scan: list[float], noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a scan as it is mended, and which beams are joined to the one before."""
    ranges, joined = np.array([NOTHING, *scan, NOTHING], np.float32), np.zeros((3, len(scan) + 2), np.float32)
    join_beams(ranges, LIMITS, SPACING, noise, False, joined)
    mend(ranges, SPACING, noise, joined)
    return ranges[1:-1], joined[0, 1:-1]


@pytest.mark.parametrize(
    ("scan", "mended", "joins"),
    [
        ([2.1, 2.0, NOTHING, 1.98, 2.05], [2.1, 2.0, -1.98, 1.98, 2.05], True),  # the front of a disc
        ([2.1, 2.0, NOTHING, NOTHING, 2.0, 2.1], [2.1, 2.0, -2.0, -2.0, 2.0, 2.1], True),
        ([2.0, 2.1, NOTHING, 2.1, 2.0], [2.0, 2.1, NOTHING, 2.1, 2.0], False),  # two edges that recede
        ([2.0, 2.1, NOTHING, 5.0, 5.1], [2.0, 2.1, -2.1, 5.0, 5.1], False),  # an edge, and a wall behind it
        ([2.0, *3 * [NOTHING], 2.0], [2.0, *3 * [NOTHING], 2.0], False),  # too many to be lost
    ],
)
def test_up_to_two_beams_between_hits_are_lost(scan: list[float], mended: list[float], joins: bool) -> None:
    ranges, same = mended_scan(scan)
    assert ranges == pytest.approx(mended)
    assert same[scan.index(NOTHING) : -1].all() == joins


def test_noise_makes_no_two_bodies_of_one() -> None:
    # Without noise, 2 cm up and 2 cm down are two edges.
    for noise, reading in ((0.0, NOTHING), (0.02, -2.02)):
        assert mended_scan([2.0, 2.02, NOTHING, 2.02, 2.0], noise)[0][2] == pytest.approx(reading)
