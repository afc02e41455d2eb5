"""Films, replays and contact sheets of policies on the same levels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import Progress

from irsim_gym.arraytypes import Bytes
from irsim_gym.errors import IrsimGymError
from irsim_gym.training.players import Players, players

if TYPE_CHECKING:
    from irsim_gym.render.replay_data import Recording

FILMS = (".mp4", ".gif")
REPLAYS = (".html",)
PICTURES = (".png", ".jpg", ".webp", ".tif")
DRAWINGS = (".pdf", ".svg")


def record_film(
    scenario: str,
    sources: Sequence[str | Path],
    levels: Sequence[int],
    path: Path,
    *,
    console: Console | None = None,
    **chosen: Any,
) -> Path:
    """Film policies on levels, one level after another, one panel per policy; return the film's path.

    There is a frame of the start, one every ``sample_time`` and one of the end.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        levels: Levels of the split.
        path: Film to write, ``.mp4`` or ``.gif``.
        console: Where a progress bar goes; it stays quiet when that is no terminal.
        **chosen: As ``players`` takes it: split, task, names, parameters, team, strict.

    Raises:
        IrsimGymError: The file's suffix is none of a film.
    """
    from irsim_gym.render.film import EpisodeFilm

    check_suffix(path, FILMS, "a film")
    cast = players(scenario, sources, **chosen)
    film = EpisodeFilm(cast.names, fps=1.0 / (cast.steps_per_frame * cast.step_time))
    with _bar(console) as bar:
        film.write(
            (
                [_frames(cast, w, level) for w in range(len(cast.policies))]
                for level in bar.track(levels, description="filming")
            ),
            path,
        )
    cast.renderer.close()
    return path


def record_html(
    scenario: str,
    sources: Sequence[str | Path],
    levels: Sequence[int],
    path: Path,
    *,
    console: Console | None = None,
    **chosen: Any,
) -> Path:
    """Write a page that plays policies on levels, each chosen from a list; return its path.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        levels: Levels of the split.
        path: Page to write, ``.html``.
        console: Where a progress bar goes; it stays quiet when that is no terminal.
        **chosen: As ``players`` takes it: split, task, names, parameters, team, strict.

    Raises:
        IrsimGymError: The file's suffix is none of a page.
    """
    from irsim_gym.render.replay_page import save_html

    check_suffix(path, REPLAYS, "a replay")
    cast = players(scenario, sources, **chosen)
    pairs = [(w, level) for level in levels for w in range(len(cast.policies))]
    with _bar(console) as bar:
        recordings = [_recorded(cast, w, level) for w, level in bar.track(pairs, description="recording")]
    cast.renderer.close()
    return save_html(path, recordings)


def record_sheet(
    scenario: str,
    sources: Sequence[str | Path],
    levels: Sequence[int],
    path: Path,
    *,
    strobe: bool = False,
    console: Console | None = None,
    **chosen: Any,
) -> Path:
    """Put policies on levels into one picture; return its path.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        levels: Levels of the split.
        path: Picture to write, ``.png`` or another; with ``strobe`` and one episode also ``.pdf`` and ``.svg``.
        strobe: Each episode is one panel: the ways that the robots took, coloured by time, and where they stood. Else
            it is a row of moments, evenly spaced, from the first to the last.
        console: Where a progress bar goes; it stays quiet when that is no terminal.
        **chosen: As ``players`` takes it: split, task, names, parameters, team, strict.

    Raises:
        IrsimGymError: The file's suffix is none of such a picture.
    """
    from irsim_gym.render.film import EpisodeFilm
    from irsim_gym.render.sheet import contact_sheet, save_sheet
    from irsim_gym.render.strobe import draw_strobe, save_strobe

    cast = players(scenario, sources, **chosen)
    pairs = [(w, level) for level in levels for w in range(len(cast.policies))]
    check_suffix(path, (*PICTURES, *(DRAWINGS if strobe and len(pairs) == 1 else ())), "such a picture")
    with _bar(console) as bar:
        track = bar.track(pairs, description="drawing")
        if not strobe:
            shown = [_moments(cast, w, level) for w, level in track]
            return save_sheet(contact_sheet([frames for _, frames in shown], [name for name, _ in shown]), path)
        recordings = [_recorded(cast, w, level) for w, level in track]
    if len(recordings) == 1:
        return save_strobe(recordings[0], path, cast.renderer.layout)
    panels = [draw_strobe(recording, cast.renderer.layout) for recording in recordings]
    film = EpisodeFilm([recording.name for recording in recordings], fps=1.0 / cast.step_time)
    return save_sheet(film.compose(panels), path)


def _moments(cast: Players, world: int, level: int) -> tuple[str, list[Bytes]]:
    """Play a level; return what it is called, and frames of some moments."""
    from irsim_gym.render.sheet import Moments

    moments = Moments()
    for status in cast.play(world, level):
        moments.offer(lambda status=status: cast.renderer.frame(world, status))  # type: ignore[misc]
    return cast.title(world, level, status), moments.frames()


def _recorded(cast: Players, world: int, level: int) -> Recording:
    """Play a level and return what it looked like."""
    from irsim_gym.render.replay_data import Recording

    scenario, policy = cast.simulation.scenario, cast.names[world]
    details = {"policy": policy, "level": f"{level} ({cast.split})"}
    recording = Recording(scenario, cast.episodes[world].agent_names, details)
    for status in cast.play(world, level):
        scene = cast.renderer.scene(world, status)
        recording.note(scene, cast.simulation.state.pose[world], cast.values(world))
    recording.name = cast.title(world, level, status)
    return recording


def _frames(cast: Players, world: int, level: int) -> Iterator[Bytes]:
    """Play a level and yield its frames: the start, every ``sample_time``, the end."""
    for status in cast.play(world, level):
        if cast.is_frame(world):
            yield cast.renderer.frame(world, status)


def _bar(console: Console | None) -> Progress:
    screen = console or Console(stderr=True)
    return Progress(console=screen, disable=not screen.is_terminal, transient=True)


def check_suffix(path: Path, known: Sequence[str], what: str) -> None:
    """Raise an ``IrsimGymError`` where a file's name has none of the known suffixes."""
    if path.suffix.lower() not in known:
        raise IrsimGymError(f"{what}'s name ends in {' or '.join(known)}, got '{path.name}'")
