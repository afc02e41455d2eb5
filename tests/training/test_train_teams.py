"""Training a policy that all robots of a scenario share: modes, masks, checkpoints."""

import json
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
import yaml

from irsim_gym import sb3
from irsim_gym.cli import main
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
from irsim_gym.evaluation.saved_policies.algorithms import find_algorithm
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.environment import build_environment
from irsim_gym.training.runs.models import algorithm_class
from irsim_gym.training.settings.hyperparameters import Hyperparameters, load_hyperparameters
from irsim_gym.training.settings.run import Run, Settings

PLACES = {"name": "random", "range_low": [0.5, 0.5, -3.14], "range_high": [4.5, 4.5, 3.14]}
SCENARIO = {
    "world": {"width": 5, "height": 5, "step_time": 0.1},
    "robot": [
        {
            "number": 3,
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": 0.2},
            "distribution": PLACES,
            "vel_min": [0, -2],
            "vel_max": [2, 2],
            "goal_threshold": 0.4,
            "sensors": [{"name": "lidar2d", "number": 12, "range_max": 3}],
        }
    ],
    "task": {"max_steps": 12, "observations": [{"name": "scan", "sectors": 6}, "goal"]},
}
PPO: dict[str, Any] = {"n_steps": 16, "batch_size": 64, "n_epochs": 2, "policy_kwargs": {"net_arch": [16]}}
SAC: dict[str, Any] = {"learning_starts": 24, "batch_size": 8, "buffer_size": 500, "policy_kwargs": {"net_arch": [16]}}
GRU: dict[str, Any] = {**PPO, "policy_kwargs": {"net_arch": [8], "memory_size": 8}}
ARGUMENTS = {"ppo": PPO, "sac": SAC, "gru_ppo": GRU}
NORMALIZED = {"normalize": {"norm_reward": True}, "reward_scale": 2.0}


@pytest.fixture
def scenario(tmp_path: Path) -> str:
    path = tmp_path / "three_robots.yaml"
    path.write_text(yaml.safe_dump(SCENARIO))
    return str(path)


def settings(scenario: str, algorithm: str = "ppo", team: str | None = "episode", **own: Any) -> Settings:
    steps = {"n_timesteps": 960, "n_envs": 4, "checkpoint_every": 384, "team": team, **own}
    plain = {**steps, **ARGUMENTS[algorithm]}
    return Settings(scenario, algorithm, 3, None, Hyperparameters.from_plain(plain))


def weights(run: Run) -> torch.Tensor:
    kind: Any = algorithm_class(run.settings())
    model = kind.load(run.policy, device="cpu")
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


@pytest.mark.parametrize(
    ("algorithm", "team", "own"),
    [
        ("ppo", "episode", {}),
        ("ppo", "episode", NORMALIZED),
        ("ppo", "respawn", NORMALIZED),
        ("ppo", "respawn", {}),
        ("sac", "respawn", {}),
        ("gru_ppo", "episode", NORMALIZED),
        ("gru_ppo", None, {}),
    ],
)
def test_a_resumed_team_run_equals_an_uninterrupted_one(
    scenario: str, algorithm: str, team: str, own: dict[str, Any], tmp_path: Path, interrupt: Callable[[int, int], None]
) -> None:
    asked = settings(scenario, algorithm, team, **own)
    whole = train(asked, tmp_path / "whole")
    interrupt(400, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError):
        train(asked, tmp_path / "parts")
    parts = Run(tmp_path / "parts")
    assert not parts.finished()
    torch.manual_seed(99)
    train(asked, tmp_path / "parts", resume=True)
    assert torch.equal(weights(whole), weights(parts))


def test_a_team_run_is_masked(scenario: str) -> None:
    env = build_environment(settings(scenario, **NORMALIZED))
    assert type(env) is sb3.MaskedVecNormalize
    assert (env.num_envs, env.unwrapped.batch.respawn) == (12, False)
    env.close()


def test_the_command_line_trains_a_team(
    scenario: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "ppo.yaml"
    file.write_text(yaml.safe_dump({"default": {"n_timesteps": 400, "n_envs": 4, **PPO}}))
    out = tmp_path / "run"
    arguments = ["--hyperparameters", str(file), "--out", str(out), "--dev-levels", "0", "--team", "episode"]
    monkeypatch.setattr(sys, "argv", ["irsim-gym", "train", scenario, *arguments])
    with pytest.raises(SystemExit) as end:
        main()
    assert not end.value.code
    stored = json.loads((out / "config.json").read_text())["settings"]["hyperparameters"]
    assert stored["team"] == "episode"
    log = (out / "training.csv").read_text().splitlines()
    assert 0.0 < float(log[-1].split(",")[-1]) < 0.6  # idle_share
    assert "policy.zip" in capsys.readouterr().out
    model = find_algorithm("ppo").load().load(out / "policy.zip", device="cpu")
    assert model.rollout_buffer_class is sb3.MaskedRolloutBuffer


def test_an_algorithm_that_learns_from_waiting_robots_is_refused(scenario: str) -> None:
    with pytest.raises(IrsimGymError, match=r"^sac learns from robots that wait .* --team respawn, .* or ppo, a2c"):
        TrainingRequest(scenario, "sac", team="episode").settings()
    assert TrainingRequest(scenario, "sac", team="respawn").settings().hyperparameters.team == "respawn"


def test_a_mode_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError, match="team must be 'episode' or 'respawn'"):
        load_hyperparameters("ppo", "irsim_gym/empty_goal-v0", overrides={"team": "lifelong"})
