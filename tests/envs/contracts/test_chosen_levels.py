"""The next level is chosen: in every adapter as in a single environment, bit for bit, and within the split."""

from __future__ import annotations

import numpy as np
import pytest
from contract_tools import STILL, assert_same, forward_actions
from gymnasium.error import ResetNeeded
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv
from team_tools import KNOWN, MEET

import irsim_gym
from irsim_gym.base.rng import level_stream, stream_base
from irsim_gym.tasks.episodes.levels import CHAIN

N, LIMIT = 3, 4


def test_the_chain_goes_on_after_a_choice():
    env, other = (irsim_gym.make(STILL) for _ in range(2))
    for one in (env, other):
        one.reset(seed=3)
    env.unwrapped.choose_level(41)
    chosen = env.reset()
    assert chosen[1]["level"] == 41
    other.reset()
    assert_same(env.reset(), other.reset())
    assert_same(chosen, irsim_gym.make(STILL).reset(options={"level": 41}))


@pytest.mark.parametrize("reset", [{"seed": 9}, {"options": {"level": 9}}, {"options": {"split": "dev"}, "seed": 9}])
def test_a_reset_of_its_own_forgets_the_choice(reset):
    env = irsim_gym.make(STILL)
    env.reset(seed=3)
    env.unwrapped.choose_level(41)
    assert env.reset(**reset)[1]["level"] == 9
    assert env.reset()[1]["level"] != 41


def test_none_takes_the_choice_back():
    env = irsim_gym.make(STILL)
    env.reset(seed=3)
    following = env.reset()[1]["level"]
    env.reset(seed=3)
    env.unwrapped.choose_level(41)
    env.unwrapped.choose_level(None)
    assert env.reset()[1]["level"] == following


@pytest.mark.parametrize("split", ["train", "test"])
def test_a_choice_stays_in_the_split(split):
    env = irsim_gym.make(STILL).unwrapped
    env.reset(seed=3, options={"split": split})
    env.choose_level(41)
    env.reset()
    assert env.worlds.episodes.state.stream[0] == level_stream(stream_base("sparse_circles", split), 41)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("num_threads", [1, 2])
def test_worlds_of_a_vector_environment_equal_single_ones(mode, num_threads):
    kwargs = {"max_steps": LIMIT, "autoreset_mode": mode}
    envs = irsim_gym.make_vec(STILL, N, num_threads=num_threads, **kwargs)
    singles = [irsim_gym.make(STILL, max_steps=LIMIT) for _ in range(N)]
    seen = envs.reset(seed=5)[0]
    for w, env in enumerate(singles):
        assert_same(seen[w], env.reset(seed=5 + w)[0])
    rng, ended = np.random.default_rng(0), np.zeros(N, np.bool_)
    for _ in range(5 * LIMIT):
        levels = rng.integers(CHAIN, 50, N)
        envs.choose_levels(levels)
        actions = forward_actions(rng, (N, 2))
        seen, rewards, terminated, truncated, _ = envs.step(actions)
        for w, env in enumerate(singles):
            env.unwrapped.choose_level(int(levels[w]) if levels[w] >= 0 else None)
            if mode == "NextStep" and ended[w]:
                assert_same(seen[w], env.reset()[0])
                continue
            mine, reward, *ends, _ = env.step(actions[w])
            assert (reward, *ends) == (rewards[w], terminated[w], truncated[w])
            assert_same(seen[w], env.reset()[0] if mode == "SameStep" and any(ends) else mine)
        ended = terminated | truncated


@pytest.mark.parametrize("cls", [DummyVecEnv, SubprocVecEnv])
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_stable_baselines3_chooses_by_env_method(cls):
    limit = {"max_steps": LIMIT}
    options = {"start_method": "fork"} if cls is SubprocVecEnv else {}
    others = make_vec_env(f"irsim_gym:{STILL}", N, seed=5, vec_env_cls=cls, env_kwargs=limit, vec_env_kwargs=options)
    envs = [irsim_gym.sb3.make_vec_env(STILL, N, seed=5, **limit), others]
    assert_same(*[env.reset() for env in envs])
    rng = np.random.default_rng(0)
    levels = []
    for _ in range(3 * LIMIT):
        actions, world, level = forward_actions(rng, (N, 2)), int(rng.integers(N)), int(rng.integers(50))
        for env in envs:
            env.env_method("choose_level", level, indices=[world])
        here, there = (env.step(actions) for env in envs)
        assert_same((here[0], here[2]), (there[0], there[2]))
        levels += [info["level"] for info in here[3] if info]
    others.close()
    assert sum(level < 50 for level in levels) > N


def test_teams_in_every_adapter():
    levels = [17, 4]
    batch = irsim_gym.make_batch(MEET, 2, max_steps=LIMIT, num_threads=2)
    slots = irsim_gym.sb3.make_multi_agent_vec_env(MEET, 2, seed=0, max_steps=LIMIT)
    slots.leaves_out_waiting = True
    batch.reset(seed=0)
    slots.reset()
    batch.choose_levels(levels)
    for w, level in enumerate(levels):
        slots.env_method("choose_level", level, indices=[w * batch.n_agents])
    for _ in range(LIMIT):
        step = batch.step(np.zeros((2, 3, 2)))
        seen = slots.step(np.zeros((6, 2), np.float32))[0]
        assert (step.observation.reshape(6, -1) == seen).all()
    assert step.began.all()
    assert batch.worlds.infos.of(1)["level"] == 4
    for w, level in enumerate(levels):
        env = irsim_gym.parallel_env(MEET)
        env.reset(seed=w)
        env.choose_level(level)
        found, _ = env.reset()
        assert (np.stack(list(found.values())) == step.observation[w]).all()


def test_a_level_is_chosen_for_worlds_that_restart_not_for_robots_that_respawn():
    batch = irsim_gym.make_batch(KNOWN | {"robot": [KNOWN["robot"][0]]}, respawn=True, world_steps=30)
    batch.reset(seed=0)
    batch.choose_levels([5])
    levels = [batch.step(np.zeros((1, 1, 2))).infos["level"][0, 0] for _ in range(31)]
    assert levels == [0] * 30 + [5]


def test_what_is_no_choice():
    env = irsim_gym.make(STILL).unwrapped
    with pytest.raises(ResetNeeded, match=r"call reset\(\) before choosing"):
        env.choose_level(3)
    envs = irsim_gym.make_vec(STILL, 2)
    envs.reset(seed=0)
    for levels in ([1], [1, 2, 3], [0.5, 1.0], [[1, 2]], [True, False]):
        with pytest.raises(ValueError, match="a whole number for each of 2 worlds"):
            envs.choose_levels(levels)
    for levels in ([1, -2], [2**53, 0]):
        with pytest.raises(ValueError, match=f"levels must be 0 to {2**53 - 1}, or -1"):
            envs.choose_levels(levels)
