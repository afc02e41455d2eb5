"""Worlds for evaluations and films, and the conditions that published results have to name."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from irsim_gym.base.families import FOOTPRINTS
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource, Worlds
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.tasks import Episodes

SIZES = {"circle": ("radius",), "rectangle": ("length", "width")}
"""Options that define the size of a shape."""


def make_episodes(
    scenario: ScenarioSource,
    *,
    task: TaskSource = None,
    n_worlds: int = 1,
    num_threads: int = 1,
    parameters: Mapping[str, object] | None = None,
    team: bool = False,
    strict: bool = True,
) -> Episodes:
    """Make worlds with a task.

    Args:
        scenario: Shipped name, environment id, path of a scenario file, plain data or a loaded scenario.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        num_threads: Number of threads that step the worlds.
        team: Whether all robots are agents, unless the task names some. Otherwise there has to be exactly one agent.
    """
    chosen: dict[str, Any] = {"task": task, "team": team, "strict": strict}
    if isinstance(scenario, Scenario):
        chosen["parameters"] = parameters
    else:
        scenario = load_scenario(scenario, parameters, strict=strict)
    return Worlds(scenario, n_worlds, num_threads=num_threads, **chosen).episodes


def conditions(episodes: Episodes, split: str, levels: int) -> dict[str, Any]:
    """Return the conditions that published results have to name. Values that differ between agents are lists."""
    simulation = episodes.simulation
    agents = [_robot(episodes, int(body)) for body in simulation.agents]
    about = {"scenario": simulation.scenario.name, "parameters": dict(simulation.scenario.parameters)}
    shared = {name: _one_or_all([agent[name] for agent in agents]) for name in agents[0]}
    return {**about, "split": split, "levels": levels, **shared}


def team_conditions(episodes: Episodes, split: str, levels: int) -> dict[str, Any]:
    """Return ``conditions``, with those that only concern teams."""
    task = episodes.task
    still = {"deadlock_speed": task.deadlock_speed, "deadlock_time": task.deadlock_time}
    names = list(episodes.agent_names)
    return {**conditions(episodes, split, levels), "agents": names, "ended": task.ended, **still}


def _robot(episodes: Episodes, body: int) -> dict[str, Any]:
    """Return the conditions of a robot."""
    simulation, model = episodes.simulation, episodes.simulation.model
    scan = simulation.scan(body)
    options = None if scan is None else scan[0].options[scan[1]]
    spec = simulation.scenario.bodies[body]
    return {
        "robot_radius": _range(model.reach[:, body]),
        "footprint": _footprint(spec.shape),
        "goals": int(model.waypoint_count[0, body]),
        "goal_tolerance": float(model.goal_threshold[0, body]),
        "velocity_min": model.velocity_min[0, body, :2].tolist(),
        "velocity_max": model.velocity_max[0, body, :2].tolist(),
        "acceleration_limit": model.acceleration_limit[0, body, :2].tolist(),
        "step_time": float(model.step_time[0]),
        "max_steps": episodes.task.max_steps,
        "beams": None if scan is None else scan[0].arrays["ranges"].shape[2],
        "range_max": None if options is None else options.range_max,
        "noise": options.std if options is not None and options.noise else False,
        "motion_noise": bool(getattr(spec.kinematics, "noise", False)),
    }


def _footprint(shape: Any) -> str:
    """Return a description of a shape with its size [m], e.g. ``rectangle 0.42 x 0.33 m``."""
    name = FOOTPRINTS.name_of(type(shape))
    if shape.is_random or name not in SIZES:
        return name
    sizes = " x ".join(f"{getattr(shape, size):g}" for size in SIZES[name])
    return f"{name} {sizes} m"


def _one_or_all(values: list[Any]) -> Any:
    return values[0] if all(value == values[0] for value in values) else values


def _range(values: Any) -> Any:
    low, high = float(np.min(values)), float(np.max(values))
    return low if low == high else [low, high]
