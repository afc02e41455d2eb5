"""Tuning: each trial is a run, studies go on as if they had never stopped, and what came out is on disk."""

from __future__ import annotations

import csv
import json
import re
import shlex
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from command_line import run as command

from irsim_gym.errors import IrsimGymError
from irsim_gym.training import tuning
from irsim_gym.training.interruption import TrainingInterruptedError
from irsim_gym.training.policies import SavedPolicy, load_policy
from irsim_gym.training.run import Run
from irsim_gym.training.score import score_run
from irsim_gym.training.search_space import read_space
from irsim_gym.training.train import train
from irsim_gym.training.training_request import TrainingRequest
from irsim_gym.training.tuning import Tuning, run_tuning
from irsim_gym.training.tuning_results import TuningTrial, show_trials

TINY = "n_timesteps: 256, n_envs: 4, n_steps: 16, batch_size: 32, n_epochs: 1, checkpoint_every: 64, gamma: 0.95"
FILE = """\
robot:
  kinematics: {name: diff}
  goal: [9, 9]
  sensors: [{name: lidar2d, range_max: 4}]
task: {max_steps: 20}
"""
SPACE = """\
hyperparameters: {gamma: {low: 0.9, high: 0.99}, ent_coef: [0.0, 0.01]}
rewards: {arrival: {low: 0.5, high: 2.0}}
"""
WORDS = ("tune", "yard.yaml", "--hyperparameters", "ppo.yaml", "--space", "space.yaml", "--dev-levels", 3)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A new working directory with a scenario, hyper-parameters and a space for short studies."""
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(FILE)
    Path("ppo.yaml").write_text(f"default: {{{TINY}}}")
    Path("space.yaml").write_text(SPACE)
    return tmp_path


def asked(**own: Any) -> TrainingRequest:
    return TrainingRequest("yard.yaml", hyperparameters=Path("ppo.yaml"), **own)


def study(out: str, trials: int, **own: Any) -> Path:
    return run_tuning(asked(), trials, space=Path("space.yaml"), out=Path(out), dev_levels=3, **own)


def rows(out: str) -> list[dict[str, str]]:
    return list(csv.DictReader(Path(out, "trials.csv").read_text().splitlines()))


def weights(place: Path) -> list[Any]:
    policy = load_policy(place)
    assert isinstance(policy, SavedPolicy)
    return [one.tolist() for one in policy.model.policy.state_dict().values()]  # type: ignore[union-attr]


def test_without_optuna_the_command_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    assert command(monkeypatch, *WORDS) == 1
    assert capsys.readouterr().err == (
        "irsim-gym tune needs the extra 'tune' (optuna not found): pip install \"irsim_gym[tune]\"\n"
    )
    assert not Path("runs").exists()


def test_what_looks_at_checkpoints_changes_nothing(folder: Path) -> None:
    settings, seen = asked().settings(), []

    def score(run: Run) -> None:
        seen.append(len(score_run(run, levels=3, picture=False)))

    watched = train(settings, folder / "watched", on_checkpoint=score)
    assert seen == [1, 2, 3]  # of four, the last is that of the end
    assert weights(watched.folder) == weights(train(settings, folder / "alone").folder)


def test_a_study_on_disk(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("optuna")
    Path("my_kinds.py").write_text("")
    monkeypatch.setattr(sys, "path", [*sys.path])
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 2, "--import", "my_kinds.py") == 0
    said = capsys.readouterr()
    assert "yard.yaml: 2 trials, 0 of them pruned" in said.out
    best = "--hyperparameters study/best_hyperparameters.yaml --task study/best_task.yaml"
    assert said.out.splitlines()[-1] == f"irsim-gym train yard.yaml --seed 1 --seeds 5 {best} --import my_kinds.py"
    assert "space.yaml does not contain the current values of ent_coef: the first trial draws them" in said.err
    first, second = rows("study")
    assert (first["trial"], first["gamma"], first["reward.arrival"], first["ending"]) == (
        "0",
        "0.95",
        "1.0",
        "finished",
    )
    assert 0.9 <= float(second["gamma"]) <= 0.99
    last = json.loads(Path("study/trials/0001/curve.json").read_text())["points"][-1]
    assert float(second["success"]) == pytest.approx(last["success"], abs=1e-6)
    written = yaml.safe_load(Path("study/trials/0001/hyperparameters.yaml").read_text())["default"]
    assert written["gamma"] == float(f"{float(second['gamma']):.4g}")
    won = max(rows("study"), key=lambda row: float(row["success"]))
    place = Path("study/trials", f"{int(won['trial']):04d}")
    for kept, own in (("best_hyperparameters.yaml", "hyperparameters.yaml"), ("best_task.yaml", "task.yaml")):
        assert Path("study", kept).read_text() == (place / own).read_text()
    assert Path("study/trials.png").read_bytes().startswith(b"\x89PNG")
    assert not list(Path("study").rglob("state.pkl"))

    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 2) == 0
    assert rows("study") == [first, second]
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 3) == 0
    assert rows("study")[:2] == [first, second]
    assert len(rows("study")) == 3
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--out", "study", "--seed", 1) == 1
    assert "study with other settings (settings.seed 0, asked for: 1)" in capsys.readouterr().err
    assert command(monkeypatch, *WORDS, "--out", "study", "--trials", 1, "--overwrite", "--seed", 1) == 0
    assert len(rows("study")) == 1
    Path("other").mkdir()
    Path("other/file").write_text("mine")
    capsys.readouterr()
    assert command(monkeypatch, *WORDS, "--out", "other", "--overwrite") == 1
    assert "other holds something other than a study" in capsys.readouterr().err


def test_an_interrupted_study_ends_as_an_uninterrupted_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C comes in the midst of the second trial, after its second checkpoint."""
    pytest.importorskip("optuna")
    study("whole", 3)
    real, calls = tuning._score, []

    def interrupted(one: Any, run: Run) -> Any:
        calls.append(run.folder.name)
        if calls.count("0001") == 2:
            signal.raise_signal(signal.SIGINT)
        return real(one, run)

    monkeypatch.setattr(tuning, "_score", interrupted)
    with pytest.raises(TrainingInterruptedError, match="To continue, run the same command"):
        study("stopped", 3)
    monkeypatch.setattr(tuning, "_score", real)
    assert len(rows("stopped")) == 1
    study("stopped", 3)
    assert rows("stopped") == rows("whole")
    for number in range(3):
        places = (Path(out, "trials", f"{number:04d}") for out in ("whole", "stopped"))
        first, second = (weights(place) for place in places)
        assert first == second


def test_trials_below_the_median_are_pruned(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("optuna")
    real = tuning._score
    monkeypatch.setattr(tuning, "FINISHED_FIRST", 2)
    monkeypatch.setattr(tuning, "FIRST_PRUNED", 2)

    def scored(one: Any, run: Run) -> Any:
        success = {"0000": 0.5, "0001": 0.7, "0002": 0.4}[run.folder.name]
        return [{**point, "success": success} for point in real(one, run)]

    monkeypatch.setattr(tuning, "_score", scored)
    study("study", 3)
    assert [(row["success"], row["ending"]) for row in rows("study")] == [
        ("0.5", "finished"),
        ("0.7", "finished"),
        ("0.4", "pruned at 2"),
    ]
    assert not Path("study/trials/0002/policy.zip").exists()
    assert Path("study/best_task.yaml").read_text() == Path("study/trials/0001/task.yaml").read_text()


def test_settings_that_cannot_be_trained_are_refused_and_count(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("optuna")
    Path("space.yaml").write_text("rewards: {collision: {low: 0.1, high: 0.2}}")
    study("study", 2)
    assert [row["ending"] for row in rows("study")] == ["refused", "refused"]
    assert "one that continues can cost 3" in rows("study")[1]["why"]
    assert not Path("study/best_task.yaml").exists()
    assert "refused: " in capsys.readouterr().err


def test_a_training_that_fails_is_kept_with_its_reason_and_the_study_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("optuna")
    real = tuning._score
    errors = {
        "0000": ValueError("found invalid values: nan"),
        "0001": RuntimeError("out of memory"),
        "0002": IrsimGymError("no place for the robot"),
    }

    def scored(one: Any, run: Run) -> Any:
        if run.folder.name in errors:
            raise errors[run.folder.name]
        return real(one, run)

    monkeypatch.setattr(tuning, "_score", scored)
    study("study", 4)
    first = rows("study")
    assert [row["ending"] for row in first] == ["failed", "failed", "failed", "finished"]
    assert [row["why"] for row in first] == [*map(str, errors.values()), ""]
    assert Path("study/best_task.yaml").read_text() == Path("study/trials/0003/task.yaml").read_text()
    assert not list(Path("study").rglob("state.pkl"))
    said = capsys.readouterr()
    assert "failed: found invalid values: nan" in said.err
    assert "4 trials, 0 of them pruned" in said.out
    study("study", 4)
    assert rows("study") == first


def test_what_only_a_new_model_can_tell_fails_one_trial(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("optuna")
    Path("ppo.yaml").write_text(f"default: {{{TINY}, normalize: true}}")
    Path("space.yaml").write_text("hyperparameters: {clone: [dash, random]}")
    study("study", 2)
    assert [row["ending"] for row in rows("study")] == ["failed", "failed"]
    assert "statistics of normalize would change" in rows("study")[1]["why"]
    assert "failed: clone: " in capsys.readouterr().err


def test_the_best_trials_come_first_even_without_scores_at_checkpoints(capsys: pytest.CaptureFixture[str]) -> None:
    trials = [
        TuningTrial(0, {}, None, {}, failed="nan"),
        TuningTrial(1, {}, 0.2, {}),
        TuningTrial(2, {}, None, {1: 0.9}),
        TuningTrial(3, {}, 0.6, {}),
        TuningTrial(4, {}, 0.4, {1: 0.1}),
    ]
    show_trials(trials, "yard")
    said = capsys.readouterr().out
    assert "5 trials, 1 of them pruned" in said
    assert re.findall(r"^\W*(\d) .*(?:finished|failed|pruned at)", said, re.MULTILINE) == ["3", "4", "1", "2", "0"]


def test_the_command_that_confirms_the_best_can_be_pasted_and_leaves_the_tuned_seed_out() -> None:
    Path("my yard.yaml").write_text(FILE)
    Path("space.yaml").write_text("hyperparameters: {gamma: [0.9, 0.99]}")
    parameters = {"name": "a $HOME; b"}
    request = TrainingRequest("my yard.yaml", "ppo", 3, task="my task", parameters=parameters, strict=False)
    space = read_space(Path("space.yaml"))
    said = tuning._confirm_command(
        Tuning(request, asked().settings(), space, 3, Path("my study"), None, ("kinds.py", "my rewards.py"))
    )
    assert shlex.split(said) == [
        *("irsim-gym", "train", "my yard.yaml", "--seed", "4", "--seeds", "5"),
        *("--hyperparameters", str(Path("my study", "best_hyperparameters.yaml")), "--task", "my task"),
        *("--algorithm", "ppo", "--set", "name=a $HOME; b", "--import", "kinds.py", "--import", "my rewards.py"),
        "--lenient",
    ]
    assert "'a $HOME" not in said
    assert "'name=a $HOME; b'" in said
