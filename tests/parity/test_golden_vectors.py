"""Numbers recorded from ir-sim 2.12.0: states and velocities after the first steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from ours import build

GOLDEN = yaml.safe_load(
    """
diff_dash:
  scenario:
    robot: [{kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 1, 0], goal: [9, 9, 0],
             behavior: {name: dash}}]
  rows:
    - [[1.070710678, 1.0, 0.1], [0.707106781, 1.0]]
    - [[1.14746029, 1.007700647, 0.2], [0.771349652, 1.0]]
    - [[1.228667265, 1.024162116, 0.3], [0.828586312, 1.0]]
diff_dash_acce:
  scenario:
    robot: [{kinematics: {name: diff}, shape: {name: circle}, state: [1, 1, 0], goal: [1, 9, 0], vel_max: [2, 2],
             vel_min: [-2, -2], acce: [1, 0.5], behavior: {name: dash}}]
  rows:
    - [[1.0, 1.0, 0.005], [0.0, 0.05]]
    - [[1.000999983, 1.000005, 0.015], [0.009999958, 0.1]]
    - [[1.003974539, 1.000049622, 0.03], [0.029748907, 0.15]]
    - [[1.009871665, 1.000226588, 0.05], [0.058997799, 0.2]]
acker_dash:
  scenario:
    robot: [{kinematics: {name: acker}, shape: {name: rectangle, length: 4.6, width: 1.6, wheelbase: 3},
             state: [1, 1, 0, 0], goal: [40, 40, 0], vel_max: [4, 1], behavior: {name: dash}}]
  rows:
    - [[1.4, 1.0, 0.0, 0.785398163], [4.0, 0.785398163]]
    - [[1.8, 1.0, 0.133333333, 0.790552757], [4.0, 0.790552757]]
    - [[2.196449709, 1.053175449, 0.268048359, 0.662427153], [4.0, 0.662427153]]
omni_dash_body:
  scenario:
    robot: [{kinematics: {name: omni, frame: body}, shape: {name: circle}, state: [1, 1, 0.5], goal: [4, 5],
             vel_max: [1, 0.5], behavior: {name: dash}}]
  rows:
    - [[1.069933954, 1.061816019, 0.5], [0.910089968, 0.207205363]]
    - [[1.139643866, 1.123708669, 0.5], [0.908491202, 0.208951989]]
omni_angular_dash:
  scenario:
    robot: [{kinematics: {name: omni_angular}, shape: {name: circle}, state: [1, 1, 0.5], goal: [4, 5, 0],
             acce: [2, 2, 0.5], behavior: {name: dash}}]
  rows:
    - [[1.00796314, 1.027140162, 0.505], [0.2, 0.2, 0.05]]
    - [[1.023617822, 1.081499439, 0.515], [0.4, 0.4, 0.1]]
rvo_pair:
  scenario:
    robot:
      - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 5, 0], goal: [9, 5, 0],
         behavior: {name: rvo}}
      - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [3.2, 5.1, 3.14159], goal: [1, 5, 0],
         behavior: {name: rvo}}
  rows:
    - [[1.085, 5.0, -0.1], [0.85, -1.0]]
    - [[1.171065374, 4.991364659, -0.185433285], [0.864975012, -0.854332849]]
    - [[1.257892118, 4.975076975, -0.240833865], [0.883412253, -0.554005797]]
    - [[1.350715612, 4.952279461, -0.240833865], [0.955820475, 0.0]]
sfm:
  scenario:
    robot: [{kinematics: {name: omni}, shape: {name: circle, radius: 0.2}, state: [1, 5, 0], goal: [9, 5, 0],
             behavior: {name: sfm}}]
    obstacle:
      - {shape: {name: linestring, vertices: [[0, 6], [9, 6]]}, state: [0, 0, 0]}
      - {shape: {name: circle, radius: 0.3}, state: [3, 4.8, 0]}
  rows:
    - [[1.029933012, 4.958320497, 0.0], [0.299330118, -0.416795031]]
    - [[1.083117186, 4.885185895, 0.0], [0.531841741, -0.731346017]]
    - [[1.155012427, 4.790462212, 0.0], [0.718952411, -0.947236835]]
"""
)
LIDAR = yaml.safe_load(
    """
robot:
  - kinematics: {name: diff}
    shape: {name: circle, radius: 0.2}
    state: [5, 5, 0.25]
    sensors: [{name: lidar2d, number: 7, angle_range: 3.0, range_max: 6, offset: [0.1, 0.05, 0.2]}]
obstacle:
  - {shape: {name: circle, radius: 1}, state: [8, 5, 0]}
  - {shape: {name: rectangle, length: 1, width: 2}, state: [5, 8, 0.4]}
  - {shape: {name: linestring, vertices: [[6, 2], [9, 3]]}, state: [0, 0, 0]}
"""
)


@pytest.mark.parametrize("name", list(GOLDEN))
def test_states_and_velocities_are_those_recorded(name: str) -> None:
    golden: dict[str, Any] = GOLDEN[name]
    sim = build(golden["scenario"])
    for pose, velocity in golden["rows"]:
        sim.step()
        found = [*sim.state.pose[0, 0], sim.state.steering[0, 0]][: len(pose)]
        assert found == pytest.approx(pose, abs=1e-9)
        assert sim.state.velocity[0, 0, : len(velocity)] == pytest.approx(velocity, abs=1e-9)


def test_ranges_are_those_recorded_but_at_the_disc() -> None:
    sim = build(LIDAR)
    group, member = sim.scan(0)
    # ir-sim has 1.918993541 for the third beam: it ends at a polygon inside the disc (decision exact_disc).
    expected = [3.269534762, 4.187017579, 1.918133, 6.0, 6.0, 1.992900571, 6.0]
    assert np.asarray(group.arrays["ranges"][0, member], float) == pytest.approx(expected, abs=2e-5)
