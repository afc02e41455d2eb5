"""``step_mode: external``: the caller moves the bodies, flags and scans follow, as in ir-sim."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from beams import compare_scans
from harness import Pair

SCENARIO: dict[str, Any] = yaml.safe_load(
    """
world: {step_mode: external}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [2, 5, 0], goal: [8, 5, 0],
     behavior: {name: dash}, sensors: [{name: lidar2d, number: 40, angle_range: 5.0, range_max: 6}]}
obstacle:
  - {kinematics: {name: diff}, shape: {name: rectangle, length: 1, width: 0.4}, state: [5, 8, 0]}
  - {shape: {name: circle, radius: 0.5}, state: [6, 4.4, 0]}
"""
)


def test_bodies_go_where_they_are_put(tmp_path: Path) -> None:
    pair = Pair(SCENARIO, tmp_path)
    flags = []
    for step in range(40):
        way = 2 + 0.16 * step
        for b, pose in ((0, [way, 5, 0.1 * step]), (1, [5, 8 - 0.1 * step, 0.05 * step])):
            pair.reference.objects[b].set_state(pose)
            pair.sim.state.pose[0, b] = pose
        pair.reference.step()
        pair.sim.step()
        after = pair.reference.snapshot()
        for b, theirs in enumerate(pair.reference.objects):
            np.testing.assert_array_equal(pair.sim.state.pose[0, b], theirs.state[:3, 0])
        assert not pair.compare_flags(after, skip=set())
        compare_scans(pair)
        flags.append(after.flags[0])
    assert {arrived for arrived, _, _ in flags} == {True, False}
    assert {collided for _, collided, _ in flags} == {True, False}
