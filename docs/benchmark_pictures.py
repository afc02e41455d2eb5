"""Draw docs/benchmarks: four levels of each benchmark of the suite, side by side; one where all levels are the same.

Disturbed benchmarks have the levels, and so the picture, of the benchmark without disturbances.

python docs/benchmark_pictures.py [BENCHMARK...]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from irsim_gym.cli.work.inspection import begin_level
from irsim_gym.evaluation.suite.members import Member, shipped_suite
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario

FOLDER = Path(__file__).parent / "benchmarks"
LEVELS = 4
HEIGHT = 200
GAP = 8
COLORS = 128


def main(folder: Path = FOLDER, names: list[str] | None = None) -> None:
    """Draw the pictures of benchmarks, by default of all."""
    folder.mkdir(parents=True, exist_ok=True)
    members = shipped_suite().members
    for name in names or [name for name, one in members.items() if not one.disturbed]:
        draw(members[name]).save(folder / f"{name}.png", optimize=True)


def draw(member: Member) -> Image.Image:
    """Return the first test levels of a benchmark, from left to right."""
    frames = [frame(member, level) for level in range(min(LEVELS, member.levels or LEVELS))]
    sheet = Image.new("RGB", (sum(one.width + GAP for one in frames) - GAP, HEIGHT), "white")
    left = 0
    for one in frames:
        sheet.paste(one, (left, 0))
        left += one.width + GAP
    return sheet.quantize(COLORS)


def frame(member: Member, level: int) -> Image.Image:
    """Return the start of a level, without a title and without axes."""
    scenario = load_scenario(member.scenario, member.parameters)
    plot = replace(scenario.world.plot, show_title=False, no_axis=True, tight=True)
    scenario = replace(scenario, world=replace(scenario.world, plot=plot))
    drawn = begin_level(scenario, level, "test")
    parts = drawn.model, drawn.state, drawn.sensors
    renderer = Renderer(scenario, *parts, learners=drawn.agents.tolist(), explored=drawn.explored)
    picture = Image.fromarray(np.asarray(renderer.frame(0)))
    renderer.close()
    return picture.resize((round(HEIGHT * picture.width / picture.height), HEIGHT), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    main(names=sys.argv[1:] or None)
