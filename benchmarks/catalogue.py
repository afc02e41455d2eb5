"""All cases by name: each returns its figures, whose names end with their unit."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from effort import Effort, Figures, repeat
from faces import FACES
from growth import GROWTH
from level_maps import level_maps
from memory import memory
from phases import PHASES
from seen_maps import seen_maps
from startup import startup
from timing import cost

WORLDS = (1, 64, 256, 1024)


def simulator(name: str, effort: Effort) -> Figures:
    """Measure one thread per world and step: the simulator alone, and drawing a level."""
    import irsim_gym as ig

    figures: Figures = {}
    for n_worlds in effort.sizes(WORLDS):
        sim = ig.compile(ig.load_scenario(name), n_worlds, agents=(0,))
        sim.reset()
        count = effort.steps(lambda sim=sim: sim.step([0.3, 0.5]))
        taken = cost(lambda sim=sim, n=count: repeat(lambda: sim.step([0.3, 0.5]), n), effort.rounds)
        figures[f"step_{n_worlds}_worlds_us"] = taken.times(1e6 / count / n_worlds)
    seeds = iter(range(0, 10**9, n_worlds))
    figures["level_us"] = cost(lambda: sim.reset(next(seeds)), effort.rounds).times(1e6 / n_worlds)
    return figures


def environment(name: str, effort: Effort) -> Figures:
    """Measure a shipped scenario with its own task through the batch of Stable-Baselines3, restarts included."""
    import irsim_gym as ig

    figures: Figures = {}
    for n_worlds in effort.sizes(WORLDS):
        env = ig.sb3.make_vec_env(name, n_worlds, seed=0)
        env.reset()
        actions = np.random.default_rng(0).uniform(-1, 1, (64, n_worlds, 2)).astype(np.float32)
        taken = cost(lambda env=env, actions=actions: [env.step(action) for action in actions], effort.rounds)
        figures[f"step_{n_worlds}_worlds_us"] = taken.times(1e6 / 64 / n_worlds)
    return figures


def frames(name: str, effort: Effort) -> Figures:
    """Measure frames of `rgb_array` in milliseconds."""
    import irsim_gym as ig

    env = ig.make(name, render_mode="rgb_array")
    env.reset(seed=0)
    first = time.perf_counter()
    env.render()
    first = time.perf_counter() - first

    def drive() -> None:
        for _ in range(20):
            _, _, terminated, truncated, _ = env.step(np.array([0.5, 0.3], np.float32))
            env.render()
            if terminated or truncated:
                env.reset()

    return {"first_frame_ms": 1e3 * first, "frame_ms": cost(drive, min(5, effort.rounds)).times(1e3 / 20)}


def training_share(effort: Effort) -> Figures:
    """Measure the shares of PPO's training time, with the shipped settings."""
    from training_share import measure

    steps = 1_000_000 if effort.largest is None else 1
    return dict(measure("cluttered_room", steps))


def training_noop(effort: Effort) -> Figures:
    """Measure PPO with S1 against PPO with an environment that does nothing."""
    from training_noop import measure

    return measure(effort)


def crowd(behavior: dict[str, Any], effort: Effort) -> Figures:
    """Measure crowds that avoid each other, without sensors; beside IR-SIM if installed."""
    from crowds import measure

    return measure(behavior, effort)


def decision(name: str, policy: str, effort: Effort) -> Figures:
    """Measure what decisions of a behaviour cost."""
    from decision_costs import measure

    return measure(name, policy, effort)


def drawing(effort: Effort) -> Figures:
    """Measure frames with everything on: ours, a plain redraw with matplotlib, and IR-SIM if installed."""
    from drawing import measure

    return measure(effort)


CASES: dict[str, Callable[[Effort], Figures]] = {
    "startup": startup,
    "memory": memory,
    **FACES,
    **PHASES,
    **GROWTH,
    "level_maps": level_maps,
    "seen_maps": seen_maps,
    "simulator/cluttered_room": partial(simulator, "cluttered_room"),
    "simulator/dense_room": partial(simulator, "dense_room"),
    "environment/cluttered_room": partial(environment, "cluttered_room"),
    "frames/cluttered_room": partial(frames, "cluttered_room"),
    "frames/everything": drawing,
    "crowd_orca": partial(crowd, {"group_behavior": {"name": "orca"}}),
    "crowd_rvo": partial(crowd, {"behavior": {"name": "rvo"}}),
    "decision/pursuit": partial(decision, "dense_room", "pursuit"),
    "decision/pursuit_seen": partial(decision, "dense_room", "pursuit:known=seen"),
    "decision/hybrid_astar": partial(decision, "parking", "hybrid_astar"),
    "decision/dwa": partial(decision, "dense_room", "dwa"),
    "training_share/cluttered_room": training_share,
    "training_noop/s1": training_noop,
}

LONG = {"training_share/cluttered_room", "training_noop/s1"}
"""Cases that take minutes even when there is little to do."""
