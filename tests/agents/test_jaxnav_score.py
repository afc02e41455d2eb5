"""agents/studies/jaxnav_score.py: which episodes count, and that actions are drawn."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from irsim_gym.evaluation.policies.reference_policies import reference_policy
from irsim_gym.evaluation.requests.episode_setup import make_episodes

STUDIES = Path(__file__).parents[2] / "agents" / "studies"
WORLD: dict[str, Any] = {"height": 10, "width": 10, "step_time": 0.1}
ROBOT = {"kinematics": {"name": "diff"}, "vel_max": [1, 1], "behavior": {"name": "dash"}}
TASK: dict[str, Any] = {"name": "navigation", "max_steps": 50}


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(STUDIES))
    import jaxnav_score

    return jaxnav_score


def test_levels_begin_again_within_a_window_and_a_cut_episode_does_not_count(script: Any) -> None:
    near, far = ({**ROBOT, "state": [1, y, 0], "goal": [x, y]} for x, y in ((3, 2), (9, 7)))
    alone = make_episodes({"world": WORLD, "robot": [near], "task": TASK}, n_worlds=2, team=True)
    assert script.window(alone, reference_policy("dash")).tolist() == [[2, 2], [2, 2]], "1.7 m: 17 of 50 steps"
    both = make_episodes({"world": WORLD, "robot": [near, far], "task": TASK}, n_worlds=1, team=True)
    assert script.window(both, reference_policy("dash")).tolist() == [[1], [2]], "the far one runs out of time"
    assert script.rates(both, reference_policy("dash"), 3).tolist() == [0.5]


class Means:
    def predict(self, seen: float, deterministic: bool = True) -> tuple[float, bool]:
        return seen, deterministic


def test_actions_of_a_run_are_drawn(script: Any) -> None:
    policy = script.SavedPolicy.__new__(script.SavedPolicy)
    policy.model = Means()
    assert script.drawing(policy).model.predict(2.0, deterministic=True) == (2.0, False)


def test_a_score_is_written_beside_those_that_are_there(
    script: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "score.json").write_text('{"an older one": 1}')
    words = ["jaxnav_score.py", "jaxnav_single", "dash", "--levels", "4", "--windows", "1"]
    monkeypatch.setattr("sys.argv", [*words, "--out", str(tmp_path / "score.json")])
    script.main()
    rows = json.loads((tmp_path / "score.json").read_text())
    assert list(rows) == ["an older one", "jaxnav_single dash"]
    assert rows["jaxnav_single dash"]["published"]["success"] == 0.98
    assert np.isfinite(rows["jaxnav_single dash"]["worst 5 %"])
    assert "jaxnav_single dash" in capsys.readouterr().out
