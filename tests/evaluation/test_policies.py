"""Saved policies drive as they were trained: same observations, same normalisation, whatever the batch."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
import yaml
from stable_baselines3 import PPO

from irsim_gym import sb3
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.policies.behavior_policies import BehaviorPolicy
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.saved_policies import policies
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policies, load_policy, policy_names
from irsim_gym.scenario.specs.library import find
from irsim_gym.training.requests.train import train
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.run import Settings

TINY = {"n_timesteps": 128, "n_envs": 4, "n_steps": 16, "batch_size": 32, "n_epochs": 1}
DICT = {"name": "navigation", "observation_form": "dict"}
DISCRETE = {"name": "navigation", "action": {"name": "discrete"}, "max_steps": 40}


@pytest.mark.parametrize(
    ("task", "own"), [(None, {}), (None, {"normalize": True}), (DICT, {}), (DICT, {"normalize": True}), (DISCRETE, {})]
)
def test_a_saved_policy_drives_any_number_of_worlds_alike(
    task: dict[str, Any] | None, own: dict[str, Any], tmp_path: Path
) -> None:
    content = yaml.safe_load(find("cluttered_room").read_text())
    content["task"] = {**(task or {"name": "navigation"}), "max_steps": 40}
    scenario = tmp_path / "room.yaml"
    scenario.write_text(yaml.safe_dump(content))
    wanted = Hyperparameters.from_plain({**TINY, **own})
    run = train(Settings(str(scenario), "ppo", 0, None, wanted), tmp_path / "run")
    rows = [evaluate(load_policy(run.folder), Worlds(scenario, n).episodes, 6, "dev") for n in (1, 4, 6)]
    assert rows[0] == rows[1] == rows[2]


def test_it_acts_as_the_algorithm_predicts(tmp_path: Path) -> None:
    wanted = Hyperparameters.from_plain({**TINY, "normalize": True})
    run = train(Settings("empty_goal", "ppo", 0, None, wanted), tmp_path)
    policy = load_policy(run.policy)
    assert isinstance(policy, SavedPolicy)
    assert policy.normalization is not None
    env = sb3.make_vec_env("empty_goal", n_envs=3, seed=5, render_mode=None)
    expected, _ = policy.model.predict(policy.normalization.normalize_obs(env.reset()), deterministic=True)
    acted = policy.act(env.worlds.episodes, np.array([0, 1, 2]))
    np.testing.assert_allclose(acted, expected, atol=1e-6)
    assert policy.normalization.training is False


@pytest.mark.parametrize(("most", "expected"), [(policies.MOST_WEIGHTS, 1), (100, 2)])
def test_a_small_network_runs_on_one_thread(most: int, expected: int, monkeypatch: pytest.MonkeyPatch) -> None:
    env = sb3.make_vec_env("empty_goal", n_envs=2, seed=5, render_mode=None)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, device="cpu")
    predict, threads, before = model.predict, list[int](), torch.get_num_threads()
    monkeypatch.setattr(
        model, "predict", lambda *a, **k: (threads.append(torch.get_num_threads()), predict(*a, **k))[1]
    )
    monkeypatch.setattr(policies, "MOST_WEIGHTS", most)
    env.reset()
    torch.set_num_threads(2)
    SavedPolicy(model).act(env.worlds.episodes, np.array([0, 1]))
    after = torch.get_num_threads()
    torch.set_num_threads(before)
    assert (threads, after) == ([expected], 2)


def test_all_unknown_policies_are_named_at_once() -> None:
    with pytest.raises(IrsimGymError) as refused:
        load_policies(["dsh", "dash", "runs/nowhere", "orcs"])
    problems, cures = str(refused.value).splitlines()[:3], str(refused.value).splitlines()[3:]
    assert problems == [
        "no policy named 'dsh' (did you mean 'dash'?)",
        "no policy at runs/nowhere: no such file or folder",
        "no policy named 'orcs' (did you mean 'orca'?)",
    ]
    runs, behaviors, shipped, what = cures
    assert runs.startswith("  runs here: ") or "no run is here yet" in runs
    assert {"random", "dash", "rvo", "sfm", "orca"} <= set(behaviors.removeprefix("  behaviors: ").split(", "))
    assert {"cluttered_room", "dense_room"} <= set(shipped.removeprefix("  shipped policies: ").split(", "))
    assert "the folder of a run" in what
    again = pickle.loads(pickle.dumps(refused.value))
    assert (str(again), again.source) == (str(refused.value), "dsh")


def test_sources() -> None:
    for name in ("dash", "rvo", "sfm", "orca"):  # behaviours of one body, then of a group
        assert isinstance(load_policy(name), BehaviorPolicy)
    assert policy_names(["runs/a", "runs/b/policy.zip", "best.zip", "dash"]) == ["a", "b", "best", "dash"]
    assert policy_names(["x/policy.zip", "dash", "y/x"]) == ["x-1", "dash", "x-2"]


def test_what_is_no_policy(tmp_path: Path) -> None:
    with pytest.raises(IrsimGymError, match="no policy at"):
        load_policy(tmp_path)
    (tmp_path / "policy.zip").write_text("nothing")
    with pytest.raises(IrsimGymError, match="no policy of Stable-Baselines3"):
        load_policy(tmp_path / "policy.zip")
