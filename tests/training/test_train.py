"""Training, interrupted and resumed. The runs are tiny: they show that nothing is lost, not that much is learned."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.requests.interruption import TrainingInterruptedError
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress, newest_checkpoint
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.scenario.specs.ids import scenario_name
from irsim_gym.training.requests.train import train
from irsim_gym.training.runs.models import algorithm_class, new_model
from irsim_gym.training.settings.hyperparameters import Hyperparameters, Linear
from irsim_gym.training.settings.run import Run, Settings, environment_id

PPO: dict[str, Any] = {"n_steps": 16, "batch_size": 32, "n_epochs": 2, "learning_rate": "lin_3e-3"}
PPO["policy_kwargs"] = {"net_arch": [16], "activation_fn": "relu"}
SAC: dict[str, Any] = {"learning_starts": 16, "batch_size": 8, "buffer_size": 500, "gradient_steps": 1}
SAC["policy_kwargs"] = {"net_arch": [16]}
ARGUMENTS: dict[str, dict[str, Any]] = {
    "ppo": PPO,
    "sac": SAC,
    "td3": {**SAC, "action_noise": 0.2},
    "tqc": SAC,
    "dqn": {**SAC, "target_update_interval": 50, "exploration_fraction": 0.9},
    "a2c": {"n_steps": 16, "learning_rate": "lin_3e-3", "policy_kwargs": {"net_arch": [16]}},
}
TASKS = {"dqn": "discrete_navigation"}
NORMALIZED = {"normalize": {"norm_reward": True}, "reward_scale": 2.0}


def settings(algorithm: str = "ppo", **own: Any) -> Settings:
    steps = {"n_timesteps": 512, "n_envs": 4, "checkpoint_every": 192, **own}
    wanted = Hyperparameters.from_plain({**steps, **ARGUMENTS[algorithm]})
    return Settings("empty_goal", algorithm, 3, TASKS.get(algorithm), wanted)


def weights(run: Run) -> dict[str, torch.Tensor]:
    model: BaseAlgorithm = algorithm_class(run.settings()).load(run.policy, device="cpu")
    return model.policy.state_dict()


def assert_equal_weights(one: Run, other: Run) -> None:
    first, second = weights(one), weights(other)
    assert first.keys() == second.keys()
    for name, value in first.items():
        assert torch.equal(value, second[name]), name


def in_parts(asked: Settings, folder: Path, interrupt: Callable[[int, int], None]) -> Run:
    """Train, with an interruption after some 200 of 512 steps."""
    interrupt(200, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError) as stop:
        train(asked, folder)
    assert stop.value.signal == signal.SIGINT
    parts = Run(folder)
    newest = newest_checkpoint(parts.checkpoints)
    assert newest is not None
    assert 192 <= load_progress(newest).steps < 512
    assert not parts.finished()
    torch.manual_seed(99)
    return train(asked, folder, resume=True)


@pytest.mark.parametrize(
    ("algorithm", "own"),
    [("ppo", {}), ("ppo", NORMALIZED), ("ppo", {"mirror": True}), ("sac", {}), ("sac", NORMALIZED)]
    + [(name, {}) for name in ("td3", "tqc", "dqn", "a2c")],
)
def test_resumed_run_equals_an_uninterrupted_one(
    algorithm: str, own: dict[str, Any], tmp_path: Path, interrupt: Callable[[int, int], None]
) -> None:
    asked = settings(algorithm, **own)
    whole = train(asked, tmp_path / "whole")
    parts = in_parts(asked, tmp_path / "parts", interrupt)
    assert_equal_weights(whole, parts)
    policy = load_policy(parts.folder)
    assert isinstance(policy, SavedPolicy)
    assert type(policy.model) is algorithm_class(asked)


def test_mirrored_experience_teaches_something_else(tmp_path: Path) -> None:
    plain, mirrored = (train(settings(mirror=flag), tmp_path / str(flag)) for flag in (False, True))
    assert not all(torch.equal(value, weights(mirrored)[name]) for name, value in weights(plain).items())
    assert mirrored.settings().hyperparameters.mirror


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (settings("sac", mirror=True), "mirror: only PPO without memory"),
        (settings(mirror=True, normalize={"norm_obs": True}), "mirror: observations that VecNormalize"),
        (replace(settings(mirror=True), scenario="parking", task="pose_navigation"), "'position' is in the frame"),
    ],
)
def test_what_cannot_be_mirrored_leaves_no_run(asked: Settings, said: str, tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError, match=said):
        train(asked, tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_networks_for_other_observations_are_refused_without_their_bounds() -> None:
    with pytest.raises(IrsimGymError, match="only with images not with these observations") as found:
        new_model(settings(policy="CnnPolicy"))
    assert "CnnPolicy" in str(found.value)


def test_another_seed_gives_other_weights(tmp_path: Path) -> None:
    one = train(settings(), tmp_path / "one")
    asked = settings()
    other = train(Settings(asked.scenario, asked.algorithm, 4, None, asked.hyperparameters), tmp_path / "other")
    assert not all(torch.equal(value, weights(other)[name]) for name, value in weights(one).items())


def test_what_a_run_leaves(tmp_path: Path) -> None:
    run = train(settings(), tmp_path / "run")
    found = list_checkpoints(run.checkpoints)
    assert [int(path.name) for path in found] == [192, 384, 512]
    assert [(path / "state.pkl").exists() for path in found] == [False, False, True]
    assert run.policy.stat().st_size < 0.7 * (found[-1] / "policy.zip").stat().st_size
    progress = load_progress(found[-1])
    assert (progress.steps, progress.training_seconds > 0.0) == (512, True)
    config = json.loads(run.config.read_text())
    assert config["settings"]["seed"] == 3
    assert config["machine"]["versions"]["torch"]
    assert (run.folder / "training.csv").read_text().startswith("steps,training_seconds,")
    (log,) = (run.folder / "tensorboard").iterdir()
    for name in (b"outcome/success", b"reward/progress", b"rollout/success_rate"):
        assert name in log.read_bytes()
    assert not list(run.folder.rglob(".*"))


KILLED = """
import os, signal, sys
from pathlib import Path
from test_train import settings, train
original = Path.replace
for name in sys.argv[2:]:
    def replace(self, target):
        if Path(target).name == name:
            os.kill(os.getpid(), signal.SIGKILL)
        return original(self, target)
    child = os.fork()
    if not child:
        Path.replace = replace
        train(settings(n_timesteps=64, checkpoint_every=64), Path(sys.argv[1]) / Path(name).stem)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL, name
"""


def test_what_a_killed_run_left_half_written_goes_when_it_is_taken_up(tmp_path: Path) -> None:
    names = "config.json", "training.csv", "policy.zip"
    paths = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    command = [sys.executable, "-c", KILLED, str(tmp_path), *names]
    subprocess.run(command, env={**os.environ, "PYTHONPATH": paths}, check=True)
    for name in names:
        folder = tmp_path / Path(name).stem
        assert [path.name[:-9] for path in folder.glob(".*")] == [f".{name}"]  # a point and eight letters
        train(settings(n_timesteps=64, checkpoint_every=64), folder, resume=name != "config.json")
        assert not list(folder.glob(".*"))
    folder = tmp_path / "run"
    folder.mkdir()
    others = [folder / name for name in (".config.json.swp", ".policy.zip.mine1234.bak", ".notes.txt.abcd1234")]
    (folder / ".policy.zip.abcd_123").touch()
    for path in others:
        path.touch()
    train(settings(n_timesteps=64, checkpoint_every=64), folder)
    assert sorted(folder.glob(".*")) == sorted(others)


def test_a_finished_run_is_left_alone(tmp_path: Path) -> None:
    run = train(settings(), tmp_path)
    before = run.policy.stat().st_mtime_ns
    train(settings(), tmp_path)
    assert run.policy.stat().st_mtime_ns == before


def test_a_folder_with_another_run_is_refused(tmp_path: Path, interrupt: Callable[[int, int], None]) -> None:
    interrupt(100, signal.SIGTERM)
    with pytest.raises(TrainingInterruptedError) as stop:
        train(settings(), tmp_path)
    assert stop.value.signal == signal.SIGTERM
    with pytest.raises(IrsimGymError, match="--resume"):
        train(settings(), tmp_path)
    with pytest.raises(IrsimGymError, match="other settings"):
        train(settings(n_timesteps=1024), tmp_path, resume=True)


def test_the_second_signal_stops_at_once() -> None:
    from irsim_gym.evaluation.requests.interruption import StopRequest

    request = StopRequest()
    with request.listening():
        os.kill(os.getpid(), signal.SIGINT)
        assert request.signal == signal.SIGINT
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


def test_settings_survive_their_file(tmp_path: Path) -> None:
    run = Run(tmp_path)
    assert not run.exists()
    with pytest.raises(IrsimGymError, match="no file with the settings of a training run"):
        run.settings()
    run.begin(settings("sac", **NORMALIZED))
    assert run.settings() == settings("sac", **NORMALIZED)


def test_seeds_share_no_levels() -> None:
    asked = settings()
    other = Settings(asked.scenario, asked.algorithm, 4, None, asked.hyperparameters)
    assert other.first_level - asked.first_level > asked.hyperparameters.n_envs


@pytest.mark.parametrize("scenario", ["corridor", "irsim_gym/corridor-v0", "some/corridor.yaml"])
def test_environment_id(scenario: str) -> None:
    assert environment_id(scenario) == "irsim_gym/corridor-v0"
    assert scenario_name(scenario) in ("corridor", "some/corridor.yaml")


def test_linear_schedule() -> None:
    assert [Linear(2.0)(remaining) for remaining in (1.0, 0.25, 0.0)] == [2.0, 0.5, 0.0]
