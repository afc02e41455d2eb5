"""Pictures show where robots believe to be, and where their scanners are blind."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import irsim_gym as ig
from irsim_gym.envs.parts.pictures import make_renderer

LIDAR = {"name": "lidar2d", "number": 91, "angle_range": 2 * np.pi, "range_max": 4.0, "offset": [0.5, 0.0, 0.0]}


def driven(*disturbances: dict[str, Any], heading: float = 0.0, n_worlds: int = 1) -> ig.Simulation:
    """Return worlds in which a robot has been commanded a metre ahead."""
    robot = {"kinematics": {"name": "diff"}, "state": [5, 5, heading], "sensors": [LIDAR]}
    data = {"world": {"name": "d"}, "robot": {**robot, "disturbances": list(disturbances)}}
    sim = ig.compile(ig.load_scenario(data), n_worlds, agents=(0,))
    sim.reset(seed=0)
    for _ in range(10):
        sim.step([1.0, 0.0])
    return sim


def test_the_believed_outline_stands_where_the_robot_believes_to_be() -> None:
    (mark,) = driven({"name": "slip", "ahead": 0.5}).marks(0)
    np.testing.assert_allclose(np.linalg.norm(mark.points - [6.0, 5.0], axis=1), 0.2)
    assert (mark.style, mark.closed, mark.fill) == ("dashed", True, "")


def test_the_sector_spans_the_beams_that_are_blind_also_behind_the_robot() -> None:
    n = 40
    sim = driven({"name": "blind_sector", "width": 1.0}, heading=np.pi / 2, n_worlds=n)
    angles, behind = np.linspace(-np.pi, np.pi, 91) + np.pi / 2, 0
    for w in range(n):
        (mark,) = sim.marks(w)
        assert mark.points[0] == pytest.approx([5.0, 6.5])
        rim = (mark.points[1:] - mark.points[0]) / 4.0
        blind = sim.parts.disturbances.scans[0].arrays["blind"][w, 0]
        seen = np.column_stack([np.cos(angles[blind]), np.sin(angles[blind])])
        np.testing.assert_allclose(sorted(rim.tolist()), sorted(seen.tolist()), atol=1e-9)
        # Neighbours are beams apart, 4 degrees: the sector has no jump.
        assert np.linalg.norm(np.diff(rim, axis=0), axis=1).max() < np.deg2rad(4.1)
        behind += int(blind[0] and blind[-1])
    assert behind > 0


def test_frames_and_scenes_show_them_and_are_as_before_without() -> None:
    slip, blind = {"name": "slip", "ahead": 0.5}, {"name": "blind_sector", "width": 1.0}
    plain, disturbed = driven(), driven(slip, blind)
    assert plain.marks(0) == ()
    renderer = make_renderer(disturbed)
    assert len(renderer.scene().overlay.marks) == 2
    shown = renderer.frame()
    hidden = make_renderer(disturbed, marks=lambda world: ()).frame()
    differs = np.argwhere((shown != hidden).any(axis=2))
    # The robot believes in (6, 5), and its scanner reaches 4 m from (6, 5): nothing else changes.
    (column, row), (further, _) = (renderer.layout.column_row(x, 5.0) for x in (6.0, 7.0))
    away = np.hypot(*(differs - [row, column]).T) / (further - column)
    assert 3.0 < away.max() < 4.1
