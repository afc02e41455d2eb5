"""Worlds as tensors: ``irsim_gym.torch_rows``."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from gymnasium.error import ResetNeeded
from team_tools import KNOWN, LIMIT, MEET

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.tasks import Outcome

LONE = "sparse_circles"
FLAGS = ("terminated", "truncated", "acted", "live", "began")


def lone_rows(n_worlds=3, device=None, autoreset_mode="SameStep", **given):
    env = irsim_gym.make_vec(LONE, n_worlds, max_steps=30, autoreset_mode=autoreset_mode, **given)
    return irsim_gym.torch_rows(env, device)


@pytest.mark.parametrize("device", [None, "cpu"])
def test_rows_of_single_robots_are_those_of_make_vec(device):
    rows = lone_rows(device=device)
    env = irsim_gym.make_vec(LONE, 3, max_steps=30, autoreset_mode="SameStep")
    rows.reset(seed=7)
    np.testing.assert_array_equal(rows.observation, env.reset(seed=7)[0])
    rng, n_ended = np.random.default_rng(0), 0
    for _ in range(70):
        actions = rng.uniform([0.6, -1.0], 1.0, (3, 2))
        rows.step(torch.from_numpy(actions))
        observations, rewards, terminated, truncated, infos = env.step(actions)
        np.testing.assert_array_equal(rows.observation, observations)
        np.testing.assert_array_equal(rows.reward, rewards.astype(np.float32))
        np.testing.assert_array_equal(rows.terminated, terminated)
        np.testing.assert_array_equal(rows.truncated, truncated & ~terminated)
        assert rows.acted.all()
        ended = np.flatnonzero(terminated | truncated)
        np.testing.assert_array_equal(rows.episodes["world"], ended)
        for k, w in enumerate(ended):
            n_ended += 1
            np.testing.assert_array_equal(rows.final_observation[w], infos["final_obs"][w])
            assert rows.episodes["outcome"][k] == infos["final_info"]["outcome"][w]
    assert n_ended > 5


def test_costs_are_those_of_each_step_the_last_one_of_an_episode_included():
    kwargs = {"task": {"near": 0.3}, "max_steps": 30, "autoreset_mode": "SameStep"}
    rows, env = irsim_gym.torch_rows(irsim_gym.make_vec(LONE, 8, **kwargs)), irsim_gym.make_vec(LONE, 8, **kwargs)
    rows.reset(seed=7)
    env.reset(seed=7)
    rng, last, before = np.random.default_rng(0), [], 0
    for _ in range(90):
        actions = rng.uniform([0.6, -1.0], 1.0, (8, 2))
        rows.step(torch.from_numpy(actions))
        _, _, terminated, truncated, infos = env.step(actions)
        ended = terminated | truncated
        wanted = np.where(ended, infos["final_info"]["cost"], infos["cost"]) if ended.any() else infos["cost"]
        np.testing.assert_array_equal(rows.cost, wanted.astype(np.float32))
        last += [
            (cost, outcome) for cost, outcome in zip(rows.cost[ended].tolist(), rows.episodes["outcome"], strict=True)
        ]
        before += int(rows.cost[~ended].sum())
    assert before > 0
    assert {cost for cost, outcome in last if outcome == Outcome.COLLISION} == {1.0}
    assert not lone_rows().cost.any()


@pytest.mark.parametrize("respawn", [False, True])
def test_rows_of_teams_are_those_of_make_batch(respawn):
    rows = irsim_gym.torch_rows(irsim_gym.make_batch(MEET, 2, max_steps=12, respawn=respawn))
    batch = irsim_gym.make_batch(MEET, 2, max_steps=12, respawn=respawn)
    rows.reset(seed=3)
    step, rng, n_waited = batch.reset(seed=3), np.random.default_rng(0), 0
    for _ in range(60):
        np.testing.assert_array_equal(rows.observation[rows.live], step.observation[step.live])
        for name in FLAGS:
            np.testing.assert_array_equal(getattr(rows, name), getattr(step, name))
        np.testing.assert_array_equal(rows.reward, step.reward.astype(np.float32))
        np.testing.assert_array_equal(rows.final_observation[step.ended], step.final_observation[step.ended])
        assert rows.episodes["episode_return"].tolist() == step.infos["episode_return"][step.ended].tolist()
        n_waited += (~step.live).sum()
        actions = rng.uniform(-1, 1, (2, 3, 2))
        rows.step(torch.from_numpy(actions))
        step = batch.step(actions)
    assert (n_waited == 0) == respawn


def test_views_are_the_memory_of_the_worlds_and_change_with_the_next_step():
    rows = lone_rows()
    rows.reset(seed=0)
    memory = rows.batch.worlds.episodes.view.observation
    assert rows.observation.data_ptr() == memory.ctypes.data
    held = {name: getattr(rows, name) for name in ("observation", "reward", "final_observation", *FLAGS)}
    copied = rows.observation.clone()
    rows.step(torch.ones(3, 2))
    for name, tensor in held.items():
        assert getattr(rows, name) is tensor
    assert held["reward"].all()
    assert (held["observation"] != copied).any()


def test_copies_on_a_device_outlive_the_next_step():
    rows = lone_rows(device="cpu")
    rows.reset(seed=0)
    held, copied = rows.observation, rows.observation.clone()
    rows.step(torch.ones(3, 2))
    assert torch.equal(held, copied)
    assert not torch.equal(rows.observation, copied)
    assert lone_rows(device="meta").observation.device.type == "meta"


@pytest.mark.parametrize("form", ["dict", "flat"])
def test_other_forms_are_views_too(form):
    task = {"observations": ["goal", {"name": "occupancy_image", "pixels": 16, "metres": 4}], "observation_form": form}
    rows = lone_rows(task=task)
    env = irsim_gym.make_vec(LONE, 3, max_steps=30, task=task)
    rows.reset(seed=1)
    wanted, _ = env.reset(seed=1)
    assert list(rows.observation) == list(wanted)
    for name, tensor in rows.observation.items():
        assert tensor.dtype == (torch.uint8 if name == "occupancy_image" else torch.float32)
        np.testing.assert_array_equal(tensor, wanted[name])


def test_choices_are_whole_numbers():
    rows = lone_rows(task="discrete_navigation")
    rows.reset(seed=0)
    rows.step(torch.tensor([0, 1, 2]))
    assert rows.acted.all()
    with pytest.raises(ValueError, match="whole numbers"):
        rows.step(torch.zeros(3))


def test_worlds_that_do_not_restart_wait_for_it():
    rows = irsim_gym.torch_rows(irsim_gym.make_batch(KNOWN, 2, autoreset=False))
    lone = lone_rows(2, autoreset_mode="Disabled")
    for one, limit, action in ((rows, LIMIT, torch.zeros(2, 3, 2)), (lone, 30, torch.tensor([[-1.0, 0.0]] * 2))):
        one.reset(seed=0)
        for _ in range(limit):
            one.step(action)
        assert one.truncated.any()
        assert not one.live.any()
        one.restart(torch.tensor([1]))
        assert not one.live[0].any()
        assert one.live[1].all()
        assert torch.equal(one.began, one.live)
        assert not (one.truncated | one.acted).any()
        assert one.reward.count_nonzero() == 0


def test_a_mask_resets_some_worlds():
    rows = lone_rows()
    rows.reset(seed=0)
    rows.step(torch.ones(3, 2))
    kept = rows.observation.clone()
    rows.reset(seed=5, options={"reset_mask": np.array([False, True, False])})
    assert rows.began.tolist() == [False, True, False]
    assert torch.equal(rows.observation[[0, 2]], kept[[0, 2]])
    np.testing.assert_array_equal(rows.observation[1], irsim_gym.make(LONE, max_steps=30).reset(seed=6)[0])


def test_what_cannot_be_done_is_said():
    with pytest.raises(IrsimGymError, match=r"autoreset_mode='SameStep'\) or 'Disabled', got 'NextStep'"):
        irsim_gym.torch_rows(irsim_gym.make_vec(LONE))
    with pytest.raises(TypeError, match="without wrappers, got "):
        irsim_gym.torch_rows(irsim_gym.make(LONE))
    rows = lone_rows()
    with pytest.raises(ResetNeeded):
        rows.step(torch.zeros(3, 2))
    rows.reset(seed=0)
    with pytest.raises(ValueError, match=r"must have shape \(3, 2\), got \(3, 3\)"):
        rows.step(torch.zeros(3, 3))
    assert repr(rows) == "<TorchRows sparse_circles: 3 worlds, 1 agent, views>"
