"""A critic that sees more than the actor: trained, resumed, cloned and exported, it drives without what only it saw."""

from __future__ import annotations

import io
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import stable_baselines3
import torch
import yaml
from gymnasium.spaces import Box, Dict
from rich.console import Console
from stable_baselines3.common.vec_env import DummyVecEnv

from irsim_gym import sb3
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.protocol import evaluate
from irsim_gym.training.cloning import clone_behavior
from irsim_gym.training.episode_setup import make_episodes
from irsim_gym.training.exported_network import export_network
from irsim_gym.training.hyperparameters import Hyperparameters
from irsim_gym.training.interruption import TrainingInterruptedError
from irsim_gym.training.models import new_model
from irsim_gym.training.policies import SavedPolicy, load_policy
from irsim_gym.training.run import Run, Settings
from irsim_gym.training.shelf import ShelfPolicy
from irsim_gym.training.train import train
from irsim_gym.training.training_request import TrainingRequest

QUIET = Console(file=io.StringIO())
PPO: dict[str, Any] = {
    "n_timesteps": 512, "n_envs": 8, "n_steps": 16, "batch_size": 64, "n_epochs": 2, "checkpoint_every": 256,
    "policy_kwargs": {"net_arch": [16]},
}  # fmt: skip
CRITIC: list[Any] = ["route", {"name": "nearest_bodies", "count": 2}, "own_body"]


class OneStep(gymnasium.Env[Any, Any]):
    """Pays what the critic alone sees, -1 or 1, whatever is done; each episode has one step."""

    observation_space = Dict({"vector": Box(-1, 1, (1,)), "critic": Box(-1, 1, (1,))})
    action_space = Box(-1, 1, (1,))

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.shown = self.np_random.choice([-1.0, 1.0])
        return self._seen(), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return self._seen(), self.shown, True, False, {}

    def _seen(self) -> dict[str, Any]:
        return {"vector": np.zeros(1, np.float32), "critic": np.full(1, self.shown, np.float32)}


@pytest.fixture
def task(tmp_path: Path) -> str:
    path = tmp_path / "sees_more.yaml"
    path.write_text(yaml.safe_dump({"name": "navigation", "max_steps": 60, "critic_observations": CRITIC}))
    return str(path)


def settings(task: str, algorithm: str = "ppo", scenario: str = "cluttered_room", **own: Any) -> Settings:
    return Settings(scenario, algorithm, 3, task, Hyperparameters.from_plain({**PPO, **own}))


def interrupted(asked: Settings, folder: Path, interrupt: Callable[[int, int], None]) -> Run:
    """Train, with an interruption in the midst of it."""
    interrupt(200, signal.SIGINT)
    with pytest.raises(TrainingInterruptedError):
        train(asked, folder, console=QUIET)
    torch.manual_seed(99)
    return train(asked, folder, resume=True, console=QUIET)


def weights(run: Run) -> torch.Tensor:
    loaded = load_policy(run.policy)
    assert isinstance(loaded, SavedPolicy)
    model: Any = loaded.model
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


@pytest.mark.parametrize(
    ("scenario", "own"),
    [
        ("cluttered_room", {}),
        ("cluttered_room", {"normalize": True}),
        ("random_swap", {"team": "episode", "normalize": True}),
    ],
)
def test_a_resumed_run_equals_an_uninterrupted_one(
    task: str, scenario: str, own: dict[str, Any], tmp_path: Path, interrupt: Callable[[int, int], None]
) -> None:
    asked = settings(task, scenario=scenario, **own)
    whole = train(asked, tmp_path / "whole", console=QUIET)
    assert torch.equal(weights(whole), weights(interrupted(asked, tmp_path / "parts", interrupt)))


@pytest.mark.parametrize("own", [{}, {"normalize": True}])
def test_a_saved_policy_drives_without_what_the_critic_saw(task: str, own: dict[str, Any], tmp_path: Path) -> None:
    """The same actions bit for bit from whole observations and the actor's alone, and with a blind critic."""
    run = train(settings(task, **own), tmp_path / "run", console=QUIET)
    policy = load_policy(run.folder)
    assert (isinstance(policy, SavedPolicy) and policy.normalization is not None) or not own
    model: Any = policy.model
    env = sb3.make_vec_env("cluttered_room", 64, seed=0, task=task, critic=True)
    seen = env.reset()
    plain = sb3.make_vec_env("cluttered_room", 64, seed=0).reset()
    if policy.normalization is None:
        whole = model.predict(seen, deterministic=True)[0]
        np.testing.assert_array_equal(whole, model.predict(plain, deterministic=True)[0])
        np.testing.assert_array_equal(whole, model.predict({"vector": plain}, deterministic=True)[0])
        np.testing.assert_allclose(whole[0], model.predict(plain[0], deterministic=True)[0], atol=1e-6)
    rows = evaluate(policy, make_episodes("cluttered_room", n_worlds=20), 20, "dev")
    for name, part in model.policy.named_parameters():
        if "vf" in name or "value" in name:
            part.data.fill_(np.nan)
    blind = evaluate(policy, make_episodes("cluttered_room", n_worlds=20), 20, "dev")
    assert str(rows) == str(blind)


@pytest.mark.parametrize("own", [{}, {"normalize": True}])
def test_it_goes_onto_the_shelf_as_any_other(task: str, own: dict[str, Any], tmp_path: Path) -> None:
    policy = load_policy(train(settings(task, **own), tmp_path / "run", console=QUIET).folder)
    assert isinstance(policy, SavedPolicy)
    exported = export_network(policy.model, policy.normalization)  # type: ignore[arg-type]
    shelf = ShelfPolicy(exported.form, exported.arrays)
    episodes = make_episodes("cluttered_room", n_worlds=8)
    SavedPolicy(shelf).check(episodes)
    assert shelf.observation_space.shape == (88,)
    worlds = np.arange(8)
    policy.begin(episodes, worlds, worlds)
    episodes.begin(worlds, worlds, "dev")
    np.testing.assert_allclose(SavedPolicy(shelf).act(episodes, worlds), policy.act(episodes, worlds), atol=2e-6)


def test_the_critic_learns_what_only_it_can_see() -> None:
    """The reward is what the critic sees, at random, in episodes of one step: a value without it would be a mean."""
    env = DummyVecEnv([OneStep] * 16)
    env.seed(0)
    model = stable_baselines3.PPO(
        sb3.AsymmetricPolicy, env, n_steps=32, batch_size=128, learning_rate=1e-2, gamma=0.9, seed=0
    )
    model.learn(16 * 32 * 12)
    shown = {"vector": torch.zeros(2, 1), "critic": torch.tensor([[-1.0], [1.0]])}
    values = model.policy.predict_values(shown).detach()[:, 0].tolist()
    np.testing.assert_allclose(values, [-1.0, 1.0], atol=0.15)


def test_an_actor_imitates_what_it_sees(task: str) -> None:
    wanted = settings(task, clone="dash", clone_levels=40, clone_epochs=4)
    model = new_model(wanted)
    before = {name: part.clone() for name, part in model.policy.named_parameters()}
    clone_behavior(model, wanted, QUIET)
    changed = {name for name, part in model.policy.named_parameters() if not torch.equal(part, before[name])}
    actor = {name for name in before if name.startswith(("mlp_extractor.policy_net", "action_net"))}
    assert changed == actor
    assert len(actor) == 4  # weights and biases of two layers


def test_an_algorithm_without_such_a_critic_is_refused(task: str) -> None:
    with pytest.raises(IrsimGymError, match=r"sac has no critic that may see more.*ppo, a2c"):
        TrainingRequest("cluttered_room", "sac", task=task).settings()
    with pytest.raises(IrsimGymError, match="share_features_extractor must be false"):
        new_model(settings(task, policy_kwargs={"share_features_extractor": True}))
