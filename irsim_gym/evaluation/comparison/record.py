"""Films and replay pages of policies on the same levels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.gymnasium.replays import agent_values
from irsim_gym.evaluation.comparison.players import Players, load_players
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest

if TYPE_CHECKING:
    from irsim_gym.rendering.replay.replay_data import Recording

FILMS = (".mp4", ".gif")
REPLAYS = (".html",)


def record_film(
    request: ScenarioRequest, sources: Sequence[str | Path], levels: Sequence[int], path: Path, **chosen: Any
) -> Path:
    """Film policies on levels, one level after the other with one panel per policy, and return the film's path.

    The film has a frame at the start, one every ``sample_time``, and one at the end of each episode.

    Args:
        sources: Policies, as ``load_policy`` takes them.
        path: Film to write, ``.mp4`` or ``.gif``.
        **chosen: ``split`` and ``names`` of ``load_players``.

    Raises:
        IrsimGymError: If the file's suffix is not that of a film.
    """
    from irsim_gym.rendering.films.film import EpisodeFilm

    check_output(path, "film")
    cast = load_players(request, sources, **chosen)
    film = EpisodeFilm(cast.names, fps=1.0 / (cast.steps_per_frame * cast.step_time))
    with progress_bar() as bar:
        shown = bar.track(levels, description="filming")
        film.write(([_frames(cast, w, level) for w in range(len(cast.policies))] for level in shown), path)
    cast.renderer.close()
    return path


def record_html(
    request: ScenarioRequest, sources: Sequence[str | Path], levels: Sequence[int], path: Path, **chosen: Any
) -> Path:
    """Write a page that replays policies on levels, with a list to choose an episode from, and return its path.

    Args:
        sources: Policies, as ``load_policy`` takes them.
        path: Page to write, ``.html``.
        **chosen: ``split`` and ``names`` of ``load_players``.

    Raises:
        IrsimGymError: If the file's suffix is not ``.html``.
    """
    from irsim_gym.rendering.replay.replay_page import save_html

    check_output(path, "replay")
    return save_html(path, _recordings(load_players(request, sources, **chosen), levels))


def _recordings(cast: Players, levels: Sequence[int]) -> list[Recording]:
    """Return a recording of each level and policy, and show the progress."""
    pairs = [(w, level) for level in levels for w in range(len(cast.policies))]
    with progress_bar() as bar:
        recordings = [recorded_episode(cast, w, level) for w, level in bar.track(pairs, description="recording")]
    cast.renderer.close()
    return recordings


def recorded_episode(cast: Players, world: int, level: int) -> Recording:
    """Play a level, and return its recording."""
    from irsim_gym.rendering.replay.replay_data import Recording

    scenario, policy = cast.simulation.scenario, cast.names[world]
    details = {"policy": policy, "level": f"{level} ({cast.split})"}
    recording = Recording(scenario, cast.episodes[world].agent_names, details)
    for status in cast.play(world, level):
        scene = cast.renderer.scene(world, status)
        recording.note(scene, cast.simulation.state.pose[world], agent_values(cast.episodes[world], world))
    recording.name = cast.title(world, level, status)
    return recording


def _frames(cast: Players, world: int, level: int) -> Iterator[Bytes]:
    """Play a level, and yield its frames: the start, every ``sample_time``, and the end."""
    for status in cast.play(world, level):
        if cast.is_frame(world):
            yield cast.renderer.frame(world, status)


def check_output(path: Path | None, kind: str) -> None:
    """Check that the name of a file, if any, fits what is written into it.

    Args:
        path: The file; None for a default name.
        kind: ``film`` or ``replay``.

    Raises:
        IrsimGymError: If it has another suffix.
    """
    suffixes = FILMS if kind == "film" else REPLAYS
    if path is not None and path.suffix.lower() not in suffixes:
        raise IrsimGymError(f"a {kind}'s name ends in {' or '.join(suffixes)}, got '{path.name}'")
