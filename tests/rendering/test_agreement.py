"""Figures show what frames show: on every shipped scenario they are alike, though drawn by different means."""

from __future__ import annotations

import numpy as np
import pytest
from pixels import of_renderer
from skimage.metrics import structural_similarity

from irsim_gym.base.arraytypes import Bytes, Floats
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.reading.plot_overrides import saved_with
from irsim_gym.scenario.specs.library import scenario_names
from irsim_gym.scenario.specs.plot_spec import trailing
from irsim_gym.simulator.engine import compile
from irsim_gym.simulator.readings.trails import Trails

LEAST = 0.97
STEPS = 12


def grey(frame: Bytes) -> Floats:
    return np.asarray(frame.mean(axis=2))


def similarity(one: Bytes, other: Bytes) -> float:
    assert one.shape == other.shape
    return float(structural_similarity(grey(one), grey(other), data_range=255.0))


@pytest.mark.parametrize("name", scenario_names())
def test_a_figure_shows_what_a_frame_shows(name: str) -> None:
    simulation = compile(saved_with(load_scenario(name), {"bbox_inches": "standard"}), 1)
    simulation.reset(seed=2)
    learners = simulation.agents.tolist()
    trails = Trails(np.array(trailing(simulation.scenario.bodies, learners), np.int64), 1)
    parts = simulation.scenario, simulation.model, simulation.state, simulation.sensors
    explored = getattr(simulation, "explored", None)
    renderer = Renderer(*parts, learners=learners, trails=trails, explored=explored)
    for status in ("running", "collision"):
        drawn, figure = renderer.frame(0, status), of_renderer(renderer, status)
        assert similarity(figure, drawn) > LEAST
        assert np.abs(figure.astype(int) - drawn).mean() < 1.5
        for _ in range(STEPS):
            simulation.state.command[:, learners] = [0.7, 0.3, 0.0]
            simulation.step()
            trails.record(np.zeros(1, np.int64), simulation.state.step, simulation.state.pose)
