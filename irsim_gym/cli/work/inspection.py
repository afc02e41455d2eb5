"""Inspection of a scenario before the training: its task, and a picture of a level. Needs no PyTorch."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from irsim_gym.base.errors import IrsimGymError, ScenarioError
from irsim_gym.envs.parts.pictures import make_renderer
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.tasks import Task, load_task
from irsim_gym.tasks.episodes.levels import check_split

Parameters = Mapping[str, object] | None


def draw_level(
    scenario: str,
    level: int,
    split: str,
    task: str | None,
    out: Path | None,
    parameters: Parameters = None,
    strict: bool = True,
) -> Path:
    """Draw the start of a level into a file, and return its path. The scenario needs no learner.

    Raises:
        IrsimGymError: If the file's suffix is not ``.png``, ``.pdf`` or ``.svg``.
    """
    from irsim_gym.rendering.films.sheet import save_sheet

    output = partial(check_drawing, out)
    asked = ScenarioRequest(scenario, task, parameters=parameters, strict=strict)
    check_inputs(asked, output, split=split)
    simulation = begin_level(load_scenario(scenario, parameters, strict=strict), level, split, task)
    path = out or Path(f"{simulation.scenario.name}.png")
    renderer = make_renderer(simulation)
    if path.suffix == ".png":
        save_sheet(renderer.frame(0), path)
    else:
        renderer.save(path)
    renderer.close()
    return path


def check_drawing(out: Path | None) -> None:
    """Check that the name of a picture, if any, ends in ``.png``, ``.pdf`` or ``.svg``.

    Raises:
        IrsimGymError: If it does not.
    """
    if out is not None and out.suffix.lower() not in (".png", ".pdf", ".svg"):
        raise IrsimGymError(f"a picture must be a .png, .pdf or .svg file, got '{out}'")


def team_error(scenario: Scenario, task: str | None = None) -> ScenarioError | None:
    """Return why the robots of a scenario cannot learn together; None if they can, or if there is only one."""
    try:
        if len(scenario.robots) > 1:
            load_task(scenario, task, team=True)
    except ScenarioError as error:
        return error
    return None


def fitting_task(
    scenario: Scenario, task: str | None = None, *, team: bool = False
) -> tuple[Task | None, ScenarioError | None]:
    """Return the task of a scenario, or the reason why no robot can learn; neither for a scenario without robots.

    Args:
        task: Shipped name or path of a task; None for that of the scenario.
        team: Whether all robots have to be able to learn together.

    Raises:
        ScenarioError: If a task is given or ``team`` is set, and the robots do not fit it.
    """
    if not scenario.robots:
        return None, None
    try:
        return load_task(scenario, task, team=team), None
    except ScenarioError as error:
        if scenario.task or task is not None or team:
            raise
        return None, error


def blocked_start(scenario: Scenario) -> ScenarioError | None:
    """Return why a scenario without a task is no environment, though it can be run: a robot starts in an obstacle."""
    try:
        if not scenario.task:
            compile(scenario)
    except ScenarioError as error:
        return error
    return None


def begin_level(scenario: Scenario, level: int = 0, split: str = "train", task: str | None = None) -> Simulation:
    """Return one world at the start of a level, with the learners of its task, if any.

    Raises:
        IrsimGymError: If the level cannot be generated, or the named task does not fit the scenario.
    """
    try:
        agents = load_task(scenario, task).agents
    except ScenarioError:
        if task is not None:
            raise
        agents = ()
    check_split(split)
    simulation = compile(scenario, agents=agents)
    simulation.reset(seed=level, split=split)
    return simulation
