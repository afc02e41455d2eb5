"""The native ``VecEnv`` against ``DummyVecEnv`` of single environments, and what learning makes of both."""

from __future__ import annotations

import pickle
from copy import deepcopy

import gymnasium
import imageio.v2 as imageio
import numpy as np
import pytest
import torch
from contract_tools import STILL, arrays_in, assert_same, forward_actions
from gymnasium.error import ResetNeeded
from gymnasium.wrappers import TimeLimit
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor, VecNormalize, VecVideoRecorder

import irsim_gym

NAME = "sparse_circles"
CONSTANT = {
    "name": "blank",
    "observations": [{"name": "scan", "sectors": 4}],
    "rewards": [{"name": "time", "weight": 20.0}],
    "endings": [],
    "max_steps": 20,
}


def pair(n=4, **kwargs):
    """The native environments and ``DummyVecEnv``."""
    native = irsim_gym.sb3.make_vec_env(NAME, n, **kwargs)
    return native, DummyVecEnv([lambda: gymnasium.make(STILL, **kwargs) for _ in range(n)])


@pytest.mark.parametrize(("form", "limit"), [("flat", "max_episode_steps"), ("dict", "max_steps")])
def test_native_equals_dummy(form, limit):
    native, dummy = pair(**{limit: 30}, task={"name": "navigation", "observation_form": form})
    for env in (native, dummy):
        env.seed(3)
    assert_same(plain(native.reset()), plain(dummy.reset()))
    assert_same(native.reset_infos, dummy.reset_infos)
    rng = np.random.default_rng(0)
    ends = 0
    for _ in range(500):
        actions = forward_actions(rng, (4, 2))
        here, there = native.step(actions), dummy.step(actions)
        assert_same((plain(here[0]), *here[1:3]), (plain(there[0]), *there[1:3]))
        for done, mine, theirs in zip(here[2], here[3], there[3], strict=True):
            if done:
                ends += 1
                episode = mine.pop("episode")
                assert episode["l"] == mine["steps"]
                assert_same(mine, theirs)
            else:
                assert mine == {}
        assert_same(native.reset_infos, dummy.reset_infos)
    assert ends > 40


def plain(observation):
    """SB3 returns ordered dicts in places."""
    return dict(observation) if isinstance(observation, dict) else observation


def weights(env, algorithm=PPO, steps=2000, **kwargs):
    """Train and return all parameters."""
    torch.manual_seed(0)
    model = algorithm("MlpPolicy", env, seed=0, device="cpu", **kwargs)
    model.learn(steps)
    return torch.cat([p.detach().flatten() for p in model.policy.parameters()])


@pytest.mark.parametrize(
    ("algorithm", "limit", "steps", "options"),
    [
        (PPO, "max_steps", 2000, {"n_steps": 125, "batch_size": 100, "n_epochs": 3}),
        (SAC, "max_episode_steps", 200, {"learning_starts": 100, "batch_size": 32, "buffer_size": 500}),
    ],
)
def test_learning_gives_identical_weights(algorithm, limit, steps, options):
    """Also where a ``TimeLimit`` cuts: both bootstrap there."""
    native, dummy = pair(**{limit: 30})
    assert torch.equal(weights(native, algorithm, steps, **options), weights(dummy, algorithm, steps, **options))


def test_time_limits_are_bootstrapped():
    """Reward -1 at each step, a limit of 20 steps: V = -1 / (1 - gamma) = -10; about -6.3 if limits were endings."""
    env = irsim_gym.sb3.make_vec_env(NAME, 16, seed=0, task=CONSTANT)
    model = PPO(
        "MlpPolicy", env, seed=0, gamma=0.9, n_steps=60, batch_size=240, n_epochs=10, learning_rate=3e-3, device="cpu",
        policy_kwargs={"net_arch": [16]}, vf_coef=1.0, max_grad_norm=10.0,
    )  # fmt: skip
    model.learn(16 * 60 * 25)
    observations = env.reset()
    values = model.policy.predict_values(torch.as_tensor(observations)).detach().numpy()
    np.testing.assert_allclose(values, -10.0, atol=0.5)


def test_constant_reward_is_constant_and_only_time_ends():
    env = irsim_gym.sb3.make_vec_env(NAME, 2, seed=0, task=CONSTANT)
    env.reset()
    for step in range(1, 41):
        _, rewards, dones, infos = env.step(np.ones((2, 2), np.float32))
        assert rewards.tolist() == [-1.0, -1.0]
        assert dones.all() == (step % 20 == 0) == dones.any()
        if dones.any():
            assert [info["TimeLimit.truncated"] for info in infos] == [True, True]
            assert [(info["episode"]["r"], info["episode"]["l"]) for info in infos] == [(-20.0, 20)] * 2


def test_types_of_a_step():
    env = irsim_gym.sb3.make_vec_env(NAME, 3, seed=0, max_steps=2)
    env.reset()
    env.step(np.zeros((3, 2), np.float32))
    observations, rewards, dones, infos = env.step(np.zeros((3, 2), np.float32))
    assert (observations.dtype, rewards.dtype, dones.dtype) == (np.float32, np.float32, np.bool_)
    for info in infos:
        assert info["terminal_observation"].shape == env.observation_space.shape
        assert {type(info[key]) for key in ("is_success", "TimeLimit.truncated")} == {bool}
        assert type(info["outcome"]) is int


def test_returned_arrays_are_fresh():
    env = irsim_gym.sb3.make_vec_env(NAME, 3, seed=0, max_steps=2)
    results = [env.reset(), *(env.step(np.zeros((3, 2), np.float32)) for _ in range(4))]
    arrays = [list(arrays_in(result)) for result in results]
    live = list(arrays_in(vars(env.worlds.episodes.view)))
    for k, mine in enumerate(arrays):
        others = [array for result in arrays[k + 1 :] for array in result] + live
        assert not any(np.shares_memory(one, other) for one in mine for other in others)


def test_seed_options_and_going_on():
    env = irsim_gym.sb3.make_vec_env(NAME, 2, seed=5)
    first = env.reset()
    assert [info["level"] for info in env.reset_infos] == [5, 6]
    assert (env.reset() != first).any()
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), first)
    env.set_options({"split": "dev", "level": 9})
    observations = env.reset()
    np.testing.assert_array_equal(observations[0], observations[1])
    assert [info["level"] for info in env.reset_infos] == [9, 9]
    env.set_options([{"level": 1}, {"level": 2}])
    env.reset()
    assert [info["level"] for info in env.reset_infos] == [1, 2]


def test_attributes_and_methods():
    env = irsim_gym.sb3.make_vec_env(NAME, 3, seed=0)
    assert env.get_attr("render_mode") == ["rgb_array"] * 3
    env.set_attr("colour", "red", indices=[0, 2])
    assert env.get_attr("colour", indices=[0, 2]) == ["red", "red"]
    assert env.has_attr("render_mode")
    assert not env.has_attr("nothing")
    env.reset()
    assert [info["level"] for info in env.env_method("info", indices=1)] == [1]
    assert env.env_is_wrapped(Monitor) == [True] * 3
    assert env.env_is_wrapped(gymnasium.wrappers.TimeLimit, indices=0) == [False]
    assert env.get_images()[0].shape == env.env_method("render")[0].shape
    assert env.render().ndim == 3
    env.close()
    env.close()


def test_errors():
    env = irsim_gym.sb3.make_vec_env(NAME, 2)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros((2, 2), np.float32))
    env.reset()
    with pytest.raises(ValueError, match="shape"):
        env.step(np.zeros((3, 2), np.float32))
    with pytest.raises(ValueError):
        env.step(np.full((2, 2), np.nan, np.float32))


def test_wrappers_of_sb3():
    env = irsim_gym.sb3.make_vec_env(NAME, 2, seed=0, max_steps=10)
    with pytest.warns(UserWarning, match="already wrapped with a `Monitor`"):  # as around SB3's own make_vec_env
        wrapped = VecNormalize(VecMonitor(env, info_keywords=("is_success",)))
    wrapped.reset()
    lengths = []
    for _ in range(25):
        _, _, dones, infos = wrapped.step(np.ones((2, 2), np.float32))
        lengths += [info["episode"]["l"] == info["steps"] for done, info in zip(dones, infos, strict=True) if done]
    assert len(lengths) >= 4
    assert all(lengths)


def test_a_monitor_below_another_wrapper_is_answered_for_as_well():
    """An evaluation reads our statistics, raw whatever is normalised."""
    env = VecNormalize(irsim_gym.sb3.make_vec_env(NAME, 2, seed=0, max_steps=10))
    assert env.env_is_wrapped(Monitor) == [True] * 2
    assert env.env_is_wrapped(TimeLimit) == [False] * 2


def test_any_source_of_a_scenario_works():
    seen = [irsim_gym.sb3.make_vec_env(name, 2, seed=1).reset() for name in (NAME, STILL, f"irsim_gym:{STILL}")]
    np.testing.assert_array_equal(seen[0], seen[1])
    np.testing.assert_array_equal(seen[0], seen[2])


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore:unclosed:ResourceWarning")
def test_sb3_video(tmp_path):
    env = irsim_gym.sb3.make_vec_env(NAME, 2, seed=0)
    recorder = VecVideoRecorder(env, str(tmp_path), record_video_trigger=lambda step: step == 0, video_length=4)
    recorder.reset()
    for _ in range(6):
        recorder.step(np.zeros((2, 2), np.float32))
    recorder.close()
    (film,) = tmp_path.iterdir()
    with imageio.get_reader(film) as reader:
        assert reader.count_frames() == 1 + 4  # that of the reset is not counted in the length
        assert reader.get_meta_data()["fps"] == pytest.approx(10.0)
        assert reader.get_data(0).shape == (1200, 600, 3)


def test_evaluation_trusts_the_statistics():
    env = irsim_gym.sb3.make_vec_env(NAME, 4, seed=0, max_steps=20)
    model = PPO("MlpPolicy", env, n_steps=8, batch_size=8, seed=0, device="cpu")
    rewards, lengths = evaluate_policy(model, env, n_eval_episodes=8, return_episode_rewards=True)
    assert len(rewards) == len(lengths) == 8


def test_copies_go_on_alike():
    env = irsim_gym.sb3.make_vec_env(NAME, 3, seed=0, max_steps=15)
    env.reset()
    rng = np.random.default_rng(0)
    for _ in range(8):
        env.step(forward_actions(rng, (3, 2)))
    for twin in (pickle.loads(pickle.dumps(env)), deepcopy(env)):
        again = deepcopy(env)
        for _ in range(20):
            actions = forward_actions(rng, (3, 2))
            here, there = again.step(actions), twin.step(actions)
            for info in (*here[3], *there[3]):
                info.pop("episode", None)
            assert_same(here, there)
