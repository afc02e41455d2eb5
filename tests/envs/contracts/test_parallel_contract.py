"""What PettingZoo's tests leave unseen: whole episodes, types, memory, order, copies, and the batch below."""

from __future__ import annotations

import pickle
from copy import deepcopy

import numpy as np
import pytest
from contract_tools import arrays_in, assert_same
from team_scenes import TEAMS, crossing, mixed, towards
from yard import team_yard

import irsim_gym
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.envs.parts.spaces import observation_layout
from irsim_gym.envs.teams.batch import make_batch
from irsim_gym.tasks import Outcome

INFO_TYPES = {
    "outcome": int,
    "hit": int,
    "hit_kind": int,
    "path_length": float,
    "min_clearance": float,
    "goal_distance": float,
    "stalled": float,
    "deadlocked": bool,
    "is_success": bool,
    "steps": int,
    "level": int,
}
FORMS = [{}, {"observation_form": "dict"}, {"action": {"name": "discrete"}}]


def chances(env, rng):
    """Random actions of any kind."""
    if env.worlds.episodes.n_discrete:
        return {name: int(rng.integers(env.action_space(name).n)) for name in env.agents}
    return towards(env, rng)


def episodes(env, count, seed=0):
    """Play whole episodes; yield what reset and step return, and what the environment then says of itself."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        yield env.reset(seed=seed if k == 0 else None), list(env.agents), env.state()
        while env.agents:
            yield env.step(chances(env, rng)), list(env.agents), env.state()


@pytest.mark.parametrize("task", FORMS)
def test_whole_episodes_are_deterministic(task):
    one, two = (irsim_gym.parallel_env(crossing(**task)) for _ in range(2))
    ends = set()
    for here, there in zip(episodes(one, 6), episodes(two, 6), strict=True):
        assert_same(here, there)
        if len(here[0]) == 5:
            ends |= {Outcome(info["outcome"]) for info in here[0][4].values()}
    assert ends >= {Outcome.RUNNING, Outcome.COLLISION, Outcome.TIMEOUT}
    assert Outcome.SUCCESS in ends or "action" in task  # choices lead nowhere


@pytest.mark.parametrize("name", TEAMS)
def test_what_each_step_returns(name):
    """Observations of the space's dtype and in it, Python numbers, fixed keys, agents in their order."""
    env = irsim_gym.parallel_env(name, max_steps=10)
    terms = [f"reward/{name}" for name in env.worlds.episodes.reward_names]
    for answer, agents, state in episodes(env, 2):
        assert agents == [agent for agent in env.possible_agents if agent in set(agents)]
        assert state in env.state_space
        observations, infos = answer[0], answer[-1]
        for agent, observation in observations.items():
            space = env.observation_space(agent)
            assert observation in space
            assert observation.dtype == space.dtype == np.float32
        for info in infos.values():
            assert {key: type(value) for key, value in info.items()} == {**INFO_TYPES, **dict.fromkeys(terms, float)}
        if len(answer) == 5:
            rewards, terminations, truncations = answer[1:4]
            assert all(part.keys() == observations.keys() for part in answer)
            assert {type(value) for value in rewards.values()} == {float}
            assert {type(value) for part in (terminations, truncations) for value in part.values()} == {bool}
            assert not any(terminations[agent] and truncations[agent] for agent in rewards)
            over = {agent for agent in rewards if terminations[agent] or truncations[agent]}
            assert set(agents) == set(rewards) - over


@pytest.mark.parametrize("task", FORMS)
@pytest.mark.parametrize("padded", [False, True])
def test_nothing_is_shared(task, padded):
    """Neither agents nor steps share memory, and what a user writes into it changes nothing."""
    env, twin = (irsim_gym.parallel_env(crossing(**task), padded=padded) for _ in range(2))
    kept = []
    for (answer, agents, state), other in zip(episodes(env, 2), episodes(twin, 2), strict=True):
        assert_same((answer, agents, state), other)
        arrays = list(arrays_in((answer, state)))
        for k, array in enumerate(arrays):
            assert not any(np.shares_memory(array, other) for other in [*arrays[:k], *kept[-20:]])
        for array in arrays:
            array[...] = 7.0
        for part in answer:
            for value in part.values():
                if isinstance(value, dict):
                    value.clear()
            part.clear()
        agents.clear()
        kept += arrays


def test_lists_of_agents_are_new():
    env = irsim_gym.parallel_env(crossing())
    rng = np.random.default_rng(0)
    env.reset(seed=0)
    first, names = env.agents, list(env.possible_agents)
    env.step(towards(env, rng))
    assert env.agents is not first
    first.clear()
    env.reset()
    env.agents.clear()  # as a wrapper might
    assert env.possible_agents == names
    assert env.reset(seed=1)[0].keys() == set(names)


@pytest.mark.parametrize("how", [deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_identically(how):
    env = irsim_gym.parallel_env(crossing(), render_mode="rgb_array")
    rng = np.random.default_rng(3)
    env.reset(seed=5)
    for _ in range(4):
        env.step(towards(env, rng))
    env.render()
    copy = how(env)
    for _ in range(40):
        if not env.agents:
            assert_same(env.reset(), copy.reset())
        actions = towards(env, rng)
        assert_same(env.step(actions), copy.step(actions))
        assert_same(env.agents, copy.agents)
    assert_same(env.render(), copy.render())
    assert env.observation_space("robot_0") is not copy.observation_space("robot_0")


SCENES = [*(crossing(**task) for task in FORMS), mixed(), team_yard()]


@pytest.mark.parametrize("scene", SCENES, ids=["flat", "dict", "discrete", "drives", "pushing"])
def test_equals_a_batch_of_one_and_a_slice_of_many(scene):
    """World ``w`` of a batch is the environment that is reset with ``seed + w``, bit for bit, on any number of threads.

    Actions of agents whose episodes have ended are anything there, and are not asked for here.
    """
    n_worlds, seed, rng = 5, 3, np.random.default_rng(0)
    batches = [Worlds(scene, n_worlds, team=True, num_threads=2), Worlds(scene, 1, team=True)]
    offsets = [0, 2]
    envs = [irsim_gym.parallel_env(scene) for _ in range(n_worlds)]
    for w, env in enumerate(envs):
        env.reset(seed=seed + w)
    for batch, offset in zip(batches, offsets, strict=True):
        begin = [seed + offset + w for w in range(batch.n_worlds)]
        batch.begin(range(batch.n_worlds), begin, [{}] * batch.n_worlds, lambda w: 0)
    size = batches[0].action_space.shape[0] if batches[0].action_space.shape else 2
    restarts = 0
    for _ in range(60):
        given = rng.uniform(-1.0, 1.0, (n_worlds, len(envs[0].possible_agents), size)).astype(np.float32)
        given[..., 0] = np.abs(given[..., 0])
        given[..., 1:] *= 0.4
        if envs[0].worlds.episodes.n_discrete:
            given = rng.integers(envs[0].worlds.episodes.n_discrete, size=given.shape[:2])
        for batch, offset in zip(batches, offsets, strict=True):
            batch.step(given[offset : offset + batch.n_worlds])
        for w, env in enumerate(envs):
            answer = env.step(cut(env, given[w]))
            for batch, offset in zip(batches, offsets, strict=True):
                if 0 <= w - offset < batch.n_worlds:
                    assert_same(answer, row(batch, w - offset, env, answer))
            if not env.agents:
                restarts += 1
                env.reset()
                for batch, offset in zip(batches, offsets, strict=True):
                    if 0 <= w - offset < batch.n_worlds:
                        batch.begin_next(np.array([w - offset]))
    assert restarts >= 2 * n_worlds


def cut(env, actions):
    """The actions of the live agents, each of its own size."""
    chosen = {name: actions[env.possible_agents.index(name)] for name in env.agents}
    if env.worlds.episodes.n_discrete:
        return chosen
    return {name: action[: env.action_space(name).shape[0]] for name, action in chosen.items()}


def masked(env, batch, w, a):
    """What infos of the environment alone hold: which choices an agent has."""
    if not env.worlds.episodes.n_discrete:
        return {}
    return {"action_mask": batch.action_masks()[w, a].astype(np.int8)}


def row(batch, w, env, answer):
    """What a batch says of the agents that are in an environment's answer."""
    view = batch.episodes.view
    indices = {name: env.possible_agents.index(name) for name in answer[0]}
    assert np.flatnonzero(~view.over[w]).tolist() == list(indices.values())
    assert_same(batch.episodes.team_state(np.array([w]))[0], env.state())
    return (
        {name: observation_layout(batch.episodes, a).fresh(view, (w, a)) for name, a in indices.items()},
        {name: view.reward[w, a].item() for name, a in indices.items()},
        {name: view.terminated[w, a].item() for name, a in indices.items()},
        {name: view.truncated[w, a].item() for name, a in indices.items()},
        {name: {**batch.info_of(w, a), **masked(env, batch, w, a)} for name, a in indices.items()},
    )


@pytest.mark.parametrize("scene", [SCENES[0], SCENES[1], crossing(ended="vanish", team_reward=0.2)])
def test_equals_the_batch_for_trainers(scene):
    """``make_batch`` tells the same of each agent, in one space for all; there a world that is over begins anew."""
    n_worlds, seed, rng, restarts = 4, 7, np.random.default_rng(1), 0
    batch = make_batch(scene, n_worlds)
    envs = [irsim_gym.parallel_env(scene, padded=True) for _ in range(n_worlds)]
    begun = batch.reset(seed=seed)
    for w, env in enumerate(envs):
        assert_same(env.reset(seed=seed + w)[0], named(env, begun.observation, w, env.possible_agents))
    for _ in range(60):
        given = rng.uniform(-1.0, 1.0, (n_worlds, len(envs[0].possible_agents), 2))
        given[..., 0] = np.abs(given[..., 0])
        given[..., 1] *= 0.4
        there = batch.step(given)
        for w, env in enumerate(envs):
            names = list(env.agents)
            here = env.step(cut(env, given[w]))
            assert np.array(env.possible_agents)[there.acted[w]].tolist() == names
            assert_same(here[0], named(env, there.final_observation, w, names))
            for part, values in zip(here[1:4], (there.reward, there.terminated, there.truncated), strict=True):
                assert part == named(env, values, w, names)
            for key in set(there.infos) - {"episode_return"}:
                assert {name: info[key] for name, info in here[4].items()} == named(env, there.infos[key], w, names)
            if not env.agents:
                restarts += 1
                assert_same(env.reset()[0], named(env, there.observation, w, env.possible_agents))
            assert np.array(env.possible_agents)[there.live[w]].tolist() == env.agents
    assert restarts >= n_worlds


def named(env, values, w, names):
    """What a batch of arrays, or a dict of them, says of some agents of a world."""
    if isinstance(values, dict):
        parts = {key: named(env, array, w, names) for key, array in values.items()}
        return {name: {key: part[name] for key, part in parts.items()} for name in names}
    return {name: values[w, env.possible_agents.index(name)] for name in names}
