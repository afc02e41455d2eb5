"""Sampling for learnability while something learns: in batches as in single environments, in teams, from files."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
import torch
from contract_tools import STILL
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from team_tools import MEET

from irsim_gym import sb3
from irsim_gym.base.rng import level_stream, stream_base
from irsim_gym.errors import IrsimGymError

N, LIMIT = 4, 12
HOW = {"n_steps": 32, "batch_size": 32, "n_epochs": 1, "seed": 0, "device": "cpu"}


class Begun(BaseCallback):
    """Notes each level that begins, its random stream, and the level that was asked for; in front of the curriculum."""

    def __init__(self, curriculum):
        super().__init__()
        self.curriculum, self.rows = curriculum, []

    def _on_step(self):
        state = self.training_env.unwrapped.worlds.episodes.state
        for w in np.flatnonzero(self.locals["dones"]):
            asked = self.curriculum.levels.following[w]
            self.rows.append((int(state.level[w, 0]), int(state.stream[w]), int(asked)))
        return True


class Ended(BaseCallback):
    """Notes the success of each episode by its level."""

    def __init__(self):
        super().__init__()
        self.success = {}

    def _on_step(self):
        for info in self.locals["infos"]:
            if "is_success" in info:
                self.success.setdefault(info["level"], []).append(float(info["is_success"]))
        return True


def learn(env, steps=600, **own):
    """Learn with a curriculum; return it, and all weights."""
    torch.manual_seed(0)
    curriculum = sb3.LearnabilityCallback(seed=7, **own)
    model = PPO("MlpPolicy", env, **HOW)
    model.learn(steps, callback=curriculum)
    return curriculum.levels, torch.cat([value.flatten() for value in model.policy.state_dict().values()])


def memory(levels):
    return [levels.levels.tolist(), levels.wins.tolist(), levels.plays.tolist(), levels.following.tolist()]


@pytest.mark.parametrize("num_threads", [1, 2])
def test_a_batch_learns_what_single_environments_learn(num_threads):
    native = sb3.make_vec_env(STILL, N, seed=3, max_steps=LIMIT, num_threads=num_threads)
    dummy = DummyVecEnv([lambda: Monitor(gymnasium.make(STILL, max_steps=LIMIT)) for _ in range(N)])
    dummy.seed(3)
    (known, here), (other, there) = (learn(VecNormalize(env)) for env in (native, dummy))
    assert memory(known) == memory(other)
    assert torch.equal(here, there)
    assert known.plays.max() > 2.0


def test_chosen_levels_are_begun_and_belong_to_the_split_train():
    curriculum = sb3.LearnabilityCallback(share=0.6)
    seen = Begun(curriculum)
    PPO("MlpPolicy", sb3.make_vec_env(STILL, N, seed=3, max_steps=LIMIT), **HOW).learn(800, callback=[seen, curriculum])
    base = stream_base("sparse_circles", "train")
    known = set(range(N))  # the seed of the model
    for level, stream, asked in seen.rows:
        assert stream == level_stream(base, level)
        assert level == asked if asked >= 0 else level >= 2**52
        assert asked < 0 or level in known
        known.add(level)
    assert sum(asked >= 0 for *_, asked in seen.rows) > 15


@pytest.mark.parametrize("n_robots", [1, 3])
@pytest.mark.parametrize("team", [{}, {"respawn": True, "world_steps": 20}])
def test_the_success_of_a_team_is_the_mean_over_its_robots(team, n_robots):
    curriculum, ended = sb3.LearnabilityCallback(share=0.0), Ended()
    scenario = {**MEET, "robot": [{**MEET["robot"][0], "number": n_robots}]}
    env = sb3.make_multi_agent_vec_env(scenario, 3, seed=0, max_steps=LIMIT, **team)
    sb3.MaskedPPO("MlpPolicy", env, **HOW).learn(1200, callback=[ended, curriculum])
    known = curriculum.levels
    known.update()
    under_way = {info["level"] for info in env.env_method("info")}
    expected = {level: np.mean(found) for level, found in ended.success.items() if level not in under_way}
    assert len(expected) > 4
    assert known.plays.max() == 1.0  # no level is played again, and a respawn does not begin one
    assert dict(zip(known.levels.tolist(), (known.wins / known.plays).tolist(), strict=True)) == pytest.approx(expected)


def test_levels_of_a_file_are_played_again(tmp_path):
    start, goal = np.zeros((2, 1, 3)), np.full((2, 1, 3), np.nan)
    start[:, 0], goal[:, 0, :2] = [[1, 1, 0], [1, 9, 0]], [9, 5]
    np.savez(tmp_path / "two.npz", bodies=["robot_0"], start=start, goal=goal)
    robot = {"kinematics": {"name": "diff"}, "distribution": {"name": "random"}}
    env = sb3.make_vec_env({"robot": robot, "levels": str(tmp_path / "two.npz")}, N, seed=3, max_steps=LIMIT)
    curriculum = sb3.LearnabilityCallback(share=0.5)
    seen = Begun(curriculum)
    PPO("MlpPolicy", env, **HOW).learn(400, callback=[seen, curriculum])
    assert all(level == asked for level, _, asked in seen.rows if asked >= 0)
    assert sorted(curriculum.levels.levels) == [0, 1]
    assert sum(asked >= 0 for *_, asked in seen.rows) > 5


def test_training_goes_on_with_the_same_callback():
    env = sb3.make_vec_env(STILL, N, seed=3, max_steps=LIMIT)
    curriculum = sb3.LearnabilityCallback()
    for _ in range(2):
        PPO("MlpPolicy", env, **HOW).learn(256, callback=curriculum)
    assert curriculum.levels.plays.sum() > 20
    later = sb3.LearnabilityCallback(levels=curriculum.levels)
    PPO("MlpPolicy", env, **HOW).learn(128, callback=later)
    with pytest.raises(IrsimGymError, match="'levels' are of 4 worlds, but there are 2"):
        PPO("MlpPolicy", sb3.make_vec_env(STILL, 2), **HOW).learn(64, callback=later)


def test_environments_of_others_are_refused():
    model = PPO("MlpPolicy", make_vec_env("CartPole-v1"), **HOW)
    with pytest.raises(IrsimGymError, match="is no environment of irsim_gym"):
        model.learn(64, callback=sb3.LearnabilityCallback())
