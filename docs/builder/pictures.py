"""Pictures and films of the gallery."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image

from builder.films import film, small, write_film
from irsim_gym.cli.work.inspection import begin_level
from irsim_gym.rendering import Renderer
from irsim_gym.scenario import load_scenario

EXTRA = "extra"
"""Folder beside that of the pictures whose content Sphinx copies to the top of the site."""
ROOT = Path(__file__).parents[2]
DRAWING = ("irsim_gym/rendering", "agents/shelf")
"""What pictures depend on beside their scenarios; a film of an older step stays until ``make clean``."""


@dataclass(frozen=True)
class Pictures:
    """Which pictures of a scenario exist.

    Attributes:
        level: There is a picture of a level.
        film: Caption of the film in Markdown; empty if there is none.
    """

    level: bool
    film: str


def existing(name: str, folder: Path) -> Pictures:
    """Return which pictures of a scenario exist."""
    path, caption = film_of(name, folder), _caption_of(name, folder)
    is_filmed = path.is_file() and path.stat().st_size > 0 and caption.is_file()
    return Pictures((folder / f"{name}.png").is_file(), caption.read_text(encoding="utf-8") if is_filmed else "")


def film_of(name: str, folder: Path) -> Path:
    """Return the file of a film, which is empty if nothing moves."""
    return folder.parent / EXTRA / "films" / f"{name}.mp4"


def _caption_of(name: str, folder: Path) -> Path:
    return folder / f"{name}.txt"


def draw(name: str, file: Path, folder: Path) -> None:
    """Draw a level and film it, if what is there is older than what it shows."""
    files = picture, path, caption = folder / f"{name}.png", film_of(name, folder), _caption_of(name, folder)
    newest = max(file.stat().st_mtime, _newest_drawing())
    if all(one.is_file() and one.stat().st_mtime > newest for one in files):
        return
    for place in (folder, path.parent):
        place.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # files of IR-SIM's warn when they are loaded; check is there to tell
        level(name).save(picture, optimize=True)
        shown = film(name)
        write_film(shown, path)
        caption.write_text(shown.caption, encoding="utf-8")


def level(name: str) -> Image.Image:
    """Return a picture of the first level, without title and axes."""
    scenario = load_scenario(name)
    plot = replace(scenario.world.plot, show_title=False, no_axis=True, tight=True)
    scenario = replace(scenario, world=replace(scenario.world, plot=plot))
    begun = begin_level(scenario)
    parts = begun.model, begun.state, begun.sensors
    renderer = Renderer(scenario, *parts, learners=begun.agents.tolist(), explored=begun.explored)
    frame = small(np.asarray(renderer.frame(0)))
    renderer.close()
    return Image.fromarray(frame).quantize(128)


@cache
def _newest_drawing() -> float:
    files = (file for place in DRAWING for file in (ROOT / place).rglob("*") if file.suffix in (".py", ".npz"))
    here = Path(__file__), Path(__file__).with_name("films.py")
    return max(file.stat().st_mtime for file in (*here, *files))
