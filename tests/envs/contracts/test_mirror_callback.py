"""Learning from mirrored rows: which rows change, with whom it goes, and whom it refuses."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from gymnasium.wrappers import FilterObservation, FlattenObservation, NormalizeObservation, RescaleAction
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecNormalize, VecTransposeImage

from irsim_gym import sb3
from irsim_gym.errors import IrsimGymError

ROOM = "cluttered_room"
HOW: dict[str, Any] = {"n_steps": 16, "batch_size": 32, "n_epochs": 1, "seed": 0, "device": "cpu"}


class Keeps:
    """Keeps copies of the rollout before and after the callback, and learns nothing."""

    before: dict[str, Any]
    after: dict[str, Any]
    rollout_buffer: Any

    def train(self) -> None:
        self.after = contents(self.rollout_buffer)


class Kept(Keeps, PPO):
    """A PPO that keeps its rollouts."""


class KeptTeam(Keeps, sb3.MaskedPPO):
    """The same for teams."""


class Before(sb3.MirrorCallback):
    """Notes the rollout before it is mirrored."""

    def _on_rollout_end(self) -> None:
        self.model.before = contents(self.model.rollout_buffer)
        super()._on_rollout_end()


def contents(buffer: Any) -> dict[str, Any]:
    """Return copies of all arrays of a rollout."""
    seen = buffer.observations
    parts = seen if isinstance(seen, dict) else {"": seen}
    names = ("actions", "log_probs", "advantages", "returns", "values")
    return {key: part.copy() for key, part in parts.items()} | {name: getattr(buffer, name).copy() for name in names}


def weights(model: Any) -> torch.Tensor:
    """Return all weights."""
    return torch.cat([value.flatten() for value in model.policy.state_dict().values()])


def learned(env: Any, *callbacks: Any, kind: Any = PPO, steps: int = 256, **how: Any) -> Any:
    """Return the weights that a training ends with."""
    torch.manual_seed(0)
    model = kind(how.pop("policy", "MlpPolicy"), env, **{**HOW, **how})
    model.learn(steps, callback=list(callbacks))
    return weights(model)


def test_half_of_the_rows_are_mirrored_and_nothing_else_changes() -> None:
    env = sb3.make_vec_env(ROOM, 8, seed=0)
    model = Kept("MlpPolicy", env, **HOW)
    model.learn(128, callback=Before(seed=1))
    mirror = env.env_method("mirror")[0]
    before, after = model.before, model.after
    changed = (before[""] != after[""]).any(axis=-1)
    assert 0.3 < changed.mean() < 0.7
    np.testing.assert_array_equal(after[""][changed], mirror.observation(before[""][changed]))
    np.testing.assert_array_equal(after["actions"][changed], mirror.actions(before["actions"][changed]))
    np.testing.assert_array_equal(after["actions"][~changed], before["actions"][~changed])
    for name in ("log_probs", "advantages", "returns", "values"):
        np.testing.assert_array_equal(after[name], before[name])


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_no_row_and_every_row(share: float) -> None:
    env = sb3.make_vec_env(ROOM, 4, seed=0)
    model = Kept("MlpPolicy", env, **HOW)
    model.learn(64, callback=Before(share=share))
    assert (model.before[""] != model.after[""]).any(axis=-1).mean() == share


def test_without_mirrored_rows_the_weights_are_those_without_the_callback() -> None:
    plain, none, half = (
        learned(sb3.make_vec_env(ROOM, 8, seed=0), *callbacks)
        for callbacks in ([], [sb3.MirrorCallback(share=0.0)], [sb3.MirrorCallback()])
    )
    assert torch.equal(plain, none)
    assert not torch.equal(plain, half)


def test_single_environments_learn_what_a_batch_learns() -> None:
    batch = sb3.make_vec_env(ROOM, 2, seed=3)
    singles = DummyVecEnv([lambda: Monitor(gymnasium.make(f"irsim_gym/{ROOM}-v0"))] * 2)
    singles.seed(3)
    found = [learned(env, sb3.MirrorCallback(), batch_size=16) for env in (batch, singles)]
    assert torch.equal(*found)


def test_rows_of_teams_are_mirrored() -> None:
    env = sb3.make_multi_agent_vec_env("circle_swap", 2, seed=0, max_steps=20, n_robots=4)
    model = KeptTeam("MlpPolicy", env, **HOW)
    model.learn(256, callback=Before())
    check_rows(model, env)


def check_rows(model: Any, env: Any) -> None:
    """Compare the rows of the last rollout with mirrored ones; half of them are."""
    mirror, names = env.env_method("mirror")[0], ("actions", "log_probs", "advantages", "returns", "values")
    seen = [{key: part for key, part in one.items() if key not in names} for one in (model.before, model.after)]
    before, after = (next(iter(one.values())) if "" in one else one for one in seen)
    changed = (model.before["actions"] != model.after["actions"]).reshape(*model.after["values"].shape, -1).any(axis=-1)
    wanted, actions = mirror.observation(before), mirror.actions(model.before["actions"])
    for key in after if isinstance(after, dict) else [...]:
        np.testing.assert_array_equal(after[key][changed], wanted[key][changed])
    np.testing.assert_array_equal(model.after["actions"][changed], actions[changed])
    assert 0.2 < changed.mean() < 0.8


def test_choices_and_dicts() -> None:
    task = {"name": "discrete_navigation", "observation_form": "dict"}
    env = sb3.make_vec_env(ROOM, 8, seed=0, task=task)
    model = Kept("MultiInputPolicy", env, **HOW)
    model.learn(128, callback=Before())
    check_rows(model, env)


def test_images_are_mirrored_as_stable_baselines3_stores_them() -> None:
    task = {"observations": [{"name": "occupancy_image", "pixels": 36}, {"name": "goal"}]}
    env = VecTransposeImage(sb3.make_vec_env(ROOM, 2, seed=0, task={"name": "blank", **task}))
    model = Kept("MultiInputPolicy", env, **HOW)
    model.learn(32, callback=Before(share=1.0))
    before, after = model.before["occupancy_image"], model.after["occupancy_image"]
    assert before.shape == (16, 2, 2, 36, 36)
    np.testing.assert_array_equal(after, before[..., ::-1])
    np.testing.assert_array_equal(model.after["vector"], model.before["vector"] * [1, 1, -1, 1])


def test_a_mixture_of_scenarios_with_the_same_observations() -> None:
    env = sb3.MixtureVecEnv({name: sb3.make_vec_env(name, 4, seed=0) for name in (ROOM, "dense_room")})
    model = Kept("MlpPolicy", env, **HOW)
    model.learn(128, callback=Before())
    check_rows(model, env.parts[ROOM])


def refusals() -> dict[str, Any]:
    """Return what is refused, by message."""
    room = lambda: sb3.make_vec_env(ROOM, 2, seed=0)  # noqa: E731
    return {
        "only PPO .* got SAC": lambda: SAC("MlpPolicy", room(), device="cpu"),
        "without memory .* got GruPPO": lambda: sb3.GruPPO("MlpGruPolicy", room(), **HOW),
        "clip_range_vf would compare": lambda: PPO("MlpPolicy", room(), clip_range_vf=0.2, **HOW),
        "target_kl would stop updates": lambda: PPO("MlpPolicy", room(), target_kl=0.02, **HOW),
        "that VecNormalize normalises": lambda: PPO("MlpPolicy", VecNormalize(room()), **HOW),
        "a wrapper changes parts": lambda: PPO("MlpPolicy", VecFrameStack(room(), 2), **HOW),
        "parts, shapes or bounds of obs": lambda: PPO(
            "MultiInputPolicy", wrapped(lambda env: FilterObservation(env, ["scan"]), "dict"), **HOW
        ),
        "shapes or bounds of observations": lambda: PPO("MlpPolicy", wrapped(FlattenObservation, "dict"), **HOW),
        "bounds of observations, so": lambda: PPO("MlpPolicy", wrapped(NormalizeObservation), **HOW),
        "changes the space of actions": lambda: PPO(
            "MlpPolicy", wrapped(lambda env: RescaleAction(env, 0.0, 1.0)), **HOW
        ),
        "need an environment of irsim_gym": lambda: PPO("MlpPolicy", make_vec_env("Pendulum-v1", 2), **HOW),
        "in the frame of the world": lambda: PPO(
            "MlpPolicy", sb3.make_vec_env(ROOM, 2, task={"name": "blank", "observations": ["scan", "heading"]}), **HOW
        ),
        "slots that observe and act alike": lambda: PPO(
            "MlpPolicy", DummyVecEnv([lambda: made(HEADING), lambda: made(RECORD)]), **HOW
        ),
    }


def wrapped(wrapper: Any, form: str = "flat") -> Any:
    """Return an environment in a wrapper of Gymnasium."""
    task = {"name": "navigation", "observation_form": form}
    return DummyVecEnv([lambda: wrapper(gymnasium.make(f"irsim_gym/{ROOM}-v0", task=task))] * 2)


def made(task: Any) -> gymnasium.Env:
    """Return a single environment."""
    return gymnasium.make(f"irsim_gym/{ROOM}-v0", task=task)


HEADING, RECORD = ({"name": "blank", "observations": [one]} for one in ("goal_heading", "goal_record"))


@pytest.mark.filterwarnings("ignore:.*precision lowered")
@pytest.mark.parametrize("message", refusals())
def test_refused(message: str) -> None:
    with pytest.raises(IrsimGymError, match=message):
        refusals()[message]().learn(32, callback=sb3.MirrorCallback())


def test_rewards_may_be_normalised() -> None:
    env = VecNormalize(sb3.make_vec_env(ROOM, 8, seed=0), norm_obs=False)
    model = Kept("MlpPolicy", env, **HOW)
    model.learn(128, callback=Before())
    check_rows(model, env)


@pytest.mark.parametrize("share", [-0.1, 1.5])
def test_share_is_a_share(share: float) -> None:
    with pytest.raises(ValueError, match="from 0 to 1"):
        sb3.MirrorCallback(share=share)


def test_a_seed_is_not_negative() -> None:
    with pytest.raises(ValueError, match="seed must be >= 0"):
        sb3.MirrorCallback(seed=-1)
