"""The single environment."""

from __future__ import annotations

from copy import deepcopy

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import irsim_gym
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.tasks import Outcome

REST = np.zeros(2, np.float32)


def test_types_of_a_step():
    env = WorldEnv("sparse_circles")
    observation, info = env.reset(seed=0)
    assert observation.dtype == np.float32
    result = env.step(REST)
    assert [type(value) for value in result[1:]] == [float, bool, bool, dict]
    whole = {"outcome", "hit", "hit_kind", "steps", "level"}
    real = {"path_length", "min_clearance", "goal_distance", "stalled"}
    keys = whole | real | {"is_success", "deadlocked"}
    terms = {f"reward/{name}" for name in env.worlds.episodes.reward_names}
    assert info.keys() == result[4].keys() == keys | terms
    types = {key: type(value) for key, value in result[4].items()}
    assert {types[key] for key in whole} == {int}
    assert {types[key] for key in real | terms} == {float}
    assert types["is_success"] is types["deadlocked"] is bool


def test_infos_in_numpy():
    """What readers that ask each value for its dtype need; Gymnasium's batches of them equal ours, types included."""
    plain, numpy = WorldEnv("sparse_circles"), WorldEnv("sparse_circles", numpy_infos=True)
    told, wanted = (env.reset(seed=3)[1] for env in (numpy, plain))
    told_then, wanted_then = (env.step(np.ones(2, np.float32))[4] for env in (numpy, plain))
    for info, python in ((told, wanted), (told_then, wanted_then)):
        assert {key: value.item() for key, value in info.items()} == python
        assert {key: value.dtype for key, value in info.items()} == {k: np.asarray(v).dtype for k, v in python.items()}
        assert {type(value) for value in info.values()} == {np.float64, np.int64, np.ndarray}
    single = gymnasium.vector.SyncVectorEnv([lambda: WorldEnv("sparse_circles", numpy_infos=True)] * 2)
    batch = irsim_gym.make_vec("sparse_circles", 2)
    told, wanted = single.reset(seed=3)[1], batch.reset(seed=3)[1]
    assert told.keys() == wanted.keys()
    for key, values in wanted.items():
        np.testing.assert_array_equal(told[key], values, strict=True)
    assert deepcopy(numpy).step(REST)[4] == numpy.step(REST)[4]


def test_reward_is_the_sum_of_its_terms():
    env = WorldEnv("sparse_circles", max_steps=50)
    env.reset(seed=0)
    for _ in range(50):
        _, reward, terminated, truncated, info = env.step(np.array([1.0, 0.1], np.float32))
        assert reward == pytest.approx(sum(info[key] for key in info if key.startswith("reward/")), abs=1e-12)
        if terminated or truncated:
            break
    assert info["outcome"] != Outcome.RUNNING


def test_time_limit_truncates():
    env = WorldEnv("sparse_circles", max_steps=3)
    env.reset(seed=0)
    *_, terminated, truncated, info = [env.step(REST) for _ in range(3)][-1]
    assert (terminated, truncated, info["outcome"], info["is_success"]) == (False, True, Outcome.TIMEOUT, False)


def test_stepping_needs_a_reset():
    env = WorldEnv("sparse_circles", max_steps=1)
    with pytest.raises(ResetNeeded):
        env.step(REST)
    env.reset(seed=0)
    env.step(REST)
    with pytest.raises(ResetNeeded):
        env.step(REST)
    env.reset()
    env.step(REST)


@pytest.mark.parametrize("action", [0.0, np.zeros(1), np.zeros(3), np.zeros((1, 2)), [np.nan, 0.0], [np.inf, 0.0]])
def test_bad_actions(action):
    env = WorldEnv("sparse_circles")
    env.reset(seed=0)
    with pytest.raises(ValueError):
        env.step(action)


def test_levels():
    env = WorldEnv("sparse_circles")
    first, info = env.reset(seed=4)
    assert info["level"] == 4
    second, info = env.reset()
    assert info["level"] >= 2**52
    np.testing.assert_array_equal(env.reset(seed=4)[0], first)
    np.testing.assert_array_equal(env.reset()[0], second)
    kept, info = env.reset(options={"split": "test", "level": 4})
    assert info["level"] == 4
    assert (kept != first).any()
    np.testing.assert_array_equal(env.reset(seed=4, options={"split": "test"})[0], kept)
    following, _ = env.reset()
    env.reset(options={"split": "test", "level": 4})
    np.testing.assert_array_equal(env.reset()[0], following)
    np.testing.assert_array_equal(env.reset(seed=4)[0], first)


def test_a_reset_without_options_goes_on_in_the_split_of_the_one_before():
    env = WorldEnv("sparse_circles")
    env.reset(seed=3)
    assert env.reset(options={"split": "test"})[1]["level"] < 2**52
    _, info = env.reset()
    assert info["level"] >= 2**52, "the level that follows, not the first one of another chain"
    env.reset(options={"split": "test", "level": 4})
    second, _ = env.reset()
    third, _ = env.reset()
    env.reset(options={"split": "test", "level": 4})
    np.testing.assert_array_equal(env.reset(options={"split": "test"})[0], second)
    np.testing.assert_array_equal(env.reset()[0], third)
    env.reset(options={"level": 4})
    assert (env.reset()[0] != second).any(), "a level alone is one of the train split"


def test_a_new_split_without_level_draws_from_np_random():
    env = WorldEnv("sparse_circles")
    levels = []
    for _ in range(2):
        env.reset(seed=1)
        levels.append(env.reset(options={"split": "dev"})[1]["level"])
    assert levels[0] == levels[1]


def test_unseeded_reset_draws_from_np_random():
    levels = []
    for _ in range(2):
        env = WorldEnv("sparse_circles")
        env.np_random = np.random.default_rng(7)
        levels.append(env.reset()[1]["level"])
    assert levels[0] == levels[1] < 2**52
    assert WorldEnv("sparse_circles").reset()[1]["level"] != levels[0]


@pytest.mark.parametrize("seed", [2**52, 2**52 + 5, 2**70])
def test_large_seeds_are_folded(seed):
    env = WorldEnv("sparse_circles")
    assert env.reset(seed=seed)[1]["level"] == seed % 2**52


def test_the_last_level_that_an_option_may_name():
    assert WorldEnv("sparse_circles").reset(options={"level": 2**53 - 1})[1]["level"] == 2**53 - 1


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"split": "tset"}, UnknownNameError),
        ({"lvl": 1}, UnknownNameError),
        ({"level": -1}, ValueError),
        ({"level": 1.5}, ValueError),
        ({"level": True}, ValueError),
        ({"level": 2**53}, ValueError),
    ],
)
def test_bad_options(options, error):
    with pytest.raises(error):
        WorldEnv("sparse_circles").reset(options=options)


def test_a_scenario_from_a_mapping_a_file_or_itself(tmp_path):
    text = """
world: {width: 6, height: 6, step_time: 0.1}
robot:
  - {kinematics: {name: diff}, shape: {name: circle, radius: 0.2}, state: [1, 1, 0], goal: [5, 5, 0]}
"""
    file = tmp_path / "plain.yaml"
    file.write_text(text)
    by_path = irsim_gym.make(file)
    by_text = irsim_gym.make(str(file))
    loaded = WorldEnv(irsim_gym.load_scenario(file))
    first = by_path.reset(seed=0)[0]
    np.testing.assert_array_equal(by_text.reset(seed=0)[0], first)
    np.testing.assert_array_equal(loaded.reset(seed=0)[0], first)
    assert gymnasium.make("irsim_gym/World-v0", scenario=str(file)).reset(seed=0)[0].shape == first.shape
    data = {
        "world": {"width": 6, "height": 6, "step_time": 0.1},
        "robot": [
            {
                "kinematics": {"name": "diff"},
                "shape": {"name": "circle", "radius": 0.2},
                "state": [1, 1, 0],
                "goal": [5, 5, 0],
            }
        ],
    }
    np.testing.assert_array_equal(irsim_gym.make(data).reset(seed=0)[0], first)


def test_bad_scenarios_say_so(tmp_path):
    (tmp_path / "bad.yaml").write_text("world: {width: -1}\n")
    with pytest.raises(ScenarioError):
        irsim_gym.make(tmp_path / "bad.yaml")
    with pytest.raises((ScenarioError, UnknownNameError, FileNotFoundError), match="clutered_room"):
        irsim_gym.make("clutered_room")


def test_several_learners_need_another_environment():
    with pytest.raises(ValueError, match="one learner"):
        WorldEnv(
            {
                "world": {"width": 6, "height": 6},
                "robot": [
                    {"kinematics": {"name": "diff"}, "shape": {"name": "circle"}, "state": [k, k, 0], "goal": [5, 5, 0]}
                    for k in (1, 3)
                ],
            },
            task={"name": "navigation", "agents": "all"},
        )
