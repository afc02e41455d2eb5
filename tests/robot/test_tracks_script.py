"""agents/tracks.py: what it shows equals what the simulator's tracker does, also for noisy scans that lose beams."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_twins import DIFF, FOLLOWED, MOVING, N_WORLDS, OMNI, SCANNER, episodes

from irsim_gym.robot.export import export_for_robot
from irsim_gym.robot.inputs import measured, scanner_form
from irsim_gym.robot.policy_graph import UnfitForRobotError

AGENTS = Path(__file__).parents[2] / "agents"
Tracks = runpy.run_path(str(AGENTS / "tracks.py"))["Tracks"]
SCAN_ONLY = str(AGENTS / "shelf" / "general_scan.npz")
NOISY = {
    **OMNI,
    "sensors": [{**SCANNER, "noise": True, "std": 0.02}],
    "disturbances": [{"name": "lost_beams", "chance": 0.1}, {"name": "range_bias", "offset": 0.02}],
}


@pytest.mark.parametrize(("robot", "noise"), [(DIFF, 0.0), (NOISY, 0.02)], ids=["clear", "noisy"])
def test_the_script_follows_what_the_simulator_follows(robot: dict[str, Any], noise: float) -> None:
    played, rng, moving = episodes(robot, FOLLOWED, **MOVING), np.random.default_rng(0), 0
    scan = scanner_form(played)
    assert scan is not None
    trackers = [Tracks(scan.model_dump(), 0.1, noise=noise) for _ in range(N_WORLDS)]
    for step in range(60):
        if step:
            played.step(rng.uniform(-1.0, 1.0, (N_WORLDS, 1, 2)))
        values = measured(played)
        rows = [one.rows(*seen) for one, *seen in zip(trackers, values["ranges"], values["pose"], strict=True)]
        np.testing.assert_allclose(rows, values["bodies"], rtol=0.0, atol=1e-6)
        moving += int(np.isfinite(values["bodies"][..., 0]).sum())
    assert moving > 100


def test_a_robot_that_stands_sees_points_right_on_its_beams_and_nothing_that_moves() -> None:
    played = episodes(DIFF, FOLLOWED)
    scan, values = scanner_form(played), measured(played)
    assert scan is not None
    tracker = Tracks(scan.model_dump(), 0.1)
    for _ in range(30):
        assert not np.isfinite(tracker.rows(values["ranges"][0], values["pose"][0])).any()


def test_a_policy_that_sees_tracks_leaves_with_a_tracker(tmp_path: Path) -> None:
    with pytest.raises(UnfitForRobotError, match="it observes tracks: add '--bodies tracked'"):
        export_for_robot(SCAN_ONLY, tmp_path, levels=1)
    exported = export_for_robot(SCAN_ONLY, tmp_path, levels=2, bodies="tracked")
    assert exported.difference < 1e-5
    assert "bodies" in exported.contract.inputs
    assert exported.contract.needs == ("scan", "odometry", "grid")
