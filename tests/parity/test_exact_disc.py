"""How much shorter ranges to a disc are than to ir-sim's polygon of 64 corners (decision ``exact_disc``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from ir_sim import IrSim
from ours import build


def test_ranges_to_a_disc_are_shorter_as_stated(tmp_path: Path) -> None:
    shares: list[float] = []
    for radius, distance, angle in ((0.3, 1.0, 0.4), (0.5, 2.3, -1.7), (1.7, 6.1, 2.2)):
        disc: dict[str, Any] = {
            "shape": {"name": "circle", "radius": radius},
            "state": [float(30 + distance * np.cos(angle)), float(30 + distance * np.sin(angle)), angle],
        }
        lidar = {"name": "lidar2d", "number": 8001, "angle_range": 6.0, "range_max": 25}
        robot = {"kinematics": {"name": "diff"}, "state": [30, 30, 0], "goal": [50, 50, 0], "sensors": [lidar]}
        scenario = {"world": {"width": 60, "height": 60}, "robot": [{**robot, "shape": {"name": "circle"}}]}
        scenario["obstacle"] = [{**disc, "goal": [50, 50, 0]}]
        reference, sim = IrSim(scenario, tmp_path), build(scenario)
        group, k = sim.sensor(0, "ranges")
        exact, theirs = group.arrays["ranges"][0, k], np.array(reference.env.robot.get_lidar_scan()["ranges"])
        shares += ((theirs - exact)[exact < 25] / radius).tolist()
    assert len(shares) > 1500
    assert min(shares) > 0.0
    median, most, nearly_all = np.quantile(shares, [0.5, 0.95, 0.99])
    assert (median < 0.0012, most < 0.003, nearly_all < 0.0075) == (True, True, True)
    assert np.mean(np.array(shares) > 0.1) < 0.002, "beams that miss the polygon"
