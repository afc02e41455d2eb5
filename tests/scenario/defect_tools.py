"""Short ways to read and run YAML text."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
import yaml

from irsim_gym.errors import ScenarioError
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.load import read_scenario
from irsim_gym.scenario.specs.spec import BodySpec
from irsim_gym.scenario.text.composer import compose
from irsim_gym.scenario.text.source import Source, dotted
from irsim_gym.simulator.engine import Simulation, compile


def scenario(text: str) -> Scenario:
    """Return the scenario that a YAML text describes."""
    return load_scenario(yaml.safe_load(text), warn=False)


def body(text: str) -> BodySpec:
    """Return the only body of a YAML text."""
    (one,) = scenario(text).bodies
    return one


def problems(text: str) -> list[str]:
    """Return the problems of a YAML text as ``line path: message``."""
    document = compose(text)
    assert not document.problems, [dotted(place) for _, place, _ in document.problems]
    with pytest.raises(ScenarioError) as caught:
        read_scenario(Source("", document.data, document.lines))
    return [f"{one.line} {one.path}: {one.message}" for one in caught.value.problems]


def run(text: str, steps: int = 1, *, agents: Sequence[int] = (), command: Sequence[float] | None = None) -> Simulation:
    """Return a simulation of one world after some steps; ``command`` drives all agents."""
    simulation = compile(scenario(text), agents=agents)
    simulation.reset(seed=0)
    for _ in range(steps):
        simulation.step(command)
    return simulation
