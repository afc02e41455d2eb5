"""What a native vector environment owes its users, beyond equality with the built-in one."""

from __future__ import annotations

import itertools
import pickle
from copy import deepcopy

import gymnasium
import numpy as np
import pytest
from contract_tools import MOVING, STILL, arrays_in, assert_same, forward_actions
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode

from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.errors import UnknownNameError


def rollout(envs, n_steps, seed=0, rows=None):
    """Everything that an environment returns, for some of its worlds."""
    rng = np.random.default_rng(seed)
    seen = [envs.reset(seed=seed)[0][:rows]]
    for _ in range(n_steps):
        observations, *others, _ = envs.step(forward_actions(rng, (64, 2))[: envs.num_envs])
        seen.append((observations[:rows], *(other[:rows] for other in others)))
    return seen


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_change_nothing(threads):
    whole, shared = (gymnasium.make_vec(MOVING, num_envs=7, max_steps=30, num_threads=k) for k in (1, threads))
    assert_same(rollout(shared, 150), rollout(whole, 150))


def test_batch_size_changes_nothing():
    few, many = (gymnasium.make_vec(STILL, num_envs=n, max_steps=30) for n in (3, 64))
    assert_same(rollout(few, 80, rows=3), rollout(many, 80, rows=3))


def test_interleaved_environments_do_not_meet():
    alone = rollout(gymnasium.make_vec(MOVING, num_envs=2, max_steps=20), 60)
    envs = [gymnasium.make_vec(MOVING, num_envs=2, max_steps=20) for _ in range(2)]
    rngs = [np.random.default_rng(0) for _ in envs]
    seen = [[envs[k].reset(seed=0)[0]] for k in range(2)]
    for _ in range(60):
        for k in range(2):
            observations, *others, _ = envs[k].step(forward_actions(rngs[k], (64, 2))[:2])
            seen[k].append((observations, *others))
    assert_same(seen[0], alone)
    assert_same(seen[1], alone)


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("form", ["flat", "dict"])
def test_nothing_returned_shares_memory(mode, form):
    task = {"name": "navigation", "observation_form": form}
    envs = gymnasium.make_vec(STILL, num_envs=4, max_steps=3, autoreset_mode=mode, task=task)
    calls = [envs.reset(seed=0)]
    actions = np.ones((4, 2), np.float32)
    for _ in range(4):
        result = envs.step(actions)
        calls.append(result)
        if mode is AutoresetMode.DISABLED and (result[2] | result[3]).any():
            calls.append(envs.reset(options={"reset_mask": result[2] | result[3]}))
    arrays = [array for call in calls for array in arrays_in(call)]
    live = list(arrays_in(vars(envs.unwrapped.worlds.episodes.view)))
    for one, other in itertools.combinations(arrays, 2):
        assert not np.shares_memory(one, other)
    for one, inner in itertools.product(arrays, live):
        assert not np.shares_memory(one, inner)


def test_actions_and_options_are_left_alone():
    envs = gymnasium.make_vec(STILL, num_envs=2)
    mask = np.array([True, False])
    options = {"reset_mask": mask}
    envs.reset(seed=0)
    envs.reset(options=options)
    assert options == {"reset_mask": mask}
    actions = np.full((2, 2), 3.0, np.float32)
    envs.step(actions)
    assert (actions == 3.0).all()


def test_stepping_needs_a_reset():
    envs = gymnasium.make_vec(STILL, num_envs=2, max_steps=2, autoreset_mode="Disabled")
    actions = np.zeros((2, 2), np.float32)
    with pytest.raises(ResetNeeded):
        envs.step(actions)
    envs.reset(seed=0, options={"reset_mask": np.array([True, False])})
    with pytest.raises(ResetNeeded):
        envs.step(actions)
    envs.reset(seed=0)
    envs.step(actions)
    envs.step(actions)
    with pytest.raises(AssertionError, match="reset_mask"):
        envs.step(actions)


def test_a_partial_reset_leaves_the_other_worlds_ended():
    actions, first = np.zeros((2, 2), np.float32), np.array([True, False])
    envs = gymnasium.make_vec(STILL, num_envs=2, max_steps=2, autoreset_mode="Disabled")
    envs.reset(seed=0)
    for _ in range(2):
        *_, truncations, _ = envs.step(actions)
    assert truncations.all()
    envs.reset(options={"reset_mask": first})
    with pytest.raises(AssertionError, match=r"worlds \[1\] have ended"):
        envs.step(actions)
    envs.reset(options={"reset_mask": ~first})
    assert envs.step(actions)[-1]["steps"].tolist() == [1, 1]


def test_a_partial_reset_between_steps_leaves_the_other_worlds_to_restart_by_themselves():
    actions, first = np.zeros((2, 2), np.float32), np.array([True, False])
    envs = gymnasium.make_vec(STILL, num_envs=2, max_steps=2, autoreset_mode="NextStep")
    envs.reset(seed=0)
    for _ in range(2):
        envs.step(actions)
    envs.reset(options={"reset_mask": first})
    _, rewards, terminations, truncations, infos = envs.step(actions)
    assert infos["steps"].tolist() == [1, 0]
    assert rewards[0] < 0.0, "standing still costs time"
    assert rewards[1] == 0.0
    assert not (terminations | truncations).any()
    assert envs.step(actions)[-1]["steps"].tolist() == [2, 1]


@pytest.mark.parametrize(
    ("actions", "error"),
    [
        (np.zeros((1, 2), np.float32), ValueError),
        (np.zeros((4, 2), np.float32), ValueError),
        (np.zeros((3, 3), np.float32), ValueError),
        (np.zeros(3, np.float32), ValueError),
        (0.0, TypeError),
        (None, TypeError),
        (np.full((3, 2), np.nan, np.float32), ValueError),
        (np.full((3, 2), np.inf, np.float32), ValueError),
    ],
)
def test_bad_actions(actions, error):
    envs = gymnasium.make_vec(STILL, num_envs=3)
    envs.reset(seed=0)
    with pytest.raises(error):
        envs.step(actions)


def test_actions_of_restarting_worlds_are_not_looked_at():
    envs = gymnasium.make_vec(STILL, num_envs=2, max_steps=2)
    envs.reset(seed=0)
    envs.reset(seed=0, options={"reset_mask": np.array([True, False])})
    for _ in range(2):
        *_, truncations, _ = envs.step(np.zeros((2, 2), np.float32))
    assert truncations.all()
    envs.step(np.full((2, 2), np.nan, np.float32))
    with pytest.raises(ValueError, match="finite"):
        envs.step(np.full((2, 2), np.nan, np.float32))


@pytest.mark.parametrize(
    ("mask", "error"),
    [
        ([True, False], TypeError),
        (np.array([1, 0]), TypeError),
        (np.array([True]), ValueError),
        (np.array([False, False]), ValueError),
    ],
)
def test_bad_masks(mask, error):
    envs = gymnasium.make_vec(STILL, num_envs=2)
    with pytest.raises(error):
        envs.reset(seed=0, options={"reset_mask": mask})


@pytest.mark.parametrize("seed", [-1, [1], [1, 2, 3], [1, -2]])
def test_bad_seeds(seed):
    envs = gymnasium.make_vec(STILL, num_envs=2)
    with pytest.raises((ValueError, gymnasium.error.Error)):
        envs.reset(seed=seed)


def test_unknown_options_are_refused():
    envs = gymnasium.make_vec(STILL, num_envs=2)
    with pytest.raises(UnknownNameError, match="did you mean 'level'"):
        envs.reset(options={"levle": 3})
    with pytest.raises(UnknownNameError):
        envs.reset(options={"split": "tets"})
    with pytest.raises(ValueError):
        envs.reset(options={"level": -1})
    with pytest.raises(ValueError):
        envs.reset(options={"level": [1, 2, 3]})


def test_levels_by_option():
    envs = gymnasium.make_vec(STILL, num_envs=3)
    env = gymnasium.make(STILL)
    observations, infos = envs.reset(options={"split": "test", "level": 17})
    assert infos["level"].tolist() == [17, 18, 19]
    for w in range(3):
        observation, _ = env.reset(options={"split": "test", "level": 17 + w})
        np.testing.assert_array_equal(observations[w], observation)
    assert envs.reset(options={"level": [5, 4, 5]})[1]["level"].tolist() == [5, 4, 5]
    train, _ = envs.reset(seed=17)
    assert (train != observations).any()


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_copies_go_on_alike(mode):
    envs = gymnasium.make_vec(MOVING, num_envs=3, max_steps=25, autoreset_mode=mode)
    envs.reset(seed=8)
    rng = np.random.default_rng(1)
    for _ in range(25):
        last = envs.step(forward_actions(rng, (3, 2)))
        if mode is AutoresetMode.DISABLED and (last[2] | last[3]).any():
            break
    twins = [pickle.loads(pickle.dumps(envs)), deepcopy(envs)]
    for _ in range(20):
        actions = forward_actions(rng, (3, 2))
        if mode is AutoresetMode.DISABLED:
            ended = last[2] | last[3]
            if ended.any():
                results = [one.reset(options={"reset_mask": ended}) for one in (envs, *twins)]
                assert_same(results[1], results[0])
        last, *others = (one.step(actions) for one in (envs, *twins))
        for other in others:
            assert_same(other, last)


def test_seeds_are_kept_and_a_new_split_draws_from_them():
    envs, levels = gymnasium.make_vec(STILL, num_envs=2), []
    for _ in range(2):
        envs.reset(seed=5)
        assert envs.np_random_seed == (5, 6)
        levels.append(envs.reset(options={"split": "dev"})[1]["level"].tolist())
        assert envs.np_random_seed == (5, 6)
    assert levels[0] == levels[1]
    for w in range(2):
        env = gymnasium.make(STILL)
        env.reset(seed=5 + w)
        assert env.reset(options={"split": "dev"})[1]["level"] == levels[0][w]


def test_unseeded_environments_differ_and_report_their_seeds():
    envs, others = (gymnasium.make_vec(STILL, num_envs=2) for _ in range(2))
    assert (envs.reset()[0] != others.reset()[0]).any()
    assert len(set(envs.np_random_seed) | set(others.np_random_seed)) == 4


def test_a_mode_of_autoreset_that_is_none_is_told_the_others():
    with pytest.raises(ValueError, match="must be one of 'NextStep', 'SameStep', 'Disabled', got 'same'"):
        WorldVectorEnv(STILL.split("/")[1].removesuffix("-v0"), 2, autoreset_mode="same")


def test_limits_and_modes():
    envs = gymnasium.make_vec(STILL, num_envs=1, max_steps=30, max_episode_steps=7)
    assert envs.unwrapped.worlds.task.max_steps == 7
    for kwargs in ({"max_episode_steps": 50}, {"max_episode_steps": -1}, {"max_episode_steps": None}):
        assert WorldVectorEnv("sparse_circles", 1, max_steps=30, **kwargs).worlds.task.max_steps == 30
    assert WorldVectorEnv("sparse_circles").metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    with pytest.raises(ValueError):
        WorldVectorEnv("sparse_circles", autoreset_mode="Sometimes")
    envs.reset(seed=0)
    flags = [envs.step(np.zeros((1, 2), np.float32))[3][0] for _ in range(7)]
    assert flags == [False] * 6 + [True]


def test_rendering_and_closing():
    envs = gymnasium.make_vec(STILL, num_envs=2, render_mode="rgb_array")
    envs.reset(seed=0)
    frames = envs.render()
    assert isinstance(frames, tuple)
    assert [(frame.dtype, frame.ndim) for frame in frames] == [(np.uint8, 3)] * 2
    assert (frames[0] != frames[1]).any()
    assert not np.shares_memory(frames[0], frames[1])
    pickle.dumps(envs)
    envs.close()
    envs.close()
    assert envs.closed
