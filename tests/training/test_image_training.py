"""Agents that look at pictures are trained, saved, driven and scored like any other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict
from stable_baselines3 import PPO

from irsim_gym import sb3
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.comparison.demonstrations import load_demonstrations
from irsim_gym.evaluation.comparison.recorder import record_demonstrations
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.scenario import load_scenario
from irsim_gym.tasks import load_task
from irsim_gym.training.requests.train import train
from irsim_gym.training.requests.training_request import TrainingRequest
from irsim_gym.training.runs.models import dict_policy_arguments, network_kind
from irsim_gym.training.settings.hyperparameters import Hyperparameters, load_hyperparameters
from irsim_gym.training.settings.run import Settings

TINY = {"n_timesteps": 128, "n_envs": 4, "n_steps": 16, "batch_size": 32, "n_epochs": 1}
NET = {"policy_kwargs": {"features_extractor_kwargs": {"features_dim": 16}, "net_arch": [16]}}
IMAGE = "{name: occupancy_image, pixels: 36}"
PICTURE, BESIDE = f"[{IMAGE}]", f"[goal, {IMAGE}]"


def written(folder: Path, observations: str, form: str = "flat") -> str:
    """Return a task file with these observations."""
    file = folder / "looking.yaml"
    rewards = "rewards: [progress, arrival, collision]\nendings: [arrived, collided, left_world]\nmax_steps: 30\n"
    file.write_text(f"name: blank\nobservation_form: {form}\nobservations: {observations}\n{rewards}")
    return str(file)


@pytest.mark.parametrize(
    ("observations", "algorithm", "own"),
    [(PICTURE, "ppo", {}), (BESIDE, "ppo", {"normalize": {"norm_obs_keys": ["vector"]}}), (BESIDE, "gru_ppo", {})],
)
def test_training_and_driving(observations: str, algorithm: str, own: dict[str, Any], tmp_path: Path) -> None:
    task = written(tmp_path, observations)
    wanted = Hyperparameters.from_plain({**TINY, **NET, **own})
    run = train(Settings("sparse_circles", algorithm, 0, task, wanted), tmp_path / "run")
    policy = load_policy(run.folder)
    assert isinstance(policy, SavedPolicy)
    rows = [evaluate(policy, Worlds("sparse_circles", n, task=task).episodes, 5, "dev") for n in (1, 3)]
    assert rows[0] == rows[1]
    with pytest.raises(IrsimGymError, match="trained with observations"):
        evaluate(policy, Worlds("sparse_circles", 1).episodes, 1, "dev")


def test_weights_change_and_a_policy_acts_as_it_predicts(tmp_path: Path) -> None:
    task = written(tmp_path, PICTURE)
    env = sb3.make_vec_env("sparse_circles", 4, 0, task=task, render_mode=None)
    model = PPO("CnnPolicy", env, n_steps=32, batch_size=64, n_epochs=1, device="cpu", **NET)
    before = [weights.detach().clone() for weights in model.policy.parameters()]
    model.learn(256)
    after = list(model.policy.parameters())
    assert all((one != other).any() for one, other in zip(before, after, strict=True))
    env.seed(5)
    expected, _ = model.predict(env.reset(), deterministic=True)
    acted = SavedPolicy(model).act(env.worlds.episodes, np.arange(4))
    np.testing.assert_allclose(acted, expected, atol=1e-6)


def test_functions_of_what_is_seen(tmp_path: Path) -> None:
    seen: list[Any] = []

    def ahead(observation: Any) -> Any:
        seen.append(observation)
        rows = observation["vector"] if isinstance(observation, dict) else observation
        return np.tile([1.0, 0.0], (len(rows), 1))

    for observations in (PICTURE, BESIDE):
        episodes = Worlds("sparse_circles", 2, task=written(tmp_path, observations)).episodes
        assert len(evaluate(ahead, episodes, 2, "dev")) == 2
    assert seen[0].shape[1:] == (36, 36, 2)
    assert seen[0].dtype == np.uint8
    assert {name: rows.shape[1:] for name, rows in seen[-1].items()} == {"occupancy_image": (36, 36, 2), "vector": (4,)}


def test_networks_for_spaces() -> None:
    picture, numbers = Box(0, 255, (36, 36, 2), np.uint8), Box(-1, 1, (3,), np.float32)
    assert [network_kind(space) for space in (picture, numbers, Dict({"a": picture}))] == ["Cnn", "Mlp", "MultiInput"]
    given = {"features_extractor_kwargs": {"features_dim": 9}, "net_arch": [4]}
    assert dict_policy_arguments(given) == {"features_extractor_kwargs": {"cnn_output_dim": 9}, "net_arch": [4]}
    assert dict_policy_arguments({"net_arch": [4]}) == {"net_arch": [4]}


def test_pictures_have_hyperparameters_of_their_own(tmp_path: Path) -> None:
    looking = TrainingRequest("cluttered_room", "ppo", 0, None, "image_navigation", None).settings().hyperparameters
    feeling = TrainingRequest("cluttered_room", "ppo", 0, None, None, None).settings().hyperparameters
    assert looking == load_hyperparameters("ppo", "irsim_gym/cluttered_room-v0", images=True)
    assert looking.n_envs < feeling.n_envs
    assert looking.arguments["policy_kwargs"]["features_extractor_kwargs"] == {"features_dim": 128}
    named = written(tmp_path, BESIDE, "dict")
    sac = TrainingRequest("cluttered_room", "sac", 0, None, named, None).settings().hyperparameters
    assert sac.arguments["buffer_size"] <= 50_000
    memory = TrainingRequest("cluttered_room", "gru_ppo", 0, None, named, None).settings().hyperparameters
    assert memory == load_hyperparameters("gru_ppo", "irsim_gym/cluttered_room-v0", images=True)


def test_the_shipped_task_observes_one_picture() -> None:
    task = load_task(load_scenario("cluttered_room"), "image_navigation")
    assert [type(term).__name__ for term in task.observations] == ["OccupancyImage"]
    assert Worlds("cluttered_room", task="image_navigation").observation_space == Box(0, 255, (36, 36, 2), np.uint8)
    usual = load_task(load_scenario("cluttered_room"))
    assert (task.rewards, task.endings, task.max_steps) == (usual.rewards, usual.endings, usual.max_steps)


def test_demonstrations_hold_pictures(tmp_path: Path) -> None:
    task = written(tmp_path, BESIDE)
    found = record_demonstrations("sparse_circles", "dash", tmp_path / "shown.npz", 2, task=task)
    again = load_demonstrations(tmp_path / "shown.npz")
    assert isinstance(again.observations, dict)
    pictures = again.observations["occupancy_image"]
    assert (pictures.dtype, pictures.shape) == (np.uint8, (len(found), 36, 36, 2))
    assert (pictures[0] != pictures[-1]).any()
