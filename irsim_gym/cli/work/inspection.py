"""Inspection of a scenario before the training: its task, and a picture of a level. Needs no PyTorch."""

import io
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from irsim_gym.base.errors import IrsimGymError, ScenarioError
from irsim_gym.envs.parts.pictures import make_renderer
from irsim_gym.evaluation.protocol.tables import write_bytes, write_text
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.scenario.reading.load import load_scenario
from irsim_gym.scenario.reading.ros_map import SUFFIXES
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.simulator.cell_paths.queries import fixed_bodies, touched_cells
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.tasks import Task, load_task
from irsim_gym.tasks.episodes.levels import check_split

Parameters = Mapping[str, object] | None
MAP_CELL, MOST_CELLS = 0.05, 4_000_000
"""Greatest side of a cell of a written map [m], and greatest number of its cells."""


def draw_level(
    scenario: str, level: int, split: str, task: str | None, out: Path | None, parameters: Parameters, strict: bool
) -> Path:
    """Draw the start of a level into a file, and return its path. The scenario needs no learner.

    Raises:
        IrsimGymError: If the file's suffix is not ``.png``, ``.pdf``, ``.svg``, or ``.yaml`` for a map of ROS.
    """
    from irsim_gym.rendering.looks.images import save_picture

    output = partial(check_drawing, None if is_map(out) else out)
    request = ScenarioRequest(scenario, task, parameters=parameters, strict=strict)
    check_inputs(request, output, split=split)
    simulation = begin_level(load_scenario(scenario, parameters, strict=strict), level, split, task)
    path = out or Path(f"{simulation.scenario.name}.png")
    if is_map(path):
        write_ros_map(simulation, path)
        return path
    renderer = make_renderer(simulation)
    if path.suffix == ".png":
        save_picture(renderer.frame(0), path)
    else:
        renderer.save(path)
    renderer.close()
    return path


def is_map(out: Path | None) -> bool:
    """Return whether a file is to be a map of ROS."""
    return out is not None and out.suffix in SUFFIXES


def write_ros_map(simulation: Simulation, path: Path) -> None:
    """Write what stands in the first world as a map of ROS: a YAML file, and an image (.pgm) beside it.

    Cells are occupied if something touches them that never moves. They are at most 5 cm wide, and fill the cells of an
    obstacle map.
    """
    from PIL import Image

    world, model = simulation.scenario.world, simulation.model
    # As many cells as the world is wide; or, with an obstacle map, as many as fill its cells.
    across = world.width if simulation.scenario.occupied is None else world.width / len(simulation.scenario.occupied)
    side = across / math.ceil(across / MAP_CELL - 1e-9)
    shape = round(world.width / side), round(world.height / side)
    if shape[0] * shape[1] > MOST_CELLS or not math.isclose(shape[1] * side, world.height, rel_tol=1e-6):
        size = f"{world.width:g} x {world.height:g} m"
        raise IrsimGymError(f"--out {path}: {size} cannot be filled with at most {MOST_CELLS:,} squares of {side:g} m")
    occupied = touched_cells(model, simulation.state, 0, shape, blocks=fixed_bodies(model, 0))
    image = io.BytesIO()
    Image.fromarray(np.flipud(np.where(occupied, 0, 254).T).astype(np.uint8)).save(image, "PPM")
    write_bytes(path.with_suffix(".pgm"), image.getvalue())
    origin = [*map(float, world.offset), 0.0]
    lines = [f"image: {path.with_suffix('.pgm').name}", f"resolution: {side:.12g}", f"origin: {origin}", "negate: 0"]
    write_text(path, "\n".join([*lines, "occupied_thresh: 0.65", "free_thresh: 0.196", "mode: trinary\n"]))


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
