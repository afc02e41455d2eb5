"""Each YAML example of IR-SIM's documentation loads, runs, is drawn and can be learned as it stands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from documented import EXAMPLES

import irsim_gym
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import compile

# The car of one example drives 0.4 m in a step, beyond its goal_threshold of 0.1 m.
pytestmark = pytest.mark.filterwarnings("ignore:(?s).*may jump over a goal_threshold:irsim_gym.errors.ScenarioWarning")


@pytest.fixture(params=EXAMPLES)
def file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    place = tmp_path / "example.yaml"
    place.write_text(EXAMPLES[request.param], encoding="utf-8")
    return place


def test_it_runs_and_is_drawn(file: Path) -> None:
    scenario = load_scenario(file)
    simulation = compile(scenario)
    simulation.reset(seed=0)
    for _ in range(20):
        simulation.step()
    state = simulation.state
    assert np.isfinite(state.pose).all()
    assert state.step[0] == 20
    renderer = Renderer(scenario, simulation.model, state, simulation.sensors, size=(96, 96))
    assert renderer.frame().std() > 0.0


def test_it_can_be_learned_where_there_is_somewhere_to_go(file: Path) -> None:
    scenario = load_scenario(file)
    robots = [scenario.bodies[b] for b in scenario.robots]
    if not any(robot.goal or scenario.placements[robot.entry].kind.gives_goal for robot in robots):
        return
    env = irsim_gym.make(file)
    observation, _ = env.reset(seed=0)
    for _ in range(3):
        assert observation in env.observation_space
        observation, *_ = env.step(env.action_space.sample())
    env.close()


def test_the_page_is_covered() -> None:
    assert len(EXAMPLES) == 42
