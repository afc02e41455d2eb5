"""Who is in a field of view: hand-worked sectors (tests/bodies/sensors compares with IR-SIM)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.errors import UnknownNameError

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}


def disc(x: float, y: float, radius: float, **more: Any) -> dict[str, Any]:
    return {"shape": {"name": "circle", "radius": radius}, "state": [x, y, 0], **more}


def detected(robot: dict[str, Any], obstacles: list[dict[str, Any]]) -> list[bool]:
    data = {"robot": {**DIFF, "state": [2, 2, 0], **robot}, "obstacle": obstacles}
    sim = ig.compile(ig.load_scenario(data, warn=False), 2)
    sim.reset()
    found = sim.detected(0)
    assert found.shape == (2, 1 + len(obstacles))
    assert (found[0] == found[1]).all()
    assert not found[:, 0].any()
    return [bool(value) for value in found[0, 1:]]


def test_a_disc_counts_as_soon_as_it_reaches_into_the_sector() -> None:
    view = {"fov": 1.0, "fov_radius": 3.0}
    # At distance 2 a disc of radius 0.5 is asin(0.25) = 0.25268 wide to either side, so 0.75268 is its limit.
    inside, outside = 2 + 2 * np.array([np.cos(0.752), np.sin(0.752)]), 2 + 2 * np.array([np.cos(0.754), np.sin(0.754)])
    assert detected(view, [disc(*inside, 0.5), disc(*outside, 0.5)]) == [True, False]
    # Straight ahead its near side must lie within 3 m.
    assert detected(view, [disc(5.49, 2, 0.5), disc(5.51, 2, 0.5)]) == [True, False]


def test_a_wide_body_straight_ahead_is_seen() -> None:
    # IR-SIM misses it (D40): the disc is wider than the sector.
    assert detected({"fov": 0.6, "fov_radius": 5}, [disc(3.2, 2, 1.0, unobstructed=True)]) == [True]


def test_what_surrounds_the_eye_is_seen_where_it_is_not_behind() -> None:
    # At distance 0 and inside, half the directions are covered: asin(1) = pi / 2 to either side.
    ghost = {"unobstructed": True}
    assert detected({"fov": 0.1, "fov_radius": 1}, [disc(2, 2, 0.5, **ghost), disc(1.7, 2, 0.5, **ghost)]) == [
        True,
        False,
    ]


def test_unobstructed_bodies_and_those_behind_others_are_seen() -> None:
    ghost = disc(4, 2, 0.3, unobstructed=True)
    assert detected({"fov": 0.5, "fov_radius": 5}, [disc(3.5, 2, 0.3), ghost]) == [True, True]


def test_a_full_turn_and_the_lidars_sector() -> None:
    behind, ahead = disc(0.5, 2, 0.2), disc(4, 2, 0.2)
    assert detected({"fov": 7.0, "fov_radius": 5}, [behind, ahead]) == [True, True]
    lidar = {"sensors": [{"name": "lidar2d", "angle_range": "pi / 2", "range_max": 1.9, "number": 3}]}
    assert detected(lidar, [behind, ahead]) == [False, True]
    assert detected({**lidar, "fov_radius": 1.7}, [behind, ahead]) == [False, False]
    assert detected({**lidar, "fov": "2 * pi"}, [behind, ahead]) == [True, True]


def test_absent_bodies_are_not_seen() -> None:
    entry = {
        "number_range": [0, 1],
        "shape": {"name": "circle", "radius": 0.2},
        "distribution": {"name": "random", "range_low": [3, 3, 0], "range_high": [4, 4, 0]},
    }
    view = {"fov": "2 * pi", "fov_radius": 9}
    sim = ig.compile(ig.load_scenario({"robot": {**DIFF, "state": [2, 2, 0], **view}, "obstacle": entry}), 20)
    sim.reset()
    present = sim.model.present[:, 1]
    assert 0 < present.sum() < 20
    assert (sim.detected(0)[:, 1] == present).all()
    chosen = np.flatnonzero(present)[:1]
    assert np.flatnonzero(sim.detected(0, chosen)[:, 1]).tolist() == chosen.tolist()


def test_the_map_is_not_seen() -> None:
    cells = np.zeros((10, 10), np.bool_)
    cells[5, 5] = True
    robot = {**DIFF, "state": [2, 2, 0], "fov": "2 * pi", "fov_radius": 9}
    sim = ig.compile(ig.load_scenario({"world": {"obstacle_map": cells}, "robot": robot, "obstacle": disc(4, 2, 0.3)}))
    sim.reset()
    assert sim.detected(0).tolist() == [[False, True, False]]


def test_a_body_without_a_field_of_view_is_told() -> None:
    sim = ig.compile(ig.load_scenario({"robot": {**DIFF, "state": [2, 2, 0]}}))
    with pytest.raises(UnknownNameError, match="'robot_0' has no field of view"):
        sim.detected(0)
