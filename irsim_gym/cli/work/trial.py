"""Trial runs of scenarios: levels and steps as all environments begin and take them."""

from __future__ import annotations

import faulthandler
import sys
import time
import traceback
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from irsim_gym.base.errors import IrsimGymError, Problem, ScenarioError, ScenarioWarning

if TYPE_CHECKING:
    from irsim_gym.scenario import Scenario

TRIAL_STEPS = 30
"""Largest number of steps for each kind of environment."""
LONGEST_S = 2.0
"""Longest time for each kind of environment, without the first step [s]."""
PACKAGE = str(Path(__file__).parents[2])
STANDING_S, WATCHED_S = 10.0, 60.0
"""Bodies that a collision has held for so long count as standing, after a trial of so long [s]."""


@dataclass(frozen=True)
class ReadOptions:
    """Options for reading scenario files.

    Attributes:
        parameters: Values for the parameters of the scenarios.
        strict: Whether unused keys are an error; False ignores them.
        task: Shipped name or path of a task; None for that of the scenario.
        team: Whether all robots have to be able to learn together.
    """

    parameters: Mapping[str, object]
    strict: bool = True
    task: str | None = None
    team: bool = False


@dataclass(frozen=True)
class Played:
    """What came of playing a scenario.

    Attributes:
        failure: Error message; empty if there is none.
        notes: Remarks on its levels, see ``level_survey``.
    """

    failure: str = ""
    notes: tuple[Problem, ...] = ()


def try_files(files: Sequence[str], reading: ReadOptions) -> dict[str, Played]:
    """Run scenarios for a few steps, and return what came of it by file.

    Each scenario begins some levels and takes some steps without learners, with a single learner, and as a team, if
    possible. A scenario with wandering bodies plays a minute without learners. A crash of compiled code ends the
    command, with the stack of Python.

    Args:
        files: Scenarios, as ``load_scenario`` takes them.
    """
    if sys.__stderr__ is not None:
        faulthandler.enable(sys.__stderr__, all_threads=False)
    # Output of behaviours does not belong to the output of the command, and warnings are notes there.
    with warnings.catch_warnings(), redirect_stdout(sys.stderr):
        warnings.simplefilter("ignore", ScenarioWarning)
        return {file: _played(file, reading) for file in files}


def run_briefly(file: str, reading: ReadOptions) -> tuple[Problem, ...]:
    """Begin levels of a scenario and take some steps: without learners, with one, and as a team, if possible.

    Returns:
        Remarks on the levels, and on wandering bodies that stand for good.

    Raises:
        IrsimGymError: If the file is invalid, its level cannot be generated, or its goals lie in obstacles.
    """
    from irsim_gym.cli.work.inspection import fitting_task
    from irsim_gym.evaluation.levels.level_survey import survey
    from irsim_gym.scenario import load_scenario
    from irsim_gym.simulator.engine import compile

    scenario = load_scenario(file, reading.parameters, strict=reading.strict, warn=False)
    _take_steps(_by_itself(scenario))
    compile(scenario)  # refuses robots that start in obstacles
    unaudited = replace(scenario, task={**scenario.task, "audit": False})  # terms are played whatever they weigh
    with suppress(ScenarioError):  # no robot can learn there
        _take_steps(_with_terms_watched(unaudited, reading.task))
        _take_steps(_with_a_learner(unaudited, reading.task))
    with suppress(ScenarioError):
        _take_steps(_as_a_team(unaudited, reading.task) if len(scenario.robots) > 1 else iter(()))
    learned, _ = fitting_task(scenario, reading.task, team=reading.team)
    return (*(() if learned is None else survey(scenario, learned)), *_standing(scenario))


def _take_steps(steps: Iterator[None]) -> None:
    """Take ``TRIAL_STEPS`` steps, or fewer if they take longer than ``LONGEST_S``."""
    next(steps, None)  # this one may compile
    begun = time.perf_counter()
    for _ in range(TRIAL_STEPS - 1):
        next(steps, None)
        if time.perf_counter() - begun > LONGEST_S:
            return


def _standing(scenario: Scenario) -> Iterator[Problem]:
    """Yield a note on wandering bodies that collisions have stopped for good, after a minute or ``LONGEST_S``."""
    import numpy as np

    from irsim_gym.simulator.engine import compile

    wanderers = [b for b, body in enumerate(scenario.bodies) if body.wanders and not body.static]
    if not wanderers or scenario.world.collision_mode == "unobstructed":
        return
    simulation, begun, step_time = compile(scenario), time.perf_counter(), scenario.world.step_time
    simulation.reset()
    held, state = np.zeros(len(wanderers)), simulation.state
    while state.time[0] < WATCHED_S and time.perf_counter() - begun < LONGEST_S:
        simulation.step()
        held = np.where(state.stopped[0, wanderers], held + step_time, 0.0)
    if count := int((held >= STANDING_S).sum()):
        first = scenario.bodies[wanderers[0]]
        remark = (
            f"{count} of {len(wanderers)} wandering bodies stand after {state.time[0]:.0f} s, since they touch: "
            "wander_goals: {patience: 5} lets them go on, and collision_mode says whom a collision stops"
        )
        yield Problem(first.line, first.name, remark)


def _by_itself(scenario: Scenario) -> Iterator[None]:
    from irsim_gym.simulator.engine import compile

    simulation = compile(scenario, check_starts=False)
    simulation.reset()
    while True:
        simulation.step()
        yield


def _with_terms_watched(scenario: Scenario, task: str | None) -> Iterator[None]:
    """Play the task in two worlds where terms of plugins are checked in each call; nothing where it has none."""
    import numpy as np

    from irsim_gym.base.contract import is_foreign
    from irsim_gym.simulator.engine import compile
    from irsim_gym.tasks import Episodes, load_task
    from irsim_gym.tasks.plugin_checks.term_watch import watch_terms

    loaded = load_task(scenario, task)
    if not any(map(is_foreign, map(type, (loaded.action, *loaded.observations, *loaded.rewards, *loaded.endings)))):
        return
    episodes = Episodes(compile(scenario, 2, agents=loaded.agents, fused=False), loaded)
    watch_terms(episodes.terms, episodes.simulation)
    episodes.begin(np.arange(2), np.arange(2))
    random, shape = np.random.default_rng(0), (2, episodes.n_agents)
    while True:
        n_choices = episodes.n_discrete
        size = (*shape, len(episodes.action_low))
        episodes.step(random.integers(n_choices, size=shape) if n_choices else random.uniform(-1.0, 1.0, size))
        yield


def _with_a_learner(scenario: Scenario, task: str | None) -> Iterator[None]:
    from irsim_gym.envs.gymnasium.single import WorldEnv

    env = WorldEnv(scenario, task)
    env.action_space.seed(0)
    env.reset(seed=0)
    while True:
        *_, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            env.reset()
        yield


def _as_a_team(scenario: Scenario, task: str | None) -> Iterator[None]:
    import numpy as np

    from irsim_gym.envs.teams.batch import make_batch

    batch = make_batch(scenario, task=task)
    batch.action_space.seed(0)
    batch.reset(seed=0)
    while True:
        batch.step(np.stack([[batch.action_space.sample() for _ in range(batch.n_agents)]]))
        yield


def _played(file: str, reading: ReadOptions) -> Played:
    """Run a scenario briefly, and return what came of it."""
    try:
        return Played(notes=run_briefly(file, reading))
    except (IrsimGymError, OSError) as error:
        return Played("\n".join([str(error), *getattr(error, "__notes__", ())]))
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        outside = [frame for frame in frames if not frame.filename.startswith(PACKAGE)] or frames
        lines = traceback.format_exception_only(error)
        place = f"  in {outside[-1].filename}:{outside[-1].lineno}"
        told = [f"{file}: could not be played: {lines[0].strip()}", *(f"  {one.rstrip()}" for one in lines[1:]), place]
        return Played("\n".join(told))
