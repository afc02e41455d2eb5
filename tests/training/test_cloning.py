"""An actor that imitates a policy before it learns: what it imitates, how well, and what it refuses."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from irsim_gym.training.runs.cloning import clone_behavior, demonstrations, imitate
from irsim_gym.training.runs.models import new_model
from rich.console import Console

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.requests.episode_setup import make_episodes
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.training.requests.train import train
from irsim_gym.training.settings.hyperparameters import Hyperparameters
from irsim_gym.training.settings.run import Settings

QUIET = Console(file=io.StringIO())
PPO: dict[str, Any] = {
    "n_timesteps": 256, "n_envs": 8, "n_steps": 32, "batch_size": 256,
    "clone": "dash", "clone_levels": 60, "policy_kwargs": {"net_arch": [32, 32], "log_std_init": -1.0},
}  # fmt: skip


def settings(scenario: str = "empty_goal", *, algorithm: str = "ppo", task: str | None = None, **own: Any) -> Settings:
    return Settings(scenario, algorithm, 3, task, Hyperparameters.from_plain({**PPO, **own}))


def test_it_plays_levels_of_its_own_part_of_train_and_keeps_what_won() -> None:
    """In the cluttered room ``dash`` wins some levels; played one by one, they have as many steps as there are rows."""
    wanted = settings("cluttered_room", clone_levels=30)
    seen, done = demonstrations(wanted, "dash", QUIET)
    levels = range(wanted.first_level, wanted.first_level + 30)
    rows = evaluate(load_policy("dash"), make_episodes("cluttered_room"), levels, "train")
    won = [row for row in rows if row.outcome == "success"]
    assert 0 < len(won) < 30
    assert len(seen) == len(done) == sum(row.steps for row in won)
    env = irsim_gym.make("cluttered_room")
    firsts = [env.reset(options={"split": "train", "level": row.level})[0] for row in won]
    assert all((seen == first).all(axis=1).any() for first in firsts)


def test_what_was_cloned_drives_as_well() -> None:
    model = new_model(settings(clone_epochs=30))
    seconds, cpu_seconds = clone_behavior(model, settings(clone_epochs=30), QUIET)
    assert min(seconds, cpu_seconds) > 0.0
    rows = evaluate(SavedPolicy(model), make_episodes("empty_goal", n_worlds=50), 50, "dev")
    assert sum(row.outcome == "success" for row in rows) >= 45  # a fresh one reaches none
    assert model.policy.log_std.tolist() == [-1.0, -1.0]


def test_choices_are_imitated_by_their_probability() -> None:
    """Two situations, two choices: after imitating, each is chosen nearly always."""
    wanted = settings(task="discrete_navigation", policy_kwargs={"net_arch": [16]})
    model = new_model(wanted)
    width = model.observation_space.shape
    assert width is not None
    seen = np.repeat([np.full(width, -1.0, np.float32), np.ones(width, np.float32)], 5000, axis=0)
    done = np.repeat([2, 7], 5000)
    imitate(model, seen, done, 60, QUIET)
    rows, _ = model.policy.obs_to_tensor(seen[[0, -1]])
    chances = model.policy.get_distribution(rows).distribution.probs  # type: ignore[attr-defined]
    assert chances[0, 2] > 0.8
    assert chances[1, 7] > 0.8


def test_networks_of_the_critic_stay_and_a_shared_extractor_learns(tmp_path: Any) -> None:
    """Actor and critic share the one that reads pictures."""
    file = tmp_path / "looks.yaml"
    file.write_text(
        "{name: blank, observations: [{name: occupancy_image, pixels: 36}], rewards: [progress], endings: [arrived]}"
    )
    net = {"features_extractor_kwargs": {"features_dim": 8}, "net_arch": [8]}
    model = new_model(settings("sparse_circles", task=str(file), policy_kwargs=net))
    before = {name: part.clone() for name, part in model.policy.named_parameters()}
    random = np.random.default_rng(0)
    seen = random.integers(0, 256, (64, *(model.observation_space.shape or ())), np.uint8)
    imitate(model, seen, random.uniform(-1.0, 1.0, (64, 2)).astype(np.float32), 3, QUIET)
    same = {name for name, part in model.policy.named_parameters() if torch.equal(part, before[name])}
    critic = ("mlp_extractor.value_net.0", "value_net")
    assert same == {"log_std", *(f"{layer}.{part}" for layer in critic for part in ("weight", "bias"))}


def test_the_time_of_a_run_counts_the_imitation(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The imitation is said to take 1,000 s, and 2,000 s of the processor."""
    monkeypatch.setattr("irsim_gym.training.requests.train.clone_behavior", lambda *_: (1000.0, 2000.0))
    run = train(settings(), tmp_path, console=QUIET)
    progress = load_progress(list_checkpoints(run.checkpoints)[-1])
    assert 1000.0 < progress.training_seconds < 1500.0
    assert 2000.0 < progress.cpu_seconds < 2500.0


def test_the_same_seed_clones_the_same(tmp_path: Any) -> None:
    """A whole run with a clone, twice: bit for bit."""
    wanted = settings(clone_levels=20, clone_epochs=2)
    first, second = (train(wanted, tmp_path / name, console=QUIET) for name in "ab")
    loaded = [torch.load(_weights(run), weights_only=True) for run in (first, second)]
    assert all(torch.equal(loaded[0][name], loaded[1][name]) for name in loaded[0])


def _weights(run: Any) -> Any:
    import zipfile

    with zipfile.ZipFile(run.policy) as archive:
        return io.BytesIO(archive.read("policy.pth"))


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (settings(normalize={"norm_obs": True}), "statistics of normalize would change"),
        (settings(clone="nobody"), "no policy named 'nobody'"),
        (settings("cluttered_room", clone="random", clone_levels=3), "random wins none of 3 levels"),
    ],
)
def test_what_cannot_be_cloned_is_told(wanted: Settings, said: str) -> None:
    with pytest.raises(IrsimGymError, match=said):
        clone_behavior(new_model(wanted), wanted, QUIET)


def test_algorithms_without_an_actor_of_ppo_cannot_imitate() -> None:
    own = {key: value for key, value in PPO.items() if key.startswith(("n_timesteps", "n_envs", "clone"))}
    wanted = replace(settings(algorithm="sac"), hyperparameters=Hyperparameters.from_plain({**own, "buffer_size": 100}))
    with pytest.raises(IrsimGymError, match="sac has no actor that can: use ppo or a2c"):
        clone_behavior(new_model(wanted), wanted, QUIET)
