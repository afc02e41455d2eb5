"""skrl: its wrappers, and some steps of its trainers."""

from __future__ import annotations

import numpy as np
import pytest
from needed import library
from scenes import ENDS, FORMS, LIMIT, paid_alone, team

import irsim_gym

ROLLOUTS = 3 * LIMIT
KWARGS = ("learning_rate_scheduler", "observation_preprocessor", "state_preprocessor", "value_preprocessor")


@pytest.fixture(scope="module", autouse=True)
def skrl():
    return library("skrl")


def models(env, uid=None):
    """A policy and a value of one agent, or of the one there is."""
    from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model

    spaces = env.observation_space, env.state_space, env.action_space
    if uid is not None:
        spaces = tuple(space(uid) for space in spaces)
    kwargs = dict(zip(("observation_space", "state_space", "action_space"), spaces, strict=True), device=env.device)
    network = [{"name": "net", "input": "OBSERVATIONS", "layers": [16], "activations": "elu"}]
    policy = gaussian_model(**kwargs, network=network, output="ACTIONS", clip_actions=True)
    value = deterministic_model(**kwargs, network=network, output="ONE")
    for one in (policy, value):
        one.init_state_dict(role="policy" if one is policy else "value")
    return {"policy": policy, "value": value}


def weights(owned):
    return [one.detach().clone() for model in owned.values() for one in model.parameters()]


def changed(before, owned):
    return any((one != other).any() for one, other in zip(before, weights(owned), strict=True))


@pytest.mark.parametrize("form", FORMS)
def test_other_forms(form):
    import torch
    from skrl.envs.wrappers.torch import wrap_env

    env = wrap_env(irsim_gym.parallel_env(team(**FORMS[form]), black_death=True), wrapper="pettingzoo")
    env.reset()
    one = torch.tensor([[3]]) if form == "choices" else torch.zeros(1, 2)
    ended = [any(env.step(dict.fromkeys(env.possible_agents, one))[2].values()) for _ in range(LIMIT)]
    assert ended == [False] * (LIMIT - 1) + [True]


@pytest.mark.parametrize("name", ["IPPO", "MAPPO"])
def test_teams_learn(name):
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.multi_agents.torch import ippo, mappo
    from skrl.trainers.torch import SequentialTrainer

    env = wrap_env(irsim_gym.parallel_env(team(), black_death=True), wrapper="pettingzoo")
    agents = env.possible_agents
    kind = getattr({"IPPO": ippo, "MAPPO": mappo}[name], name)
    owned = {uid: models(env, uid) for uid in agents}
    before = {uid: weights(owned[uid]) for uid in agents}
    memories = {uid: RandomMemory(memory_size=ROLLOUTS, num_envs=1, device=env.device) for uid in agents}
    cfg = {"rollouts": ROLLOUTS, "learning_epochs": 1, "mini_batches": 1, "experiment": {"write_interval": 0}}
    cfg |= {f"{key}_kwargs": {uid: {} for uid in agents} for key in KWARGS}  # skrl 2.1 refuses its own defaults
    learner = kind(
        possible_agents=agents,
        models=owned,
        memories=memories,
        cfg=cfg,
        observation_spaces=env.observation_spaces,
        state_spaces=env.state_spaces,
        action_spaces=env.action_spaces,
        device=env.device,
    )
    SequentialTrainer(
        cfg={"timesteps": ROLLOUTS, "headless": True, "disable_progressbar": True, "close_environment_at_exit": False},
        env=env,
        agents=learner,
    ).train()
    ends = np.arange(LIMIT, ROLLOUTS + 1, LIMIT) - 1
    for uid, memory in memories.items():
        kind_of_end, other = ("truncated", "terminated") if uid == "robot_2" else ("terminated", "truncated")
        flags = memory.get_tensor_by_name(kind_of_end).flatten()
        assert flags.nonzero().flatten().tolist() == ends.tolist()
        assert not memory.get_tensor_by_name(other).any()
        rewards = memory.get_tensor_by_name("rewards")[:LIMIT].flatten().numpy()
        assert not rewards[ENDS[uid] :].any()
        np.testing.assert_allclose(rewards.sum(), paid_alone()[uid], rtol=0.02)
        assert changed(before[uid], owned[uid])


@pytest.mark.parametrize("make", ["make", "make_vec"])
def test_single_robots_learn(make):
    from skrl.agents.torch.ppo import PPO
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.trainers.torch import SequentialTrainer

    given = (3,) if make == "make_vec" else ()
    env = wrap_env(getattr(irsim_gym, make)("empty_goal", *given, max_steps=6), wrapper="gymnasium")
    owned = models(env)
    before = weights(owned)
    memory = RandomMemory(memory_size=12, num_envs=env.num_envs, device=env.device)
    learner = PPO(
        models=owned,
        memory=memory,
        cfg={"rollouts": 12, "learning_epochs": 1, "mini_batches": 1, "experiment": {"write_interval": 0}},
        observation_space=env.observation_space,
        state_space=env.state_space,
        action_space=env.action_space,
        device=env.device,
    )
    SequentialTrainer(
        cfg={"timesteps": 12, "headless": True, "disable_progressbar": True, "close_environment_at_exit": False},
        env=env,
        agents=learner,
    ).train()
    assert memory.get_tensor_by_name("truncated").any()
    assert changed(before, owned)
