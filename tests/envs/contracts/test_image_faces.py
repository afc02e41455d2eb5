"""Pictures as observations in every environment: spaces, copies, who waits, and the same bits everywhere."""

from __future__ import annotations

import copy
import hashlib
import os
import pickle
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from contract_tools import arrays_in, assert_same, forward_actions
from gymnasium.spaces import Box, Dict
from gymnasium.utils import env_checker
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import FrameStackObservation, GrayscaleObservation, NormalizeObservation
from pettingzoo.utils.conversions import parallel_to_aec
from stable_baselines3.common import env_checker as sb3_env_checker
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from team_scenes import crossing, mixed
from team_tools import MEET

import irsim_gym
from irsim_gym import sb3
from irsim_gym.base.kernels import config
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv
from irsim_gym.envs.teams.parallel import WorldParallelEnv
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes, load_task

NAME = "sparse_circles"
IMAGE = {"name": "occupancy_image", "pixels": 36}
VIEW = {"name": "seen_map_image", "pixels": 36}
SCAN = {"name": "occupancy_image", "pixels": 16, "from_scan": True, "robot_channel": True, "rotated": False}
BASE = {
    "name": "blank",
    "rewards": [{"name": "progress"}, {"name": "arrival"}, {"name": "collision"}],
    "endings": ["arrived", "collided", "left_world"],
}
ALONE = {**BASE, "observations": [IMAGE]}
BESIDE = {**BASE, "observations": ["goal", IMAGE, "velocity"]}
TWO = {**BASE, "observations": [IMAGE, VIEW]}
NAMED = {**BESIDE, "observation_form": "dict"}
TASKS = [ALONE, BESIDE, TWO, NAMED]
TASK_NAMES = ["alone", "beside", "two", "named"]
every = pytest.mark.parametrize("task", TASKS, ids=TASK_NAMES)
PICTURE = Box(0, 255, (36, 36, 2), np.uint8)


def test_spaces():
    assert WorldEnv(NAME, ALONE).observation_space == PICTURE
    beside = WorldEnv(NAME, BESIDE).observation_space
    flat = WorldEnv(NAME, {**BASE, "observations": ["goal", "velocity"]}).observation_space
    assert beside == Dict({"occupancy_image": PICTURE, "vector": flat})
    assert WorldEnv(NAME, TWO).observation_space == Dict({"occupancy_image": PICTURE, "seen_map_image": PICTURE})
    named = WorldEnv(NAME, NAMED).observation_space
    assert list(named) == ["goal", "occupancy_image", "velocity"]
    assert WorldEnv(NAME, {**ALONE, "observation_form": "dict"}).observation_space == Dict({"occupancy_image": PICTURE})


@every
def test_checkers(task):
    env = WorldEnv(NAME, task)
    env_checker.check_env(env, skip_render_check=True)
    sb3_env_checker.check_env(env, warn=True)


@every
def test_a_picture_is_a_part_of_the_rest(task):
    """What stands beside a picture is what stands there without it, and pictures do not depend on what is beside."""
    seen, _ = WorldEnv(NAME, task).reset(seed=3)
    alone, _ = WorldEnv(NAME, ALONE).reset(seed=3)
    np.testing.assert_array_equal(seen if task is ALONE else seen["occupancy_image"], alone)
    if "vector" in task or task is BESIDE:
        vector, _ = WorldEnv(NAME, {**BASE, "observations": ["goal", "velocity"]}).reset(seed=3)
        np.testing.assert_array_equal(seen["vector"], vector)


@every
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_the_batch_equals_single_environments(task, mode):
    n = 3
    native = WorldVectorEnv(NAME, n, task, max_steps=12, autoreset_mode=mode)
    sync = SyncVectorEnv([lambda: WorldEnv(NAME, task, max_steps=12)] * n, autoreset_mode=mode)
    assert native.observation_space == sync.observation_space
    rng, ends, results = np.random.default_rng(0), 0, []
    assert_same(native.reset(seed=5), sync.reset(seed=5))
    for _ in range(40):
        actions = forward_actions(rng, native.action_space.shape)
        here, there = native.step(actions), sync.step(actions)
        assert_same(here, there)
        assert here[0] in native.observation_space
        results.append((here, copy.deepcopy(here)))
        ended = here[2] | here[3]
        ends += ended.sum()
        if mode is AutoresetMode.DISABLED and ended.any():
            assert_same(*[env.reset(options={"reset_mask": ended.copy()}) for env in (native, sync)])
    assert ends > 5
    for kept, copied in results:
        assert_same(kept, copied)


@every
def test_a_copied_environment_goes_on_alike(task):
    env = WorldEnv(NAME, task, max_steps=30)
    env.reset(seed=2)
    rng = np.random.default_rng(0)
    for _ in range(5):
        env.step(forward_actions(rng, (2,)))
    twins = [pickle.loads(pickle.dumps(env)), copy.deepcopy(env)]
    seen = []
    for _ in range(5):
        action = forward_actions(rng, (2,))
        here = env.step(action)
        for twin in twins:
            assert_same(twin.step(action), here)
        seen.append(here[0] if task is ALONE else here[0]["occupancy_image"])
    assert (seen[0] != seen[-1]).any()


def test_wrappers_of_gymnasium():
    env = FrameStackObservation(WorldEnv(NAME, ALONE), 3)
    seen, _ = env.reset(seed=1)
    assert seen.shape == (3, 36, 36, 2)
    env.step(np.array([1.0, 0.0], np.float32))
    gray = GrayscaleObservation(WorldEnv(NAME, {**BASE, "observations": [{**IMAGE, "robot_channel": True}]}))
    assert gray.reset(seed=1)[0].shape == (36, 36)
    normal = NormalizeObservation(WorldEnv(NAME, ALONE))
    assert normal.reset(seed=1)[0].dtype == np.float32


def in_each_world(task: Any, steps: int = 15, **more: Any) -> list[np.ndarray]:
    """Return copies of all pictures of a rollout."""
    scenario = load_scenario(MEET)
    loaded = load_task(scenario, task, team=True)
    fused, threads = more.get("fused", True), more.get("num_threads", 1)
    simulation = compile(scenario, 6, agents=loaded.agents, num_threads=threads, fused=fused)
    episodes, rng = Episodes(simulation, loaded), np.random.default_rng(1)
    episodes.begin(np.arange(6), np.arange(6))
    assert episodes._play.is_fusable is (fused and not config.DISABLE_JIT)
    found = []
    for _ in range(steps):
        episodes.step(rng.uniform(-1, 1, (6, 3, 2)))
        found += [image.copy() for image in episodes.view.images.values()]
    return found


PAINTED = {**BASE, "observations": [SCAN, {**VIEW, "rotated": False}]}


def test_recorded_steps_threads_and_plain_steps_give_the_same_bits():
    usual = in_each_world(PAINTED)
    assert any(image.any() for image in usual)
    for other in (in_each_world(PAINTED, fused=False), in_each_world(PAINTED, num_threads=3)):
        assert_same(usual, other)


def test_plain_python_gives_the_same_bits():
    code = (
        "import sys; sys.path.insert(0, sys.argv[1]); import test_image_faces as t;"
        "print(t.digest(t.in_each_world(t.TINY, 2)))"
    )
    environ = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-W", "ignore", "-c", code, str(Path(__file__).parent)]
    told = subprocess.run(command, env=environ, capture_output=True, text=True, check=True).stdout
    assert told.strip() == digest(in_each_world(TINY, 2))


def digest(images: list[np.ndarray]) -> str:
    """Return a text that differs where one bit does."""
    return hashlib.sha256(b"".join(image.tobytes() for image in images)).hexdigest()


TINY = {**BASE, "observations": [{**SCAN, "pixels": 8}, {**VIEW, "pixels": 8}]}


@every
def test_stable_baselines_sees_what_single_environments_see(task):
    native = sb3.make_vec_env(NAME, 3, 7, task=task, max_steps=9)
    singles = DummyVecEnv([lambda: WorldEnv(NAME, task, max_steps=9)] * 3)
    singles.seed(7)
    assert native.observation_space == singles.observation_space
    assert_same(dict_of(native.reset()), dict_of(singles.reset()))
    rng, ends, results = np.random.default_rng(0), 0, []
    for _ in range(30):
        actions = forward_actions(rng, (3, 2))
        seen, _, dones, infos = native.step(actions)
        there, _, _, others = singles.step(actions)
        assert_same(dict_of(seen), dict_of(there))
        for w in np.flatnonzero(dones):
            ends += 1
            assert infos[w]["terminal_observation"] in native.observation_space
            assert_same(infos[w]["terminal_observation"], others[w]["terminal_observation"])
        results.append((seen, infos))
    assert ends >= 9
    arrays = [list(arrays_in(result)) for result in results]
    live = [native.worlds.episodes.view.observation, *native.worlds.episodes.view.images.values()]
    for k, mine in enumerate(arrays):
        others = [array for result in arrays[k + 1 :] for array in result] + live
        assert not any(np.shares_memory(one, other) for one in mine for other in others)


def dict_of(observation: Any) -> dict[str, np.ndarray]:
    """Return an observation as a plain dict."""
    return dict(observation) if isinstance(observation, dict) else {"": observation}


TEAM = {**BASE, "observations": ["goal", {**SCAN, "pixels": 16}], "max_steps": 15}


def test_who_waits_keeps_its_last_picture():
    batch = irsim_gym.make_batch(MEET, 2, task={**TEAM, "max_steps": 40})
    batch.reset(seed=1)
    rng, last, waited = np.random.default_rng(0), {}, 0
    for _ in range(60):
        step = batch.step(forward_actions(rng, (2, 3, 2)))
        assert step.observation["occupancy_image"].shape == (2, 3, 16, 16, 3)
        for w, a in np.argwhere(step.ended):
            last[w, a] = {name: values[w, a].copy() for name, values in step.final_observation.items()}
        for w, a in np.argwhere(~step.live):
            waited += 1
            for name, values in step.observation.items():
                np.testing.assert_array_equal(values[w, a], last[w, a][name])
    assert waited > 10


@pytest.mark.filterwarnings("ignore::irsim_gym.errors.WaitingRobotsWarning")
@pytest.mark.parametrize("respawn", [False, True])
def test_slots_of_a_team(respawn):
    env = sb3.make_multi_agent_vec_env(MEET, 2, 3, task=TEAM, respawn=respawn)
    batch = irsim_gym.make_batch(MEET, 2, task=TEAM, respawn=respawn)
    assert env.observation_space["occupancy_image"].shape == (16, 16, 3)
    seen, begun = env.reset(), batch.reset(seed=3)
    rng, ends = np.random.default_rng(0), 0
    for _ in range(40):
        np.testing.assert_array_equal(
            seen["occupancy_image"], begun.observation["occupancy_image"].reshape(6, 16, 16, 3)
        )
        assert {name: values[0] for name, values in seen.items()} in env.observation_space
        actions = forward_actions(rng, (6, 2))
        (seen, _, dones, infos), begun = env.step(actions), batch.step(actions.reshape(2, 3, 2))
        for slot in np.flatnonzero(dones):
            ends += 1
            w, a = divmod(slot, 3)
            np.testing.assert_array_equal(
                infos[slot]["terminal_observation"]["occupancy_image"], begun.final_observation["occupancy_image"][w, a]
            )
    assert ends > 5


DICTS = pytest.mark.filterwarnings(
    "ignore:Observation(s)? (space for each agent probably|is not a NumPy):UserWarning"
)  # PettingZoo's tests would rather see arrays


@pytest.mark.parametrize(
    "observations", [pytest.param([IMAGE], id="picture"), pytest.param(["goal", IMAGE], id="dict", marks=DICTS)]
)
def test_parallel_environments(observations):
    with warnings.catch_warnings():  # with pytest at hand, PettingZoo's tests import a game in a deprecated way
        warnings.filterwarnings("ignore", ".*connect_four.*", DeprecationWarning)
        from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test

    scene = crossing(**{**BASE, "observations": observations})
    parallel_api_test(irsim_gym.parallel_env(scene), 12)
    parallel_seed_test(lambda: irsim_gym.parallel_env(scene), 12)
    api_test(parallel_to_aec(irsim_gym.parallel_env(scene)), 12)
    env: WorldParallelEnv = irsim_gym.parallel_env(scene)
    seen, _ = env.reset(seed=1)
    assert all(seen[agent] in env.observation_space(agent) for agent in env.agents)


def test_drives_of_different_size_see_the_same_pictures():
    env = irsim_gym.parallel_env(mixed(observations=["velocity", IMAGE]))
    seen, _ = env.reset(seed=1)
    sizes = {values["vector"].size for values in seen.values()}
    assert len(sizes) > 1
    assert {values["occupancy_image"].shape for values in seen.values()} == {(36, 36, 2)}
    assert all(seen[agent] in env.observation_space(agent) for agent in env.agents)


SMALL = {"n_steps": 8, "batch_size": 24, "n_epochs": 1, "device": "cpu"}


def test_teams_learn_from_pictures():
    picture = {**TEAM, "observations": [{**IMAGE, "robot_channel": True}]}
    for task in (picture, {**TEAM, "observations": ["goal", {**IMAGE, "goal_channel": False}]}):
        env = sb3.make_multi_agent_vec_env(MEET, 2, 3, task=task)
        kind = "MultiInputPolicy" if isinstance(env.observation_space, Dict) else "CnnPolicy"
        policy = {"features_extractor_kwargs": {("cnn_output_dim" if kind[0] == "M" else "features_dim"): 16}}
        sb3.MaskedPPO(kind, env, policy_kwargs=policy, **SMALL).learn(48)
    sb3.GruPPO("MultiInputGruPolicy", env, policy_kwargs={**policy, "memory_size": 8}, **SMALL).learn(48)


@pytest.mark.filterwarnings("ignore::irsim_gym.errors.WaitingRobotsWarning")
def test_pictures_are_left_as_they_are_where_numbers_are_normalised():
    env = sb3.make_multi_agent_vec_env(MEET, 2, 3, task=TEAM)
    twin = sb3.make_multi_agent_vec_env(MEET, 2, 3, task=TEAM)
    normal = sb3.MaskedVecNormalize(env, norm_obs_keys=["vector"])
    assert isinstance(normal, VecNormalize)
    seen, plain = normal.reset(), twin.reset()
    for _ in range(20):
        np.testing.assert_array_equal(seen["occupancy_image"], plain["occupancy_image"])
        assert seen["occupancy_image"].dtype == np.uint8
        actions = np.full((6, 2), 0.5, np.float32)
        seen, plain = normal.step(actions)[0], twin.step(actions)[0]
    assert np.abs(seen["vector"] - plain["vector"]).max() > 0.1


def test_registered_environments_take_such_tasks():
    env = gymnasium.make("irsim_gym/cave-v0", task={"name": "blank", "observations": [VIEW]})
    seen, _ = env.reset(seed=0)
    assert seen in env.observation_space
    assert len(np.unique(seen.reshape(-1, 3), axis=0)) > 5
