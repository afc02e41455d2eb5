"""The command ``irsim-gym warmup``: compile the kernels of scenarios in advance."""

import time
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from rich.console import Console
from rich.progress import Progress

from irsim_gym.base.compiled.folder import cache_folder
from irsim_gym.base.compiled.watch import compilation
from irsim_gym.base.errors import ScenarioError, report_together
from irsim_gym.cli.work.inspection import begin_level
from irsim_gym.envs.gymnasium.single import WorldEnv
from irsim_gym.envs.gymnasium.worlds import TaskSource
from irsim_gym.envs.parts.pictures import make_renderer
from irsim_gym.envs.teams.batch import make_batch
from irsim_gym.evaluation.levels.level_survey import survey
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.policies.behavior_policies import UnfitBehaviorError
from irsim_gym.evaluation.policies.reference_policies import ALWAYS_SHOWN, reference_policy
from irsim_gym.evaluation.protocol.protocol import drive
from irsim_gym.evaluation.requests.inputs import world_checks
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.engine import compile
from irsim_gym.tasks import Episodes

WARMUP_STEPS = 3
"""The first step is recorded. Later ones replay it, which uses other kernels."""


def warm_up(chosen: Sequence[ScenarioRequest]) -> None:
    """Compile the kernels of scenarios with their tasks, and print where they are cached.

    Raises:
        IrsimGymError: A name is unknown, or a file has mistakes; the message lists all of them.
    """
    begun, watch, place = time.perf_counter(), compilation(), cache_folder()
    before = watch.compiled + watch.received
    report_together(*(check for world in chosen for check in world_checks(world)))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for world in progress.track(chosen, description="compiling"):
            exercise(world.load(), world.task)
    place_note = f"kept in {place}" if place else "not cached: no folder is writable; set NUMBA_CACHE_DIR"
    spent = time.perf_counter() - begun
    ready = f"{len(chosen)} scenario{'s' * (len(chosen) != 1)} ready"
    print(f"{ready}: {watch.compiled + watch.received - before} kernels compiled in {spent:.0f} s, {place_note}")


def exercise(scenario: Scenario, task: TaskSource = None) -> None:
    """Take a few steps in a scenario without learners, with one, and as a team, and draw it."""
    simulation = compile(scenario, 1)
    simulation.reset(seed=0)
    for _ in range(WARMUP_STEPS):
        simulation.step()
    with suppress(ScenarioError):  # no robot can learn there
        env = WorldEnv(scenario, task)
        env.reset(seed=0)
        for _ in range(WARMUP_STEPS):
            *_, terminated, truncated, _ = env.step(env.action_space.sample())
            if terminated or truncated:
                env.reset()
        _drive(env.worlds.episodes)
        survey(scenario, env.worlds.episodes.task)  # which check and train begin with
    with suppress(ScenarioError):  # or not as a team
        batch = make_batch(scenario, task=task)
        batch.reset(seed=0)
        for _ in range(WARMUP_STEPS):
            batch.step(np.stack([[batch.action_space.sample()] * batch.n_agents]))
    renderer = make_renderer(begin_level(scenario))
    renderer.frame(0)
    renderer.close()


def _drive(episodes: Episodes) -> None:
    """Compute a shortest path, and play a level with each reference policy of every evaluation, if it can drive."""
    Optima("train").of(episodes, 0, 0)
    for name in ALWAYS_SHOWN:
        with suppress(UnfitBehaviorError):
            next(drive(reference_policy(name), episodes, 1, "train"), None)
