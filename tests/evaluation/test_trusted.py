"""Loading a policy runs no code that is in its file, or says that it does."""

from __future__ import annotations

import base64
import json
import pickle
import shutil
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.noise import NormalActionNoise
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.common.vec_env import VecNormalize

import irsim_gym
from irsim_gym import sb3
from irsim_gym.errors import UnreadableFileError, UntrustedCodeWarning
from irsim_gym.evaluation.saved_policies.checkpoint_files import NORMALIZATION
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy
from irsim_gym.evaluation.saved_policies.trusted import SERIALIZED, harmless_objects

POLICIES = Path(__file__).parents[2] / "agents" / "policies"
TINY = {"net_arch": [4], "activation_fn": torch.nn.Tanh}
CONTINUOUS = {"name": "navigation"}
DISCRETE = {"name": "navigation", "action": "discrete"}


class Mischief:
    """Unpickling it leaves a mark, as it might run any command."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.mark,)


class MyExtractor(FlattenExtractor):
    """An extractor that is nobody's but the user's."""


def with_object(file: Path, out: Path, key: str, value: Any) -> Path:
    """Copy a policy's file with another pickled object under a key."""
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "data":
                data = json.loads(content)
                data[key] = {":type:": "", SERIALIZED: base64.b64encode(pickle.dumps(value)).decode()}
                content = json.dumps(data).encode()
            new.writestr(name, content)
    return out


@pytest.mark.parametrize("file", sorted(POLICIES.glob("*.zip")), ids=lambda file: file.stem)
def test_shipped_policies_hold_weights_and_harmless_objects(file: Path) -> None:
    """Warnings are errors here: all that is needed to drive is made without code of the file's."""
    objects = harmless_objects(file)
    assert {"observation_space", "action_space", "policy_class"} <= objects.keys()
    assert isinstance(load_policy(file), SavedPolicy)


def test_code_in_a_shipped_policy_would_not_run(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    changed = with_object(POLICIES / "cluttered_room_seed_0.zip", tmp_path / "p.zip", "lr_schedule", Mischief(mark))
    load_policy(changed)
    assert not mark.exists()
    with pytest.warns(DeprecationWarning, match=r"Linear is now irsim_gym\.training\.Linear"):
        PPO.load(changed, device="cpu")  # what the file does elsewhere
    assert mark.exists()


def test_code_that_is_needed_to_drive_is_told(tmp_path: Path) -> None:
    shipped, mark = POLICIES / "cluttered_room_seed_0.zip", tmp_path / "mark"
    changed = with_object(shipped, tmp_path / "p.zip", "policy_kwargs", {"some": Mischief(mark)})
    with pytest.warns(UntrustedCodeWarning, match=r"p\.zip holds Python objects .*policy_kwargs .*SECURITY\.md"):
        harmless_objects(changed)
    assert not mark.exists()


def test_a_policy_with_a_class_of_the_users_is_loaded_and_told(tmp_path: Path) -> None:
    env = irsim_gym.make("empty_goal", task=CONTINUOUS)
    model = PPO("MlpPolicy", env, device="cpu", policy_kwargs=TINY | {"features_extractor_class": MyExtractor})
    model.save(tmp_path / "mine.zip")
    with pytest.warns(UntrustedCodeWarning, match="MyExtractor"):
        loaded = load_policy(tmp_path / "mine.zip")
    assert isinstance(loaded, SavedPolicy)
    assert type(loaded.model.policy.features_extractor).__name__ == "MyExtractor"


@pytest.mark.parametrize(
    ("kind", "task", "options"),
    [
        (PPO, CONTINUOUS, {"n_steps": 8, "batch_size": 8, "learning_rate": lambda left: 1e-3 * left}),
        (A2C, CONTINUOUS, {"n_steps": 8}),
        (SAC, CONTINUOUS, {"buffer_size": 32, "learning_starts": 8}),
        (TD3, CONTINUOUS, {"buffer_size": 32, "action_noise": NormalActionNoise(np.zeros(2), np.ones(2))}),
        (DQN, DISCRETE, {"buffer_size": 32, "learning_starts": 8}),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
def test_ordinary_files_of_each_algorithm_load_without_a_word(
    tmp_path: Path, kind: Any, task: Any, options: dict[str, Any]
) -> None:
    env = irsim_gym.make("empty_goal", task=task)
    kwargs = {"net_arch": [4]} if kind is DQN else dict(TINY)  # the algorithm adds to it
    model = kind("MlpPolicy", env, device="cpu", policy_kwargs=kwargs, seed=0, **options)
    model.learn(16)
    model.save(tmp_path / "model.zip")
    seen = np.stack([env.observation_space.sample() for _ in range(5)])
    loaded = load_policy(tmp_path / "model.zip")
    assert isinstance(loaded, SavedPolicy)
    np.testing.assert_array_equal(
        loaded.model.predict(seen, deterministic=True)[0], model.predict(seen, None, None, True)[0]
    )


def test_statistics_beside_a_policy_are_read_without_code(tmp_path: Path) -> None:
    env = VecNormalize(sb3.make_vec_env("empty_goal", 2, 0))
    env.reset()
    shutil.copy(POLICIES / "cluttered_room_seed_0.zip", tmp_path / "policy.zip")
    env.save(str(tmp_path / NORMALIZATION))
    loaded = load_policy(tmp_path / "policy.zip")
    assert isinstance(loaded, SavedPolicy)
    assert loaded.normalization is not None
    np.testing.assert_array_equal(loaded.normalization.obs_rms.mean, env.obs_rms.mean)
    (tmp_path / NORMALIZATION).write_bytes(pickle.dumps(Mischief(tmp_path / "mark")))
    with pytest.warns(UntrustedCodeWarning, match=NORMALIZATION), pytest.raises(UnreadableFileError):
        load_policy(tmp_path / "policy.zip")


def test_it_is_said_once(tmp_path: Path) -> None:
    changed = with_object(
        POLICIES / "cluttered_room_seed_0.zip", tmp_path / "p.zip", "policy_kwargs", {"x": Mischief(tmp_path / "mark")}
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for _ in range(3):
            harmless_objects(changed)
    assert len(caught) == 1
