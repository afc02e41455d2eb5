"""agents/studies/barn_policy.py: the score of BARN, and what the script writes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.evaluation.measures.metrics import EpisodeRow

STUDIES = Path(__file__).parents[2] / "agents" / "studies"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import barn_policy

    return barn_policy


def row(level: int, outcome: str, time: float) -> EpisodeRow:
    return EpisodeRow(
        level=level,
        outcome=outcome,
        hit="",
        steps=round(20 * time),
        time=time,
        path_length=10.0,
        optimum=10.0,
        min_clearance=0.1,
        least_time=5.0,
        acceleration=0.0,
        jerk=0.0,
        intrusion_025=0.0,
        intrusion_045=0.0,
        time_to_collision=np.nan,
    )


def test_scores_by_hand(script: Any) -> None:
    """A path of 10 m takes 5 s at 2 m/s: 5 / 20; at most 5 / 10; at least 5 / 40; nothing for a collision."""
    rows = [row(0, "success", 20.0), row(6, "success", 8.0), row(12, "success", 90.0), row(18, "collision", 3.0)]
    found = script.figures(rows, [10.0] * 4)
    assert [one["score"] for one in found["worlds"].values()] == [0.25, 0.5, 0.125, 0.0]
    assert (found["success"], found["collision"], found["timeout"]) == (0.75, 0.25, 0.0)
    assert found["score"] == pytest.approx(0.2188)
    assert found["time"] == pytest.approx(39.33)


def test_it_plays_a_copy(script: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A post beside the way, then one on it: who drives straight on arrives in the first world alone."""
    copy, out = tmp_path / "copy.npz", tmp_path / "out.json"
    posts = np.array([[-4.425, 0.075], [-2.175, 6.075]])
    np.savez(copy, cylinder_xy=posts, world_start=np.arange(3), path_length=np.full(2, 10.0))
    monkeypatch.setattr(script, "OUT", out)
    monkeypatch.setattr(script, "WORLDS", range(2))
    script.main(copy, ["dash"])
    written = json.loads(out.read_text())
    assert [one["outcome"] for one in written["policies"]["dash"]["worlds"].values()] == ["success", "collision"]
    assert written["policies"]["dash"]["worlds"]["0"]["score"] == 0.5
    assert str(tmp_path) not in out.read_text()
