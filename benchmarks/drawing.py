"""Frames of 600 x 600 pixels of one world with everything on: ours, a plain redraw with matplotlib, and IR-SIM's."""

from __future__ import annotations

import importlib.util
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from drawn_world import SIDE, STEPS_BEFORE, STEPS_DRAWN, drawn_world
from effort import Effort, Figures
from timing import seconds, summed_up

SLOW_STEPS = 10
"""Frames of a round of those that take long."""


@dataclass(frozen=True)
class Painter:
    """Somebody who draws a world.

    Attributes:
        begin: Goes back to the start and some steps on from there.
        advance: Takes one step, which is not measured.
        draw: Makes one picture.
        n_frames: Frames of a round.
    """

    begin: Callable[[], Any]
    advance: Callable[[], Any]
    draw: Callable[[], Any]
    n_frames: int


def measure(effort: Effort) -> Figures:
    """Milliseconds of CPU of one frame of each who can draw, in turns, and how many times longer than ours."""
    with painters(STEPS_BEFORE if effort.round_s else 1) as found:
        values: dict[str, list[float]] = {name: [] for name in found}
        for _ in range(effort.rounds):
            for name, painter in found.items():
                values[name].append(1e3 * _round_s(painter, painter.n_frames if effort.round_s else 1))
    timings = {name: summed_up(taken) for name, taken in values.items()}
    figures: Figures = {f"{name}_frame_ms": timing for name, timing in timings.items()}
    ours = timings["raster"].median
    return figures | {
        f"{name}_times_slower": timings[name].median / ours for name in ("naive", "irsim") if name in timings
    }


def _round_s(painter: Painter, n_frames: int) -> float:
    """Return the seconds of one frame, by the mean of a run."""
    painter.begin()
    painter.draw()
    taken = 0.0
    for _ in range(n_frames):
        painter.advance()
        taken += seconds(painter.draw)
    return taken / n_frames


@contextmanager
def painters(n_before: int) -> Iterator[dict[str, Painter]]:
    """Yield all who can draw here, after some steps, and free what they hold."""
    import matplotlib

    matplotlib.use("Agg")
    found = {"raster": ours(n_before), "naive": naive(n_before)}
    with tempfile.TemporaryDirectory() as folder:
        if importlib.util.find_spec("irsim") is not None:
            found["irsim"] = irsim_painter(Path(folder), n_before)
        yield found
    from matplotlib import pyplot

    pyplot.close("all")


def _renderer(n_before: int) -> tuple[Any, Any, Callable[[], None]]:
    """Return a simulation, its renderer, and how both go to the beginning of a run."""
    import irsim_gym as ig
    from irsim_gym.rendering import Renderer

    scenario = ig.load_scenario(drawn_world())
    simulation = ig.compile(scenario)
    state = simulation.state
    renderer = Renderer(scenario, simulation.model, state, simulation.sensors)

    def begin() -> None:
        simulation.reset(0)
        renderer.clear()
        for _ in range(n_before):
            renderer.trails.record(np.zeros(1, np.int64), state.step, state.pose)
            simulation.step()

    return simulation, renderer, begin


def ours(n_before: int) -> Painter:
    """Return our renderer."""
    simulation, renderer, begin = _renderer(n_before)
    return Painter(begin, simulation.step, renderer.frame, STEPS_DRAWN)


def naive(n_before: int) -> Painter:
    """Return what one writes first: clear the axes, add a patch for everything, draw the figure."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from naive_redraw import redraw

    simulation, renderer, begin = _renderer(n_before)
    figure = Figure(figsize=(6.0, 6.0), dpi=100)
    canvas, axes = FigureCanvasAgg(figure), figure.add_subplot()

    def draw() -> Any:
        redraw(axes, renderer.scene(), SIDE)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    return Painter(begin, simulation.step, draw, SLOW_STEPS)


def irsim_painter(folder: Path, n_before: int) -> Painter:
    """Return IR-SIM's own figure, which is drawn on a canvas without a window."""
    import irsim

    world = drawn_world()
    world["world"]["plot"] = {"figure_pixels": [600, 600]}
    file = folder / "drawn.yaml"
    file.write_text(yaml.safe_dump(world), encoding="utf-8")
    env = irsim.make(str(file), display=False, log_level="CRITICAL")
    figure = env._env_plot.fig

    def begin() -> None:
        env.reset()
        for _ in range(n_before):
            env.step()
            env.render()

    def draw() -> Any:
        env.render()
        figure.canvas.draw()
        return np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()

    return Painter(begin, env.step, draw, SLOW_STEPS)
