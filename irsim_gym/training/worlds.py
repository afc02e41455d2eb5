"""Worlds for evaluating and filming: a scenario, its task, and what they are made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from irsim_gym.envs.worlds import Worlds
from irsim_gym.tasks import Episodes
from irsim_gym.training.run import scenario_name


def make_episodes(
    scenario: str,
    *,
    task: str | None = None,
    n_worlds: int = 1,
    num_threads: int = 1,
    parameters: Mapping[str, Any] | None = None,
) -> Episodes:
    """Make worlds in which a task is done.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        task: Shipped name or path of a task; None for the scenario's own.
        n_worlds: Number of worlds.
        num_threads: Threads that share them.
        parameters: Values for the scenario's parameters.
    """
    name = scenario_name(scenario)
    return Worlds(name, n_worlds, task=task, num_threads=num_threads, parameters=parameters).episodes


def conditions(episodes: Episodes, split: str, levels: int) -> dict[str, Any]:
    """Return what a published figure has to name."""
    simulation = episodes.simulation
    model, agent = simulation.model, int(simulation.agents[0])
    scan = simulation.scan(agent)
    ranges = None if scan is None else scan[0].arrays["ranges"].shape[2]
    options = None if scan is None else scan[0].options[scan[1]]
    return {
        "scenario": simulation.scenario.name,
        "parameters": dict(simulation.scenario.parameters),
        "split": split,
        "levels": levels,
        "robot_radius": _range(model.reach[:, agent]),
        "goal_tolerance": float(model.goal_threshold[0, agent]),
        "velocity_min": model.velocity_min[0, agent, :2],
        "velocity_max": model.velocity_max[0, agent, :2],
        "acceleration_limit": model.acceleration_limit[0, agent, :2],
        "step_time": float(model.step_time[0]),
        "max_steps": episodes.task.max_steps,
        "beams": ranges,
        "range_max": None if options is None else options.range_max,
        "noise": False,
    }


def _range(values: Any) -> Any:
    low, high = float(np.min(values)), float(np.max(values))
    return low if low == high else [low, high]
