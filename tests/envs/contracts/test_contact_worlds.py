"""Worlds in which bodies push each other: the same bits on every face, alone and in a batch, drawn and from files."""

from __future__ import annotations

from pathlib import Path

import gymnasium
import numpy as np
import pytest
from contract_tools import assert_same, forward_actions
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from stable_baselines3.common.vec_env import DummyVecEnv
from yard import ANYWHERE, YARD, team_yard

import irsim_gym as ig
from irsim_gym.evaluation.levels.certify import certify
from irsim_gym.evaluation.levels.draw import draw_levels
from irsim_gym.evaluation.requests.episode_setup import make_episodes

N, STEPS = 3, 90


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_a_batch_on_threads_equals_single_environments(mode: AutoresetMode) -> None:
    """World ``w`` is the environment that is reset with ``seed + w``, bit for bit, while its robot pushes."""
    native = ig.make_vec(YARD, num_envs=N, num_threads=2, autoreset_mode=mode)
    sync = SyncVectorEnv([lambda: ig.make(YARD)] * N, autoreset_mode=mode)
    rng, ended = np.random.default_rng(0), 0
    assert_same(native.reset(seed=4), sync.reset(seed=4))
    pushed = False
    for _ in range(STEPS):
        actions = forward_actions(rng, (N, 2))
        here, there = native.step(actions), sync.step(actions)
        assert_same(here, there)
        pushed = pushed or bool(native.unwrapped.worlds.simulation.parts.pushing.felt["touches"][:, 0].any())
        over = here[2] | here[3]
        ended += int(over.sum())
        if mode is AutoresetMode.DISABLED and over.any():
            assert_same(*[env.reset(options={"reset_mask": over.copy()}) for env in (native, sync)])
    assert ended >= 2 * N
    assert pushed


def test_stable_baselines_gets_the_same() -> None:
    native, dummy = ig.sb3.make_vec_env(YARD, N), DummyVecEnv([lambda: ig.make(YARD)] * N)
    for env in (native, dummy):
        env.seed(4)
    assert_same(native.reset(), dummy.reset())
    rng = np.random.default_rng(0)
    for _ in range(STEPS):
        actions = forward_actions(rng, (N, 2))
        here, there = native.step(actions), dummy.step(actions)
        for one, other in zip(here[:3], there[:3], strict=True):
            np.testing.assert_array_equal(one, other)


def test_fog_lifts_alike_and_stays_where_nobody_looked() -> None:
    """What a batch has seen of each world is what its single environment has seen."""
    native, singles = ig.make_vec(YARD, num_envs=N), [ig.make(YARD) for _ in range(N)]
    native.reset(seed=8)
    for w, env in enumerate(singles):
        env.reset(seed=8 + w)
    actions = np.tile(np.float32([0.8, 0.2]), (N, 1))
    for _ in range(20):
        native.step(actions)
        for env in singles:
            env.step(actions[0])
    seen = native.unwrapped.worlds.simulation.explored
    for w, env in enumerate(singles):
        np.testing.assert_array_equal(seen[w], env.unwrapped.worlds.simulation.explored[0])
    assert 0 < seen.mean() < 1


def test_pettingzoo_repeats_its_episodes() -> None:
    one, other = ig.parallel_env(team_yard()), ig.parallel_env(team_yard())
    rng = np.random.default_rng(1)
    assert_same(one.reset(seed=2), other.reset(seed=2))
    for _ in range(STEPS):
        if not one.agents:
            assert_same(one.reset(), other.reset())
        actions = {agent: np.float32(rng.uniform([0, -1], 1)) for agent in one.agents}
        assert_same(one.step(actions), other.step(actions))


@pytest.mark.parametrize("name", ["yard", "push_box", "clear_doorway"])
def test_levels_from_a_file_are_the_drawn_ones(name: str, tmp_path: Path) -> None:
    """Places, targets, outlines, masses, velocities and maps of a level come from its file as they were drawn."""
    data = YARD if name == "yard" else ig.load_scenario(name).source.data
    data = {key: value for key, value in data.items() if key != "parameters"}
    episodes = make_episodes(data, n_worlds=8)
    (tmp_path / "levels.npz").write_bytes(draw_levels(episodes.simulation, ["test"], 8).content())
    rows = []
    for given in (data, {**data, "levels": str(tmp_path / "levels.npz")}):
        envs, rng = ig.make_vec(given, num_envs=N), np.random.default_rng(0)
        rows.append([envs.reset(seed=5, options={"split": "test"})])
        rows[-1] += [envs.step(forward_actions(rng, (N, 2))) for _ in range(39)]
    assert_same(*rows)


@pytest.mark.parametrize("name", ["push_box", "clear_doorway"])
def test_shipped_worlds_are_the_same_alone(name: str) -> None:
    env_id = f"irsim_gym/{name}-v0"
    native = gymnasium.make_vec(env_id, num_envs=N, max_steps=50)
    sync = gymnasium.make_vec(env_id, num_envs=N, vectorization_mode="sync", max_steps=50)
    assert_same(native.reset(seed=0), sync.reset(seed=0))
    rng = np.random.default_rng(0)
    for _ in range(STEPS):
        actions = forward_actions(rng, (N, 2))
        assert_same(native.step(actions), sync.step(actions))


def test_certificates_measure_ways_past_bodies_that_can_be_pushed() -> None:
    """A box in the door of a wall: the way leads through it if it can be pushed, and else through another, far door."""
    walls = [{"shape": {"name": "linestring", "vertices": ends}} for ends in ([[5, 0], [5, 3.5]], [[5, 4.5], [5, 7]])]
    low, high = {"range_low": [1, 3.8, -3.1], "range_high": [2, 4.2, 3.1]}, {"goal_low": [8, 3.8, -3.1]}
    place = {**ANYWHERE, **low, **high, "goal_high": [9, 4.2, 3.1]}
    lengths = []
    for mass in (1, "inf"):
        box = {"shape": {"name": "rectangle", "length": 0.5, "width": 0.9}, "state": [5, 4, 0], "mass": mass}
        data = {
            "world": {"width": 10, "height": 8, "collision_mode": "contact"},
            "robot": {**YARD["robot"], "distribution": place}, "obstacle": [*walls, box],
            "task": {"name": "navigation"},
        }  # fmt: skip
        made = certify(make_episodes(data), "test", 5, {})
        assert made.reachable.all()
        lengths.append(made.length)
    assert (lengths[0] < 8.2).all()
    # From y = 4 up to the end of the wall at y = 7 and back, 3 m ahead of it and behind it.
    assert (lengths[1] > 2 * np.hypot(3, 2.8)).all()
