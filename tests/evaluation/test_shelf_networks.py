"""What is exported acts as the model does, for every algorithm and network that can be exported."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import gymnasium
import numpy as np
import pytest
import sb3_contrib
import stable_baselines3
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from torch import nn

from irsim_gym.evaluation.saved_policies.array_network import apply_steps
from irsim_gym.evaluation.saved_policies.shelf import ShelfPolicy
from irsim_gym.training.export.exported_network import UnfitNetworkError, export_network

VECTOR = Box(-1.0, 2.0, (7,), np.float32)
PICTURE = Box(0, 255, (36, 40, 2), np.uint8)
STICK = Box(np.float32([-1.0, -2.0]), np.float32([1.0, 3.0]), dtype=np.float32)
CHOICES = Discrete(5)
TANH = {"policy_kwargs": {"net_arch": [16, 8], "activation_fn": nn.Tanh}}
SMALL = {"policy_kwargs": {"net_arch": [16]}}


class Still(gymnasium.Env[Any, Any]):
    """Spaces alone: nobody steps it but to fill the statistics of ``VecNormalize``."""

    def __init__(self, observation: Any, action: Any) -> None:
        self.observation_space, self.action_space = observation, action

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        return self.observation_space.sample(), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return self.observation_space.sample(), 0.0, False, False, {}


def made(kind: Callable[..., BaseAlgorithm], policy: str, observation: Any, action: Any, **options: Any) -> Any:
    """Return a model in which each weight counts: at first, biases are 0 and the last layer nearly so."""
    model = kind(policy, DummyVecEnv([lambda: Still(observation, action)]), seed=3, device="cpu", **deepcopy(options))
    for weights in model.policy.parameters():
        if weights.ndim < 3:
            bound = 0.3 if weights.shape[-1] < 100 else 0.05
            nn.init.uniform_(weights, -bound, bound)
    return model


def samples(space: Any, n: int) -> Any:
    space.seed(5)
    drawn = [space.sample() for _ in range(n)]
    return {name: np.stack([one[name] for one in drawn]) for name in space.spaces} if isinstance(space, Dict) else drawn


def exported(model: Any, normalization: VecNormalize | None = None) -> ShelfPolicy:
    found = export_network(model, normalization)
    return ShelfPolicy(found.form, found.arrays)


SB3, CONTRIB = stable_baselines3, sb3_contrib
BUFFER = {"buffer_size": 10}


@pytest.mark.parametrize(
    ("kind", "policy", "observation", "action", "options"),
    [
        (SB3.PPO, "MlpPolicy", VECTOR, STICK, TANH),
        (SB3.PPO, "MlpPolicy", VECTOR, CHOICES, SMALL),
        (SB3.PPO, "MlpPolicy", VECTOR, STICK, {**SMALL, "use_sde": True}),
        (SB3.A2C, "MultiInputPolicy", Dict({"a": VECTOR, "b": VECTOR}), STICK, SMALL),
        (SB3.A2C, "CnnPolicy", PICTURE, STICK, {}),
        (SB3.PPO, "MultiInputPolicy", Dict({"map": PICTURE, "vector": VECTOR}), CHOICES, {}),
        (SB3.SAC, "MlpPolicy", VECTOR, STICK, {**SMALL, **BUFFER}),
        (SB3.TD3, "MlpPolicy", VECTOR, STICK, {**TANH, **BUFFER}),
        (SB3.DQN, "MlpPolicy", VECTOR, CHOICES, {**SMALL, **BUFFER}),
        (CONTRIB.TQC, "MlpPolicy", VECTOR, STICK, {**SMALL, **BUFFER}),
    ],
)
def test_an_exported_policy_acts_as_its_model(
    kind: Any, policy: str, observation: Any, action: Any, options: dict[str, Any]
) -> None:
    model = made(kind, policy, observation, action, **options)
    shelf = exported(model)
    seen: Any = samples(observation, 32)
    seen = seen if isinstance(seen, dict) else np.stack(seen)
    expected, _ = model.predict(seen, deterministic=True)
    acted, state = shelf.predict(seen)
    assert state is None
    assert acted.dtype == expected.dtype
    assert len(np.unique(acted)) > 1
    np.testing.assert_allclose(acted, expected, atol=1e-6)
    first: Any = {name: rows[0] for name, rows in seen.items()} if isinstance(seen, dict) else seen[0]
    alone, _ = shelf.predict(first)
    assert alone.shape == model.predict(first, deterministic=True)[0].shape
    np.testing.assert_allclose(alone, acted[0], atol=1e-9)


@pytest.mark.parametrize("keys", [None, ["a"]])
def test_the_normalisation_is_part_of_the_policy(keys: list[str] | None) -> None:
    space: Any = VECTOR if keys is None else Dict({"a": VECTOR, "b": VECTOR})
    venv = VecNormalize(DummyVecEnv([lambda: Still(space, STICK)]), clip_obs=0.7, norm_obs_keys=keys)
    venv.reset()
    for _ in range(20):
        venv.step(np.zeros((1, 2), np.float32))
    venv.training = False
    model = SB3.PPO("MlpPolicy" if keys is None else "MultiInputPolicy", venv, seed=0, device="cpu")
    drawn = samples(space, 32)
    seen: Any = drawn if isinstance(drawn, dict) else np.stack(drawn)
    expected, _ = model.predict(venv.normalize_obs(seen), deterministic=True)
    np.testing.assert_allclose(exported(model, venv).predict(seen)[0], expected, atol=1e-6)
    assert np.abs(exported(model).predict(seen)[0] - expected).max() > 1e-3


@pytest.mark.parametrize("module", [nn.ReLU(), nn.Tanh(), nn.Sigmoid(), nn.SiLU(), nn.GELU(), nn.ELU(), nn.LeakyReLU()])
def test_activations(module: nn.Module) -> None:
    import torch

    from irsim_gym.training.export.exported_network import ACTIVATIONS

    values = np.linspace(-6.0, 6.0, 101)[:, None]
    step = ACTIVATIONS[type(module)](module)
    found: NDArray[Any] = apply_steps([step], [{}], values)
    np.testing.assert_allclose(found, module(torch.from_numpy(values)).numpy(), atol=1e-12)


def test_what_cannot_be_exported_is_refused() -> None:
    odd = made(SB3.PPO, "MlpPolicy", VECTOR, STICK, policy_kwargs={"activation_fn": nn.Softplus})
    with pytest.raises(UnfitNetworkError, match="Softplus cannot be exported"):
        export_network(odd, None)
