"""Films of the gallery: who drives in them, and their frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from PIL import Image

import irsim_gym
from builder.records import cards_in, references
from irsim_gym.base.arraytypes import Bytes
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.comparison.players import Players, load_players
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.cards import PolicyCard
from irsim_gym.evaluation.suite.members import shipped_suite
from irsim_gym.scenario.reading.load import load_scenario

SIZE = 480
"""Longer side of a frame [pixels]."""
PER_SECOND = 15
SPEED = 2
"""How many times as fast as the world a film runs."""
MOST_FRAMES = 480
MOST_OF_FILE = 150
"""Frames of a film in which the behaviours of a file drive: it may never end."""
LEVELS = 10


@dataclass(frozen=True)
class Driver:
    """The policy that drives in a film.

    Attributes:
        source: The policy, as ``load_policy`` takes it; None for the behaviours of the file.
        team: The policy drives all robots.
        text: Who drives, in Markdown.
        levels: How many levels are tried until one is solved.
    """

    source: str | None
    team: bool
    text: str
    levels: int = LEVELS


@dataclass(frozen=True)
class Film:
    """Frames ``(n_frames, height, width, 3)`` and a caption in Markdown."""

    frames: list[Bytes]
    caption: str


def film(name: str) -> Film:
    """Film the best policy of the shelf or of the suite's reference rows, else the behaviours of the file."""
    driver = driver_of(name)
    if driver.source is None:
        return Film(list(_loaded_frames(name)), f"{driver.text} in this film.")
    return _policy_film(name, driver)


def driver_of(name: str) -> Driver:
    """Return who drives in the film of a scenario."""
    return _trained(name) or _reference(name) or _planner(name)


def _trained(name: str) -> Driver | None:
    """Return the policy of the shelf that succeeds most often in a scenario."""
    cards = cards_in(name)
    if not cards:
        return None
    best = max(cards, key=_success)
    return Driver(best.name, best.scenario.team is not None, f"The shipped policy `{best.name}` drives")


def _success(card: PolicyCard) -> float:
    shares = [one.success.value for one in card.results if one.parameters == card.scenario.parameters]
    return max(shares, default=0.0)


def _reference(name: str) -> Driver | None:
    """Return the method that succeeds most often in the benchmark of a scenario."""
    record = references()
    for member in shipped_suite().members.values():
        figures = record.figures.get(member.name, {}) if member.scenario == name and not member.parameters else {}
        if figures:
            planned = [method for method in reversed(figures) if method != "random"]  # of equals the later, a planner
            best = max(planned, key=lambda method: figures[method]["success"]["value"])
            source = record.methods[best][0]["source"]
            return Driver(source, member.team, f"The behaviour `{source}` drives", member.levels_of(LEVELS))
    return None


def _planner(name: str) -> Driver:
    """Return `pursuit` for a robot that has no behaviour, else the behaviours of the file."""
    scenario = load_scenario(name)
    robots = [scenario.bodies[number] for number in scenario.robots]
    if robots and all(robot.renewal is None for robot in robots):
        return Driver("pursuit", len(robots) > 1, "The behaviour `pursuit` drives")
    return Driver(None, False, "The behaviours of the file drive")


def _policy_film(name: str, driver: Driver) -> Film:
    """Film the first level that is solved, or the last of those that are tried."""
    cast = load_players(ScenarioRequest(name, team=driver.team), [driver.source or ""])
    level, ending = _first_solved(cast, driver.levels)
    frames = list(islice(_played_frames(cast, level), MOST_FRAMES))
    cast.renderer.close()
    return Film(frames, f"{driver.text} in this film of `test` level {level}: {ending.replace('_', ' ')}.")


def _first_solved(cast: Players, levels: int) -> tuple[int, str]:
    """Return the first level that is solved, else the last one, and how it ends; nothing is drawn."""
    level, ending = 0, ""
    for level in range(levels):
        *_, ending = cast.play(0, level)
        if ending == "success":
            break
    return level, ending


def _played_frames(cast: Players, level: int) -> Iterator[Bytes]:
    every = _steps_per_frame(cast.step_time)
    for step, status in enumerate(cast.play(0, level)):
        if step % every == 0 or status != "running":
            yield small(np.asarray(cast.renderer.frame(0, status)))


def _loaded_frames(name: str) -> Iterator[Bytes]:
    with irsim_gym.load(name, seed=0, render_mode="rgb_array") as world:
        every = _steps_per_frame(world.step_time)
        for step in range(MOST_OF_FILE * every):
            if step % every == 0:
                yield small(np.asarray(world.render()))
            if world.done():
                break
            try:
                world.step()
            except IrsimGymError:  # nobody drives: a file for scripts
                break


def _steps_per_frame(step_time: float) -> int:
    return max(1, round(SPEED / (PER_SECOND * step_time)))


def small(picture: Bytes) -> Bytes:
    """Return a picture whose longer side has ``SIZE`` pixels and whose sides are even."""
    image = Image.fromarray(picture)
    scale = SIZE / max(image.size)
    width, height = (2 * round(scale * side / 2) for side in image.size)
    return np.asarray(image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS))


def write_film(shown: Film, path: Path) -> None:
    """Write a film; the file is empty if no frame differs from the first."""
    import imageio.v3 as iio

    if all(np.array_equal(shown.frames[0], frame) for frame in shown.frames[1:]):
        path.write_bytes(b"")
        return
    unfinished = path.with_name(f"unfinished-{path.name}")
    iio.imwrite(unfinished, np.stack(shown.frames), fps=PER_SECOND, codec="libx264", macro_block_size=2)
    unfinished.replace(path)
