"""The cases: each returns its figures by name; names end with their unit."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

Figures = dict[str, float]

WORLDS = (1, 64, 256, 1024)
FIRST_EPISODE = "import gymnasium, irsim_gym; gymnasium.make('irsim_gym/cluttered_room-v0').reset(seed=0)"
FIRST_STEP = (
    "import gymnasium, irsim_gym; env = gymnasium.make('irsim_gym/cluttered_room-v0'); env.reset(seed=0);"
    "env.step(env.action_space.sample())"
)


def startup() -> Figures:
    """Seconds from the start of a process: import, first episode with and without compiled kernels."""
    with tempfile.TemporaryDirectory() as cache:
        cold = _seconds(FIRST_STEP, NUMBA_CACHE_DIR=cache)
        warm = [_seconds(FIRST_EPISODE, NUMBA_CACHE_DIR=cache) for _ in range(5)]
    empty, imported = [min(_seconds(code) for _ in range(5)) for code in ("pass", "import irsim_gym")]
    return {
        "import_s": imported - empty,
        "python_s": empty,
        "cold_first_step_s": cold,
        "warm_make_and_reset_s": min(warm),
    }


def _seconds(code: str, **environment: str) -> float:
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, env={**os.environ, **environment})
    return time.perf_counter() - begin


def cheapest(function: Callable[[], Any], repetitions: int) -> float:
    """Return the least CPU seconds of a call."""
    function()
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def simulator(name: str = "cluttered_room") -> Figures:
    """Microseconds of one thread per world and step: the simulator alone, and drawing a level."""
    import irsim_gym as ig

    figures = {}
    for n_worlds in WORLDS:
        sim = ig.compile(ig.load_scenario(name), n_worlds, agents=(0,))
        sim.reset()
        steps = max(1, 512 // n_worlds)
        seconds = cheapest(lambda sim=sim, steps=steps: [sim.step([0.3, 0.5]) for _ in range(steps)], 15)
        figures[f"step_{n_worlds}_worlds_us"] = 1e6 * seconds / steps / n_worlds
    seeds = iter(range(0, 10**9, n_worlds))
    figures["level_us"] = 1e6 * cheapest(lambda: sim.reset(next(seeds)), 15) / n_worlds
    return figures


def environment(name: str = "cluttered_room") -> Figures:
    """Microseconds per world and step through the batch of Stable-Baselines3, restarts included."""
    import irsim_gym as ig

    figures = {}
    for n_worlds in WORLDS:
        env = ig.sb3.make_vec_env(name, n_worlds, seed=0)
        env.reset()
        actions = np.random.default_rng(0).uniform(-1, 1, (64, n_worlds, 2)).astype(np.float32)
        seconds = cheapest(lambda env=env, actions=actions: [env.step(action) for action in actions], 10)
        figures[f"step_{n_worlds}_worlds_us"] = 1e6 * seconds / 64 / n_worlds
    return figures


def frames(name: str = "cluttered_room") -> Figures:
    """Milliseconds per frame of `rgb_array`."""
    import gymnasium as gym

    import irsim_gym  # noqa: F401  registers the ids

    env = gym.make(f"irsim_gym/{name}-v0", render_mode="rgb_array")
    env.reset(seed=0)
    first = time.perf_counter()
    env.render()
    first = time.perf_counter() - first

    def drive() -> None:
        for _ in range(20):
            env.step(np.array([0.5, 0.3], np.float32))
            env.render()
            if env.unwrapped.worlds.episodes.view.terminated.any():
                env.reset()

    return {"first_frame_ms": 1e3 * first, "frame_ms": 1e3 * cheapest(drive, 5) / 20}


def training_share(steps: int = 1_000_000) -> Figures:
    """Shares of PPO's training time, with 256 worlds and the shipped settings."""
    from training_share import measure

    return measure("cluttered_room", steps)


def crowd(behavior: dict[str, Any]) -> Figures:
    """Microseconds per agent and step of crowds that avoid each other, without sensors; beside IR-SIM if installed."""
    from crowds import cost

    return cost(behavior)


CASES: dict[str, Callable[[], Figures]] = {
    "startup": startup,
    "simulator/cluttered_room": simulator,
    "simulator/dense_room": lambda: simulator("dense_room"),
    "environment/cluttered_room": environment,
    "frames/cluttered_room": frames,
    "crowd_orca": lambda: crowd({"group_behavior": {"name": "orca"}}),
    "crowd_rvo": lambda: crowd({"behavior": {"name": "rvo"}}),
    "training_share/cluttered_room": training_share,
}
