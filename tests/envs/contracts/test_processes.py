"""Environments in other processes, by every start method."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from contract_tools import STILL, assert_same, forward_actions
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

BY_MODULE = f"irsim_gym:{STILL}"
KWARGS = {"max_steps": 15}
METHODS = ["fork", "forkserver", pytest.param("spawn", marks=pytest.mark.slow)]
"""The defaults of Python before 3.14 and since; processes that are spawned import all anew, as those of a server do."""


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_async_vector_env(method):
    envs = gymnasium.make_vec(
        BY_MODULE, num_envs=2, vectorization_mode="async", vector_kwargs={"context": method}, **KWARGS
    )
    native = gymnasium.make_vec(STILL, num_envs=2, num_threads=2, **KWARGS)
    try:
        assert_same(envs.reset(seed=2), native.reset(seed=2))
        rng = np.random.default_rng(0)
        for _ in range(40):
            actions = forward_actions(rng, (2, 2))
            assert_same(envs.step(actions), native.step(actions))
    finally:
        envs.close()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_subproc_vec_env(method):
    made = [
        make_vec_env(BY_MODULE, 2, seed=1, vec_env_cls=cls, env_kwargs=KWARGS, vec_env_kwargs=options)
        for cls, options in ((SubprocVecEnv, {"start_method": method}), (DummyVecEnv, {}))
    ]
    try:
        assert_same(*[env.reset() for env in made])
        rng = np.random.default_rng(0)
        for _ in range(30):
            actions = forward_actions(rng, (2, 2))
            here, there = (env.step(actions) for env in made)
            assert_same((here[0], here[1].astype(np.float32), here[2]), there[:3])
    finally:
        for env in made:
            env.close()


def in_child(envs, queue):
    """Step an environment that the parent has used with threads."""
    queue.put(envs.step(np.zeros((4, 2), np.float32))[0])


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_threads_after_a_fork():
    envs = gymnasium.make_vec(STILL, num_envs=4, num_threads=2)
    envs.reset(seed=0)
    envs.step(np.zeros((4, 2), np.float32))
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=in_child, args=(envs, queue))
    child.start()
    seen = queue.get(timeout=60)
    child.join()
    np.testing.assert_array_equal(seen, envs.step(np.zeros((4, 2), np.float32))[0])


SCRIPT = """
import zlib
import gymnasium, numpy as np
envs = gymnasium.make_vec(NAME, num_envs=3, max_steps=20)
rng = np.random.default_rng(0)
digest = zlib.crc32(envs.reset(seed=3)[0].tobytes())
for _ in range(60):
    observations, rewards, *_ = envs.step(rng.uniform(-1, 1, (3, 2)).astype(np.float32))
    digest = zlib.crc32(rewards.tobytes(), zlib.crc32(observations.tobytes(), digest))
""".replace("NAME", repr(BY_MODULE))


def test_another_process_agrees():
    command = [sys.executable, "-c", f"{SCRIPT}\nprint(digest)"]
    elsewhere = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    here: dict[str, int] = {}
    exec(SCRIPT, here)
    assert int(elsewhere.splitlines()[-1]) == here["digest"]
