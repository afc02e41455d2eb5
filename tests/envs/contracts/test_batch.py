"""Teams as arrays: ``irsim_gym.make_batch``."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from contract_tools import arrays_in
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from team_tools import ARRIVES, COLLIDES, KNOWN, LIMIT, MEET

import irsim_gym
from irsim_gym.tasks import Outcome

STILL = np.zeros((2, 3, 2))
LENGTHS = np.array([ARRIVES, COLLIDES, LIMIT])


def drawn(rng, batch):
    return rng.uniform(-1, 1, (batch.n_worlds, batch.n_agents, 2))


def test_a_team_of_one_is_the_vector_environment():
    batch = irsim_gym.make_batch("sparse_circles", 3, max_steps=30)
    env = irsim_gym.make_vec("sparse_circles", 3, max_steps=30, autoreset_mode=AutoresetMode.SAME_STEP)
    step, rng, ends = batch.reset(seed=7), np.random.default_rng(0), 0
    np.testing.assert_array_equal(step.observation[:, 0], env.reset(seed=7)[0])
    for _ in range(100):
        actions = rng.uniform(-1, 1, (3, 2)) * [0.2, 1.0] + [0.8, 0.0]
        step = batch.step(actions[:, None])
        observations, rewards, terminated, truncated, infos = env.step(actions)
        for mine, theirs in (
            (step.observation, observations),
            (step.reward, rewards),
            (step.terminated, terminated),
            (step.truncated, truncated & ~terminated),
        ):
            np.testing.assert_array_equal(mine[:, 0], theirs)
        assert step.acted.all()
        assert step.live.all()
        for w in np.flatnonzero(step.ended[:, 0]).tolist():
            ends += 1
            np.testing.assert_array_equal(step.final_observation[w, 0], infos["final_obs"][w])
            assert step.infos["outcome"][w, 0] == infos["final_info"]["outcome"][w]
            assert step.infos["path_length"][w, 0] == infos["final_info"]["path_length"][w]
    assert ends > 5


def test_who_acts_lives_and_begins_in_a_task_of_known_ends():
    batch = irsim_gym.make_batch(KNOWN, 2)
    first = batch.reset(seed=0)
    assert first.began.all()
    assert first.live.all()
    assert not (first.acted | first.ended).any()
    for n in range(1, 3 * LIMIT):
        step, age = batch.step(STILL), (n - 1) % LIMIT + 1
        restarts = age == LIMIT
        np.testing.assert_array_equal(step.acted, np.tile(age <= LENGTHS, (2, 1)))
        np.testing.assert_array_equal(step.ended, np.tile(age == LENGTHS, (2, 1)))
        np.testing.assert_array_equal(step.truncated, np.tile([False, False, restarts], (2, 1)))
        np.testing.assert_array_equal(step.live, np.tile((age < LENGTHS) | restarts, (2, 1)))
        assert step.began.all() == restarts == step.began.any()
        np.testing.assert_array_equal(step.reward, np.where(step.acted, -1.0, 0.0))
        np.testing.assert_array_equal(step.infos["episode_return"][0], -np.minimum(age, LENGTHS))
        np.testing.assert_array_equal(step.infos["steps"][0], np.minimum(age, LENGTHS))
        expected = [Outcome.SUCCESS, Outcome.COLLISION, Outcome.TIMEOUT]
        assert step.infos["outcome"][0].tolist() == [
            o if age >= k else Outcome.RUNNING for o, k in zip(expected, LENGTHS, strict=True)
        ]
        if restarts:
            np.testing.assert_array_equal(step.observation, first.observation)
            assert (step.final_observation != first.observation).any(axis=-1).all()
        else:
            np.testing.assert_array_equal(step.observation, step.final_observation)


def test_a_batch_that_does_not_restart_by_itself():
    batch = irsim_gym.make_batch(KNOWN, 2, autoreset=False)
    first = batch.reset(seed=0)
    for _ in range(LIMIT):
        step = batch.step(STILL)
    assert not step.live.any()
    last = batch.step(STILL)
    assert not last.acted.any()
    np.testing.assert_array_equal(last.observation, step.observation)
    begun = batch.restart(np.array([1]))
    assert begun.began.tolist() == begun.live.tolist() == [[False] * 3, [True] * 3]
    np.testing.assert_array_equal(begun.observation[1], first.observation[1])
    np.testing.assert_array_equal(begun.observation[0], last.observation[0])
    assert batch.step(STILL).acted.tolist() == [[False] * 3, [True] * 3]


def test_a_restart_pays_nothing_and_takes_indices_of_worlds_that_have_begun():
    batch = irsim_gym.make_batch(KNOWN, 2, autoreset=False)
    with pytest.raises(ResetNeeded):
        batch.restart(np.array([1]))
    batch.reset(seed=0)
    assert batch.step(STILL).reward_terms.any()
    assert not batch.restart(np.array([1])).reward_terms.any()
    with pytest.raises(ValueError, match="indices"):
        batch.restart(np.array([False, True]))
    assert not batch.restart([]).began.any()


def test_respawned_agents_live_on_and_worlds_last_four_time_limits():
    batch = irsim_gym.make_batch(KNOWN, 2, respawn=True)
    batch.reset(seed=0)
    for n in range(1, 4 * LIMIT):
        step = batch.step(STILL)
        assert step.acted.all()
        assert step.live.all()
        np.testing.assert_array_equal(step.ended, np.tile(n % LENGTHS == 0, (2, 1)))
        np.testing.assert_array_equal(step.began, step.ended)
    level = step.infos["level"][0, 0]
    assert step.infos["level"][1, 0] != level
    step = batch.step(STILL)  # the 48th: agents 0 and 2 end by themselves, agent 1 is cut with its world
    assert step.ended.all()
    assert step.terminated.tolist() == [[True, False, False]] * 2
    assert step.truncated.tolist() == [[False, True, True]] * 2
    assert step.infos["outcome"][0].tolist() == [Outcome.SUCCESS, Outcome.RUNNING, Outcome.TIMEOUT]
    assert batch.step(STILL).infos["level"][0, 0] != level


def test_the_state_of_the_team_comes_with_each_step():
    batch = irsim_gym.make_batch(MEET, 2, max_steps=10)
    step, rng = batch.reset(seed=0), np.random.default_rng(0)
    for _ in range(25):
        before = step
        step = batch.step(drawn(rng, batch))
        assert step.state.shape == (2, batch.state_size) == (2, batch.worlds.episodes.team_state_size)
        assert step.state.dtype == np.float32
        assert np.abs(step.state).max() <= 1.0
        np.testing.assert_array_equal(step.state, batch.worlds.episodes.team_state())
        began = step.began.any(axis=1)
        np.testing.assert_array_equal((step.state != step.final_state).any(axis=1), began)
        assert (step.final_state != before.state).any()
    assert irsim_gym.make_batch(MEET, 2, team_state=False).reset().state.shape == (2, 0)


@pytest.mark.parametrize("respawn", [False, True])
def test_arrays_are_fresh(respawn):
    batch = irsim_gym.make_batch(MEET, 2, max_steps=3, respawn=respawn)
    rng = np.random.default_rng(0)
    steps = [batch.reset(seed=0), *(batch.step(drawn(rng, batch)) for _ in range(8))]
    live = [*arrays_in(vars(batch.worlds.episodes.view)), *arrays_in(vars(batch)), batch.worlds.simulation.state.pose]
    arrays = [array for step in steps for array in arrays_in([*vars(step).values()])]
    assert len(arrays) > 9 * 12
    for k, one in enumerate(arrays):
        assert not any(np.shares_memory(one, other) for other in [*arrays[k + 1 :], *live])


def test_dict_observations_discrete_actions_and_parameters():
    task = {"observation_form": "dict", "action": {"name": "discrete", "linear": 2, "angular": 3}}
    batch = irsim_gym.make_batch("circle_swap", 2, task=task, n_robots=3)
    step = batch.reset(seed=0)
    assert set(step.observation) == set(batch.observation_space.spaces)
    assert step.observation["goal"].shape[:2] == (2, 3)
    step = batch.step(np.array([[0, 5, 2], [1, 1, 1]]))
    assert step.final_observation["goal"].shape == step.observation["goal"].shape
    assert step.reward_terms.shape == (2, 3, len(batch.worlds.episodes.reward_names))
    with pytest.raises(ValueError, match="choice"):
        batch.step(np.full((2, 3), 6))


def test_seeds_levels_and_errors():
    batch = irsim_gym.make_batch(MEET, 2)
    with pytest.raises(ResetNeeded):
        batch.step(STILL)
    one = batch.reset(seed=4)
    assert one.infos["level"].tolist() == [[4] * 3, [5] * 3]
    assert (batch.reset().observation != one.observation).any()
    np.testing.assert_array_equal(batch.reset(seed=[4, 5]).observation, one.observation)
    dev = batch.reset(options={"split": "dev", "level": 2})
    np.testing.assert_array_equal(dev.observation[0], dev.observation[1])
    with pytest.raises(ValueError, match="shape"):
        batch.step(STILL[:, :2])
    with pytest.raises(ValueError, match="each of the 2 worlds, got 1"):
        batch.reset(seed=[4])
    with pytest.raises(ValueError, match="autoreset"):
        irsim_gym.make_batch(MEET, autoreset=False, respawn=True)
    with pytest.raises(ValueError, match="world_steps"):
        irsim_gym.make_batch(MEET, world_steps=3)
    assert irsim_gym.make_batch(MEET, max_steps=25, respawn=True).world_steps == 4 * 25
    assert dataclasses.is_dataclass(one)


def test_the_batch_is_the_parallel_environment_many_times():
    batch = irsim_gym.make_batch(MEET, 2, max_steps=20, autoreset=False)
    envs = [irsim_gym.parallel_env(MEET, max_cycles=20) for _ in range(2)]
    step, rng, ended = batch.reset(seed=3), np.random.default_rng(0), 0
    names = list(batch.agent_names)
    for w, env in enumerate(envs):
        observations, _ = env.reset(seed=3 + w)
        assert env.possible_agents == names
        np.testing.assert_array_equal(step.observation[w], [observations[name] for name in names])
    while step.live.any():
        actions = drawn(rng, batch).astype(np.float32)
        step = batch.step(actions)
        for w, env in enumerate(envs):
            live = list(env.agents)
            assert [name for a, name in enumerate(names) if step.acted[w, a]] == live
            given = {name: actions[w, names.index(name)] for name in live}
            observations, rewards, terminations, truncations, infos = env.step(given) if live else [{}] * 5
            for a in map(names.index, live):
                name = names[a]
                np.testing.assert_array_equal(step.observation[w, a], observations[name])
                assert (step.reward[w, a], step.terminated[w, a]) == (rewards[name], terminations[name])
                assert step.ended[w, a] == (terminations[name] or truncations[name])
                assert step.infos["path_length"][w, a] == infos[name]["path_length"]
                ended += step.ended[w, a]
    assert ended == 6
