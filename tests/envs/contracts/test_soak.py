"""Long runs of many worlds: everything stays finite and in its space, and memory stays as it is."""

from __future__ import annotations

import gc
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from contract_tools import forward_actions
from standard_worlds import s1

import irsim_gym
from irsim_gym.envs.gymnasium.vector import WorldVectorEnv

SHORT_STEPS = 400
LONG_S = 600.0
WARM_S = 60.0
PAGE = 4096
MOST_GROWTH = 16 * 2**20
NOTHING_HAPPENS = {
    "name": "blank",
    "observations": ["goal"],
    "rewards": [{"name": "time", "weight": 1.0}],
    "endings": [],
    "max_steps": 10**6,
}


def vector(mode):
    def made(scenario, n_worlds, **kwargs):
        env = WorldVectorEnv(scenario, n_worlds, autoreset_mode=mode, **kwargs)
        env.reset(seed=0)
        return env

    return made


def vec_env(scenario, n_worlds, **kwargs):
    env = irsim_gym.sb3.make_vec_env(scenario, n_worlds, seed=0, render_mode=None, **kwargs)
    env.reset()
    return env


FACES = {"same": vector("SameStep"), "next": vector("NextStep"), "sb3": vec_env}


def play(env, rng):
    """One step; everything that comes back is what it may be. Return the number of worlds that have ended."""
    space = env.worlds.observation_space
    observations, rewards, *flags, infos = env.step(forward_actions(rng, (env.num_envs, 2)))
    assert ((observations >= space.low) & (observations <= space.high)).all()  # NaN is neither
    assert np.isfinite(rewards).all()
    ended = np.logical_or.reduce(flags)
    if isinstance(infos, list):
        final = [infos[w]["terminal_observation"] for w in np.flatnonzero(ended)]
        told = [infos[w][key] for w in np.flatnonzero(ended) for key in infos[w] if key.startswith("reward/")]
    else:
        final = [one for one in infos.get("final_obs", []) if one is not None]
        told = [infos["path_length"], infos["stalled"], *(infos[key] for key in infos if key.startswith("reward/"))]
    assert all(((one >= space.low) & (one <= space.high)).all() for one in final)
    assert np.isfinite(told).all() if isinstance(infos, list) else all(np.isfinite(one).all() for one in told)
    return int(ended.sum())


@pytest.mark.parametrize("face", FACES)
def test_a_short_run(face):
    env = FACES[face](s1(), 64)
    rng = np.random.default_rng(0)
    assert sum(play(env, rng) for _ in range(SHORT_STEPS)) > 100


def resident():
    """Memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the memory of the process from /proc")
def test_ten_minutes():
    """S1 at batch 1,024, through Stable-Baselines3's interface and Gymnasium's in turns."""
    envs = [FACES[face](s1(), 1024) for face in FACES]
    rng = np.random.default_rng(0)
    begin, warm, ended = time.monotonic(), None, 0
    while time.monotonic() - begin < LONG_S:
        ended += sum(play(env, rng) for env in envs for _ in range(100))
        if warm is None and time.monotonic() - begin > WARM_S:
            gc.collect()
            warm = resident()
    gc.collect()
    assert ended > 10_000
    assert warm is not None
    assert resident() - warm < MOST_GROWTH


def most_objects(step):
    """Return how many blocks of small objects more than before are alive at any time of a step, and after it."""
    gc.collect()
    gc.disable()
    before = most = sys.getallocatedblocks()

    def look(*_):
        nonlocal most
        most = max(most, sys.getallocatedblocks())

    sys.setprofile(look)
    try:
        result = step()
    finally:
        sys.setprofile(None)
        gc.enable()
    look()
    assert result is not None
    return most - before


@pytest.mark.parametrize(
    ("face", "per_world"),
    [("same", 0), *(pytest.param(*one, marks=pytest.mark.slow) for one in (("next", 0), ("sb3", 1)))],
)
def test_worlds_that_go_on_cost_no_objects(face, per_world):
    """Stable-Baselines3 wants a dict for each; that is the only one."""
    few, many = 256, 1024
    counts = []
    for n_worlds in (few, many):
        env = FACES[face]("sparse_circles", n_worlds, task=NOTHING_HAPPENS)
        still = np.tile(np.array([-1.0, 0.0], np.float32), (n_worlds, 1))
        held = [env.step(still) for _ in range(3)]
        counts.append(min(most_objects(lambda env=env, still=still: env.step(still)) for _ in range(3)))
        assert len(held) == 3
    assert abs(counts[1] - counts[0] - per_world * (many - few)) < 40
