"""What batches show of single worlds, against environments made one by one."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from contract_tools import STILL
from gymnasium.wrappers import OrderEnforcing, TimeLimit
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import Monitor

import irsim_gym
from irsim_gym.envs.gymnasium.single import WorldEnv

N = 3
NAMES = ["spec", "max_steps", "render_mode", "metadata", "observation_space", "action_space"]


@pytest.fixture(scope="module")
def gymnasium_pair():
    """The native batch and ``SyncVectorEnv``."""
    kwargs = {"max_episode_steps": 7, "render_mode": "rgb_array"}
    modes = ("vector_entry_point", "sync")
    return [gymnasium.make_vec(STILL, num_envs=N, vectorization_mode=mode, **kwargs) for mode in modes]


@pytest.fixture(scope="module")
def sb3_pair():
    """The native environments and what Stable-Baselines3's own function makes."""
    limit = {"max_steps": 7}
    return [irsim_gym.sb3.make_vec_env(STILL, N, 0, **limit), make_vec_env(STILL, N, 0, env_kwargs=limit)]


@pytest.mark.parametrize("name", NAMES)
def test_attributes_of_a_vector_environment(gymnasium_pair, name):
    native, sync = gymnasium_pair
    for env in (native, sync):
        env.reset(seed=0)
    assert native.get_attr(name) == sync.get_attr(name) == native.call(name)
    assert len(native.get_attr(name)) == N


@pytest.mark.parametrize("name", NAMES)
def test_attributes_of_a_vec_env(sb3_pair, name):
    native, dummy = (env.get_attr(name, indices=[0, 2]) for env in sb3_pair)
    if name == "spec":
        native, dummy = ([(one.id, one.kwargs, one.max_episode_steps) for one in each] for each in (native, dummy))
    assert native == dummy
    assert len(native) == 2
    assert [env.has_attr(name) for env in sb3_pair] == [True] * 2


def test_methods(gymnasium_pair, sb3_pair):
    native, sync = gymnasium_pair
    for env in (native, sync):
        env.reset(seed=4)
    assert [info["level"] for info in native.call("info")] == [4, 5, 6]
    numbers = [[rng.integers(1000) for rng in env.get_attr("np_random")] for env in (native, sync)]
    assert numbers[0] == numbers[1]
    assert native.call("has_wrapper_attr", "nothing") == sync.call("has_wrapper_attr", "nothing") == (False,) * N
    for env in sb3_pair:
        assert env.env_is_wrapped(Monitor) == env.env_is_wrapped(gymnasium.Wrapper) == [True] * N
        assert env.env_is_wrapped(TimeLimit, indices=0) == [False]
    assert (
        sb3_pair[0].env_is_wrapped(OrderEnforcing) == [False] * N
    )  # worlds are not wrapped, but for Monitor's statistics


def test_setting(gymnasium_pair, sb3_pair):
    for env in gymnasium_pair:
        env.set_attr("colour", ["red", "green", "blue"])
        env.set_attr("size", 4)
        assert (env.get_attr("colour"), env.get_attr("size")) == (("red", "green", "blue"), (4, 4, 4))
        with pytest.raises(ValueError, match="2"):
            env.set_attr("colour", ["red", "green"])
        env.set_attr("max_steps", [3, 3, 3])
        env.reset(seed=0)
        cut = [env.step(np.zeros((N, 2), np.float32))[3].tolist() for _ in range(3)]
        assert cut == [[False] * N, [False] * N, [True] * N]
        with pytest.raises(AttributeError):
            env.call("nothing")
    for env in sb3_pair:
        env.set_attr("max_steps", 2) if env is sb3_pair[0] else [
            setattr(one.unwrapped, "max_steps", 2) for one in env.envs
        ]
        env.reset()
        assert [env.step(np.zeros((N, 2), np.float32))[2].all() for _ in range(2)] == [False, True]


def test_what_is_one_for_a_batch_cannot_be_set_for_one_world():
    native, vec = irsim_gym.make_vec(STILL, N), irsim_gym.sb3.make_vec_env(STILL, N)
    with pytest.raises(ValueError, match=r"all 3 worlds of a batch have one max_steps.*\[3, 4, 3\]"):
        native.set_attr("max_steps", [3, 4, 3])
    with pytest.raises(ValueError, match="all 3 worlds of a batch have one max_steps"):
        vec.set_attr("max_steps", 4, indices=0)
    for env in (native, vec):
        with pytest.raises(AttributeError, match="'render_mode' is shared by all worlds of a batch"):
            env.set_attr("render_mode", "human")
    with pytest.raises(AttributeError, match=r"worlds of a batch step together: call step\(\) of the batch"):
        native.call("step", np.zeros(2))
    with pytest.raises(AttributeError, match=r"no attribute 'max_step' \(did you mean 'max_steps'\?\)"):
        vec.env_method("max_step")


def test_batches_that_were_made_from_no_id_have_no_spec():
    from irsim_gym.envs.gymnasium.vector import WorldVectorEnv

    name = STILL.split("/")[1].removesuffix("-v0")
    assert WorldVectorEnv(name, 2).get_attr("spec") == (None, None)
    assert WorldEnv(name).spec is None
