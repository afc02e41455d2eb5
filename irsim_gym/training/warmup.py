"""The command ``irsim-gym warmup``: compile the kernels of scenarios in advance."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from functools import partial

import numpy as np
from rich.console import Console
from rich.progress import Progress

from irsim_gym.engine import compile
from irsim_gym.envs.batch import make_batch
from irsim_gym.envs.pictures import make_renderer
from irsim_gym.envs.single import WorldEnv
from irsim_gym.errors import ScenarioError, report_together
from irsim_gym.evaluation.behavior_policies import UnfitBehaviorError
from irsim_gym.evaluation.optimum import Optima
from irsim_gym.evaluation.protocol import drive
from irsim_gym.evaluation.reference_policies import ALWAYS_SHOWN, reference_policy
from irsim_gym.jit.folder import cache_folder
from irsim_gym.jit.watch import compilation
from irsim_gym.scenario.library import scenario_names
from irsim_gym.scenario.load import load_scenario
from irsim_gym.scenario.spec import Scenario
from irsim_gym.tasks import Episodes
from irsim_gym.training.inspection import begin_level

WARMUP_STEPS = 3
"""The first step is recorded. Later ones replay it, which uses other kernels."""


def warm_up(names: Sequence[str], *, strict: bool = True) -> None:
    """Compile the kernels of scenarios, and print where they are cached.

    Args:
        names: Shipped names, environment ids or paths of scenario files; empty for all shipped scenarios.
    """
    begun, watch = time.perf_counter(), compilation()
    before = watch.compiled
    chosen = names or scenario_names()
    report_together(*(partial(load_scenario, name, strict=strict, warn=False) for name in names))
    watch.said = True  # the progress bar replaces the message about compilation
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for name in progress.track(chosen, description="compiling"):
            exercise(load_scenario(name, strict=strict))
    place = cache_folder()
    kept = f"kept in {place}" if place else "not cached: no folder is writable; set NUMBA_CACHE_DIR"
    spent = time.perf_counter() - begun
    ready = f"{len(chosen)} scenario{'s' * (len(chosen) != 1)} ready"
    print(f"{ready}: {watch.compiled - before} kernels compiled in {spent:.0f} s, {kept}")


def exercise(scenario: Scenario) -> None:
    """Take a few steps in a scenario without learners, with one, and as a team, and draw it."""
    simulation = compile(scenario, 1)
    simulation.reset(seed=0)
    for _ in range(WARMUP_STEPS):
        simulation.step()
    with suppress(ScenarioError):  # no robot can learn there
        env = WorldEnv(scenario)
        env.reset(seed=0)
        for _ in range(WARMUP_STEPS):
            *_, terminated, truncated, _ = env.step(env.action_space.sample())
            if terminated or truncated:
                env.reset()
        _drive(env.worlds.episodes)
    with suppress(ScenarioError):  # or not as a team
        batch = make_batch(scenario)
        batch.reset(seed=0)
        for _ in range(WARMUP_STEPS):
            batch.step(np.stack([[batch.action_space.sample()] * batch.n_agents]))
    _draw(scenario)


def _drive(episodes: Episodes) -> None:
    """Compute a shortest path, and play a level with each reference policy of every evaluation, if it can drive."""
    Optima("train").of(episodes, 0, 0)
    for name in ALWAYS_SHOWN:
        with suppress(UnfitBehaviorError):
            next(drive(reference_policy(name), episodes, 1, "train"), None)


def _draw(scenario: Scenario) -> None:
    renderer = make_renderer(begin_level(scenario))
    renderer.frame(0)
    renderer.close()
