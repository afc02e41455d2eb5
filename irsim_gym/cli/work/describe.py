"""The command ``irsim-gym describe``: print what an environment observes, and draw the directions it observes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.cli.work.inspection import check_drawing
from irsim_gym.envs.described.description import Description
from irsim_gym.envs.described.description_text import show
from irsim_gym.envs.described.parts import Block
from irsim_gym.envs.gymnasium.worlds import Worlds
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest

if TYPE_CHECKING:
    from irsim_gym.rendering.figures.sectors_plot import ImagePanel, SectorPanel

FAR = 5.0
"""Largest radius of drawn sectors [m]."""
LEVEL = 0
"""Level that a picture shows."""


def describe_scenario(asked: ScenarioRequest, *, as_json: bool, picture: Path | None) -> None:
    """Print the description of an environment, and draw the directions that its observations cover.

    Robots of a team that observe and act alike are described once.

    Args:
        as_json: Print JSON: an object, or a list of objects for a team.
        picture: File to draw; None for none.

    Raises:
        IrsimGymError: If the picture's suffix is not ``.png``, ``.pdf`` or ``.svg``, or there is nothing to draw.
    """
    check_inputs(asked, partial(check_drawing, picture))
    worlds = Worlds(**vars(asked))
    found = list(_each(worlds, asked.team))
    if picture is not None:  # before anything is printed, to a program that may stop reading
        draw(worlds, picture)
    if as_json:
        plain = [description.as_dict() for description in found]
        print(json.dumps(plain if asked.team else plain[0], indent=2))
        return
    for k, description in enumerate(found):
        print(end="\n" if k else "")
        show(description)
    if picture is not None:
        print(picture)


def _each(worlds: Worlds, team: bool) -> Iterator[Description]:
    """Yield a description for each kind of learner."""
    known: set[str] = set()
    for name in worlds.agent_names:
        if name not in known:
            description = worlds.describe(name, own=team)
            known |= {name, *description.same_for}
            yield description


def draw(worlds: Worlds, path: Path) -> None:
    """Draw the directions and images that the first learner observes at the beginning of a level.

    Raises:
        IrsimGymError: If it observes neither directions nor images.
    """
    from irsim_gym.rendering import Renderer
    from irsim_gym.rendering.figures.sectors_plot import draw_sectors

    worlds.begin([0], [LEVEL], [{"split": "dev"}], lambda _: LEVEL)
    panels = list(_panels(worlds, worlds.describe()))
    if not panels:
        raise IrsimGymError("no picture: this task observes neither directions nor pictures")
    simulation = worlds.simulation
    body = int(simulation.agents[0])
    found = simulation.scan(body)
    sight = FAR if found is None else float(found[0].options[found[1]].range_max)
    scene = Renderer(simulation.scenario, simulation.model, simulation.state).scene()
    pose = simulation.state.pose[0, body]
    title = f"{simulation.scenario.name}: where {worlds.agent_names[0]} looks"
    draw_sectors(path, panels, scene, pose, min(sight, FAR), title)


def _panels(worlds: Worlds, description: Description) -> Iterator[SectorPanel | ImagePanel]:
    """Yield the panels to draw: each row of sectors, and each channel of an image; a colour image is one panel."""
    from irsim_gym.rendering.figures.sectors_plot import ImagePanel, SectorPanel

    view = worlds.episodes.view
    start = 0
    for block in description.blocks:
        if block.is_image:
            yield from (ImagePanel(*parts) for parts in _channels(block, view.images[block.name][0, 0]))
            continue
        for part in block.parts:
            stop = start + part.stop - part.start
            if part.sectors:
                read, room = view.observation[0, 0, start:stop], max(part.high - part.low, 1e-9)
                values = np.asarray((read - part.low) / room, np.float32)
                title = f"{block.name} {part.start}:{part.stop}"
                note = f"{part.meaning}; its heading is up; the fuller the nearer to {part.high:g}"
                yield SectorPanel(title, note, part.start, part.sectors, values)
            start = stop


def _channels(block: Block, image: Any) -> Iterator[tuple[str, str, Any]]:
    if [part.meaning.split(" ")[0] for part in block.parts] == ["red", "green", "blue"]:
        yield block.name, block.view, image
        return
    for k, part in enumerate(block.parts):
        yield f"{block.name}, channel {k}", f"{part.meaning}: {part.scale}; {block.view}", image[..., k]
