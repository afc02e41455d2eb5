"""What bodies left behind is kept between frames of the raster renderer, and no frame shows it."""

from __future__ import annotations

import numpy as np
import pytest

from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.simulator.readings.trails import Trails

PLOT = {"show_trail": True, "trail_freq": 3, "show_trajectory": True}
POLYGON = {"name": "polygon", "random_shape": True, "center_range": [0, 0, 0, 0], "avg_radius_range": [0.3, 0.6]}
DRIVE = {"kinematics": {"name": "diff"}, "behavior": {"name": "dash"}}
DATA = {
    "world": {"width": 6, "height": 6, "plot": {"figure_pixels": [160, 160]}},
    "robot": [{**DRIVE, "state": [1, y, 0], "goal": [5, y, 0], "plot": PLOT} for y in (1.5, 3.0)],
    "obstacle": {**DRIVE, "shape": POLYGON, "state": [1, 5, 0], "goal": [5, 5, 0], "plot": PLOT},
}
WORLDS = 2


def renderers(simulation: Simulation) -> tuple[Renderer, Renderer, Trails]:
    """Return a renderer that goes on, one that is to be closed before each frame, and the trails of both."""
    trails = Trails(np.arange(3), WORLDS)
    parts = simulation.scenario, simulation.model, simulation.state, simulation.sensors
    keeps, forgets = (Renderer(*parts, trails=trails) for _ in range(2))
    return keeps, forgets, trails


def test_frames_are_those_of_a_renderer_that_keeps_nothing() -> None:
    simulation = compile(load_scenario(DATA), WORLDS)
    keeps, forgets, trails = renderers(simulation)
    everybody = np.arange(WORLDS)
    for seed in range(2):  # with other outlines, from the same places
        simulation.reset(seed=seed)
        for step in range(13):
            trails.record(everybody, simulation.state.step, simulation.state.pose)
            if step == 7:
                trails.forget(np.array([[False, True, False]] * WORLDS))
            if step in (9, 10):
                keeps.look_at((0.0, 0.0, 3.0, 3.0) if step == 9 else None)
                forgets.look_at((0.0, 0.0, 3.0, 3.0) if step == 9 else None)
            statuses = ["collision" if step == 5 else "running"] * WORLDS
            forgets.close()
            assert np.array_equal(keeps.frames(everybody.tolist(), statuses), forgets.frames([0, 1], statuses)), step
            simulation.step()


def test_what_is_kept_is_not_drawn_again(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = compile(load_scenario(DATA), WORLDS)
    keeps, _, _ = renderers(simulation)
    simulation.reset(seed=0)
    for _ in range(7):
        keeps.frame()
        simulation.step()
    first, drawn = keeps.frame(), list[int]()
    painter = keeps._painter
    assert painter is not None
    assert len(painter.kept_trails.items) == 3
    monkeypatch.setattr(painter.kept_trails, "keep", lambda world, *_: drawn.append(world))
    assert np.array_equal(keeps.frame(), first)
    assert drawn == []
    simulation.step()
    simulation.step()
    keeps.frame()
    assert drawn == [0], "a further outline"
