"""What a training run tells on standard error, and what it says when it is stopped."""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from irsim_gym.cli import main

PPO = {"n_timesteps": 512, "n_envs": 4, "checkpoint_every": 192, "n_steps": 16, "batch_size": 32, "n_epochs": 1}
Train = Callable[..., tuple[int, list[str]]]


@pytest.fixture
def train(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Train:
    """Run ``irsim-gym train`` in a new folder; return its exit status and what it told."""
    monkeypatch.chdir(tmp_path)
    Path("ppo.yaml").write_text(yaml.safe_dump({"default": {**PPO, "policy_kwargs": {"net_arch": [8]}}}))

    def trained(scenario: str, *arguments: str) -> tuple[int, list[str]]:
        words = ["irsim-gym", "train", scenario, "--hyperparameters", "ppo.yaml", *arguments]
        monkeypatch.setattr(sys, "argv", words)
        with pytest.raises(SystemExit) as end:
            main()
        return int(end.value.code or 0), capsys.readouterr().err.splitlines()

    return trained


def stop(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_a_log_has_a_line_for_each_checkpoint(train: Train) -> None:
    status, said = train("empty_goal", "--dev-levels", "0", "--resume")
    assert status == 0
    assert said[0] == "no run in runs/empty_goal-ppo-0 to continue: starting a new one"
    assert said[1] == "training PPO on empty_goal, seed 0, in runs/empty_goal-ppo-0"
    form = r"(\d+) of 512 steps after \d+ s(, success \d+% of recent training episodes)?"
    found = [match[1] for match in (re.fullmatch(form, line) for line in said) if match]
    assert found == ["192", "384", "512"]


def test_scoring_that_is_stopped_goes_on_with_the_same_command(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    command = ("empty_goal", "--dev-levels", "2")
    with monkeypatch.context() as patched:
        patched.setattr("irsim_gym.training.curves.score.evaluate", stop)
        status, said = train(*command)
    assert status == 130
    assert "scoring 3 checkpoints on 2 dev levels" in said
    assert said[-1] == "the training is finished, but its scoring is not: run the same command to continue."
    assert train(*command)[0] == 0
    assert Path("runs/empty_goal-ppo-0/curve.csv").is_file()


def test_a_second_ctrl_c_is_told_too(train: Train, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("irsim_gym.training.runs.monitoring.TrainingMonitor.update_progress", stop)
    status, said = train("empty_goal")
    assert status == 130
    assert said[-1].endswith("the newest checkpoint is kept. To go on, run the same command with --resume.")


def test_a_demonstration_that_is_stopped(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("irsim_gym.cli.work.demo.TrainingRequest", stop)
    monkeypatch.setattr(sys, "argv", ["irsim-gym", "demo"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130
    assert capsys.readouterr().err == "stopped. Run the same command to continue.\n"


def test_a_run_that_ends_before_learning_starts_is_noted(train: Train) -> None:
    Path("ppo.yaml").write_text("default: {n_timesteps: 64, n_envs: 4, learning_starts: 100, buffer_size: 100}")
    status, said = train("empty_goal", "--dev-levels", "0", "--algorithm", "sac")
    assert status == 0
    assert said[1] == "note: the run learns nothing: learning_starts is 100, and the run has 64 steps"


def test_a_team_of_one_is_noted(train: Train) -> None:
    status, said = train("empty_goal", "--dev-levels", "0", "--team", "episode")
    assert status == 0
    assert said[0] == "training PPO on empty_goal, seed 0, in runs/empty_goal-ppo-episode-0"
    assert said[1] == "note: this team has one robot; --team needs several"
