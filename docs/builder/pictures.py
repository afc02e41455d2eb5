"""Pictures and films of the gallery."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image

import irsim_gym
from irsim_gym.errors import IrsimGymError
from irsim_gym.render import Renderer
from irsim_gym.scenario import load_scenario
from irsim_gym.training.inspection import begin_level

SIZE = 480
"""Longer side of a picture and of a film [pixels]."""
EXTRA = "extra"
"""Folder beside that of the pictures whose content Sphinx copies to the top of the site."""
MOST_FRAMES = 150
PER_SECOND = 15
ROOT = Path(__file__).parents[2]
DRAWING = ("irsim_gym/render", "irsim_gym/raster")
"""What a picture depends on beside its scenario; a film of an older step stays until ``make clean``."""


@dataclass(frozen=True)
class Pictures:
    """Which pictures of a scenario are there."""

    level: bool
    film: bool


def existing(name: str, folder: Path) -> Pictures:
    """Return which pictures of a scenario are there."""
    film = film_of(name, folder)
    return Pictures((folder / f"{name}.png").is_file(), film.is_file() and film.stat().st_size > 0)


def film_of(name: str, folder: Path) -> Path:
    """Return the file of a film, which is empty where nothing moves."""
    return folder.parent / EXTRA / "films" / f"{name}.mp4"


def draw(name: str, file: Path, folder: Path) -> None:
    """Draw a level and film it, if what is there is older than what it shows."""
    picture, film = folder / f"{name}.png", film_of(name, folder)
    newest = max(file.stat().st_mtime, _newest_drawing())
    if film.is_file() and picture.is_file() and min(picture.stat().st_mtime, film.stat().st_mtime) > newest:
        return
    for place in (folder, film.parent):
        place.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # files of IR-SIM's warn when they are loaded; check is there to tell
        level(name).save(picture, optimize=True)
        _write_film(name, film)


def level(name: str) -> Image.Image:
    """Return a picture of the first level, without title and axes."""
    scenario = load_scenario(name)
    plot = replace(scenario.world.plot, show_title=False, no_axis=True, tight=True)
    scenario = replace(scenario, world=replace(scenario.world, plot=plot))
    begun = begin_level(scenario)
    parts = begun.model, begun.state, begun.sensors
    renderer = Renderer(scenario, *parts, learners=begun.agents.tolist(), explored=begun.explored)
    frame = Image.fromarray(np.asarray(renderer.frame(0)))
    renderer.close()
    return _small(frame).quantize(128)


def _write_film(name: str, film: Path) -> None:
    """Film the behaviours of a file; the film is empty where no frame differs from the first."""
    import imageio.v3 as iio

    frames = _frames(name)
    if all(np.array_equal(frames[0], frame) for frame in frames[1:]):
        film.write_bytes(b"")
        return
    unfinished = film.with_name(f"unfinished-{film.name}")
    iio.imwrite(unfinished, np.stack(frames), fps=PER_SECOND, codec="libx264", macro_block_size=2)
    unfinished.replace(film)


def _frames(name: str) -> list[np.ndarray]:
    frames = []
    with irsim_gym.load(name, seed=0, render_mode="rgb_array") as world:
        every = max(1, round(2 / (PER_SECOND * world.step_time)))  # twice as fast as the world
        for step in range(MOST_FRAMES * every):
            if step % every == 0:
                frames.append(np.asarray(_small(Image.fromarray(np.asarray(world.render())))))
            if world.done():
                break
            try:
                world.step()
            except IrsimGymError:  # nobody drives: a file for scripts
                break
    return frames


def _small(picture: Image.Image) -> Image.Image:
    scale = SIZE / max(picture.size)
    width, height = (2 * round(scale * side / 2) for side in picture.size)
    return picture.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)


@cache
def _newest_drawing() -> float:
    files = (file for place in DRAWING for file in (ROOT / place).rglob("*.py"))
    return max(file.stat().st_mtime for file in (Path(__file__), *files))
