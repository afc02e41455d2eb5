"""A policy of one's own, whatever it is made with, is judged on the same levels as everybody's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from stable_baselines3 import A2C, DQN, PPO, SAC, TD3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.saved_policies.policies import SavedPolicy, load_policy, policy_names

PLAIN = "empty_goal"
DICT = {"name": "navigation", "observation_form": "dict"}
STEPS = {"name": "navigation", "action": {"name": "discrete"}}


def bearing(observation: dict[str, Any]) -> Any:
    """Drive at the goal: its distance, and the cosine and sine of its bearing are observed."""
    return observation["goal"][:, 1:3]


def test_a_function_is_compared_with_the_references() -> None:
    found = irsim_gym.evaluate(PLAIN, {"mine": bearing}, levels=20, task=DICT)
    assert list(found.rows) == ["mine", "random", "dash"]
    assert [summary.episodes for summary in found.summaries] == [20, 20, 20]
    assert found.summaries[0].success.value == 1.0
    assert "mine" in str(found)
    assert "20 test levels" in str(found)


def test_a_list_behind_a_name_is_one_method() -> None:
    """Its policies have rows of their own; the table of the worst levels has one for all of them."""
    found = irsim_gym.evaluate(PLAIN, {"two": ["dash", "random"], "dash": "dash"}, levels=4, references=False)
    assert (list(found.rows), found.seeds) == (["two-1", "two-2", "dash"], {"two": ["two-1", "two-2"]})
    assert [row.outcome for row in found.rows["two-1"]] == ["success"] * 4
    # dash solves all levels, so its worst one is level 0; random solves none: half of 0 and 1
    assert {name: shares["5 %"] for name, shares in found.worst.items()} == {
        "two-1": 1.0, "two-2": 0.0, "dash": 1.0, "two": 0.5,
    }  # fmt: skip
    assert "two (2 policies)" in str(found)
    with pytest.raises(IrsimGymError, match="the method 'none' has no policies"):
        irsim_gym.evaluate(PLAIN, {"none": []}, levels=1)
    with pytest.raises(IrsimGymError, match="two policies are named 'a-1'"):
        irsim_gym.evaluate(PLAIN, {"a": ["dash", "random"], "a-1": "dash"}, levels=1)


def test_a_function_acts_as_in_a_loop_of_ones_own() -> None:
    (row,) = irsim_gym.evaluate(PLAIN, bearing, levels=1, task=DICT, references=False).rows["bearing"]
    env = irsim_gym.make(PLAIN, task=DICT)
    observation, _ = env.reset(options={"level": 0, "split": "test"})
    done, steps = False, 0
    while not done:
        batch = {name: values[None] for name, values in observation.items()}
        observation, _, terminated, truncated, info = env.step(bearing(batch)[0])
        done, steps = terminated or truncated, steps + 1
    assert (row.steps, row.path_length) == (steps, pytest.approx(info["path_length"]))


def test_teams_and_names() -> None:
    found = irsim_gym.evaluate(
        "circle_swap",
        [bearing, "dash"],
        levels=3,
        task={"name": "team_navigation", "observation_form": "dict"},
        team=True,
        references=False,
        parameters={"n_robots": 3},
    )
    assert list(found.rows) == ["bearing", "dash"]
    assert "3 agents, 3 test levels" in str(found)


@pytest.mark.parametrize(
    ("algorithm", "task", "given"),
    [
        (TD3, None, {"buffer_size": 10}),
        (SAC, None, {"buffer_size": 10}),
        (DQN, STEPS, {"buffer_size": 10}),
        (PPO, None, {"n_steps": 8, "batch_size": 8}),
        (A2C, None, {}),
    ],
)
def test_a_model_is_judged_as_its_file_is(
    algorithm: type[BaseAlgorithm], task: Any, given: dict[str, Any], tmp_path: Any
) -> None:
    env = irsim_gym.make(PLAIN, task=task, max_steps=20)
    model = algorithm("MlpPolicy", env, device="cpu", seed=0, policy_kwargs={"net_arch": [8]}, **given)
    model.save(tmp_path / "model.zip")
    loaded = load_policy(tmp_path / "model.zip")
    assert isinstance(loaded, SavedPolicy)
    assert type(loaded.model) is algorithm
    sources = [model, tmp_path / "model.zip"]
    limited = {**(task or {"name": "navigation"}), "max_steps": 20}
    rows = irsim_gym.evaluate(PLAIN, sources, levels=3, task=limited, references=False).rows
    assert rows[algorithm.__name__.lower()] == rows["model"]


def test_a_models_normalisation_comes_along_and_learns_nothing() -> None:
    worlds = irsim_gym.sb3.make_vec_env(PLAIN, 2, seed=0, max_steps=20)
    env = VecNormalize(worlds)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=16, n_epochs=1, device="cpu", seed=0)
    model.learn(16)
    before = env.obs_rms.mean.copy()
    policy = load_policy(model)
    assert isinstance(policy, SavedPolicy)
    acted = policy.act(worlds.worlds.episodes, np.arange(2))
    expected, _ = model.predict(env.normalize_obs(env.unnormalize_obs(model._last_obs)), deterministic=True)
    np.testing.assert_allclose(acted, expected, atol=1e-5)
    np.testing.assert_array_equal(env.obs_rms.mean, before)
    assert policy.normalization is not None
    assert not policy.normalization.training


def test_what_is_no_policy_is_told() -> None:
    with pytest.raises(IrsimGymError, match=r"no policy named 'dsh' \(did you mean 'dash'\?\)\n  behaviors: "):
        irsim_gym.evaluate(PLAIN, "dsh")
    with pytest.raises(TypeError, match="a policy is a function, a model, a file or a name, got int"):
        load_policy(5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="levels must be >= 1, got 0"):
        irsim_gym.evaluate(PLAIN, "dash", levels=0)


def test_names_of_what_has_no_file() -> None:
    assert policy_names([bearing, "dash", bearing]) == ["bearing-1", "dash", "bearing-2"]
