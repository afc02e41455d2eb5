"""What levels draw of bodies, who sees whom and who walks with whom, worked out by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig

OMNI: dict[str, Any] = {"kinematics": {"name": "omni"}, "behavior": {"name": "dash"}, "goal": [9, 9]}
TWO_TO_64 = 2**64
STEP = 0x9E3779B97F4A7C15


def compiled(n_worlds: int = 1, **entries: Any) -> ig.Simulation:
    simulation = ig.compile(ig.load_scenario({"world": {"width": 20, "height": 20}, **entries}), n_worlds)
    simulation.reset(seed=0)
    return simulation


def scrambled(bits: int) -> int:
    """Return the finaliser of SplitMix64, with whole numbers."""
    bits = (bits ^ bits >> 30) * 0xBF58476D1CE4E5B9 % TWO_TO_64
    bits = (bits ^ bits >> 27) * 0x94D049BB133111EB % TWO_TO_64
    return bits ^ bits >> 31


def shares(stream: int, count: int) -> list[float]:
    """Return the next numbers of a stream, from 0 to 1."""
    return [(scrambled((stream + STEP * n) % TWO_TO_64) >> 11) / 2**53 for n in range(1, count + 1)]


def test_traits_come_from_a_stream_of_their_own_that_changes_nothing_else() -> None:
    """Of both bodies the speed is drawn, of the second whether it avoids others, too: three numbers in this order."""
    place = {"distribution": {"name": "random"}}
    drawn = {"speed_range": [0.5, 1.5], "vel_min": [-1, -0.2], "vel_max": [2, 2]}
    bodies = [{**OMNI, **place}, {**OMNI, **place}]
    plain = compiled(3, robot=bodies)
    varied = compiled(3, robot=[{**bodies[0], **drawn}, {**bodies[1], **drawn, "unyielding": 0.5}])
    np.testing.assert_array_equal(varied.state.pose, plain.state.pose)
    np.testing.assert_array_equal(varied.state.random, plain.state.random)
    model = varied.model
    for w in range(3):
        first, second, heed = shares(scrambled(int(model.level_random[w])), 3)
        speeds = [0.5 + first, 0.5 + second]
        assert model.drawn_speed[w].tolist() == pytest.approx(speeds)
        assert model.velocity_max[w, :, :2] == pytest.approx(np.array([speeds, speeds]).T)
        assert model.velocity_min[w, :, 0] == pytest.approx([-min(speed, 1.0) for speed in speeds])
        assert model.velocity_min[w, :, 1] == pytest.approx([-0.2, -0.2])
        assert model.heedless[w].tolist() == [False, heed < 0.5]


def test_who_is_seen_by_whom() -> None:
    """Row 0 of the table is everybody, then a row for each other value of ``seen_by`` in the order of bodies."""
    robots = [{**OMNI, "state": [2, 2, 0], "name": "ann"}, {**OMNI, "state": [4, 2, 0], "seen_by": ["ann", "walkers"]}]
    obstacles = [
        {**OMNI, "number": 2, "distribution": {"name": "random"}, "group_name": "walkers", "seen_by": []},
        {"state": [8, 8, 0], "seen_by": "robot"},
    ]
    model = compiled(robot=robots, obstacle=obstacles).model
    assert model.seen_row.tolist() == [0, 1, 2, 2, 3]
    assert model.watchers.tolist() == [
        [True] * 5,
        [True, False, True, True, False],
        [False] * 5,
        [True, True, False, False, False],
    ]


def test_who_walks_with_whom() -> None:
    """Five in parties of three: of discs of 0.25 m, 0.3 m apart, the second is 0.8 m to the left of the first."""
    shape = {"name": "circle", "radius": 0.25}
    crowd = {**OMNI, "shape": shape, "number": 5, "party": 3, "distribution": {"name": "random"}}
    model = compiled(robot={**OMNI, "state": [1, 1, 0]}, obstacle=crowd).model
    assert model.leader.tolist() == [0, 1, 1, 1, 4, 4]
    assert model.abreast.tolist() == pytest.approx([0, 0, 0.8, -0.8, 0, 0.8])
