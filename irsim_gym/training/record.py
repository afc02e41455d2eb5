"""Films of policies on the same levels, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import Progress

from irsim_gym.arraytypes import Bytes
from irsim_gym.envs.pictures import world_status
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.policy import Policy, by_agent
from irsim_gym.tasks import Episodes, Outcome
from irsim_gym.training.policies import load_policy, policy_names
from irsim_gym.training.worlds import make_episodes

if TYPE_CHECKING:
    from irsim_gym.render import WorldRenderer

SUFFIXES = (".mp4", ".gif")


def record_film(
    scenario: str,
    sources: Sequence[str | Path],
    levels: Sequence[int],
    path: Path,
    *,
    split: str = "test",
    task: str | None = None,
    names: Sequence[str] | None = None,
    console: Console | None = None,
    parameters: Mapping[str, Any] | None = None,
    team: bool = False,
    backend: str = "matplotlib",
) -> Path:
    """Film policies on levels, one level after another, one panel per policy; return the film's path.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        sources: Policies as ``load_policy`` takes them.
        levels: Levels of the split.
        path: Film to write, ``.mp4`` or ``.gif``.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        task: Shipped name or path of a task; None for the scenario's own.
        names: Captions; None to take them from the sources.
        console: Where a progress bar goes; it stays quiet when that is no terminal.
        parameters: Values for the scenario's parameters.
        team: The policies drive all robots, unless the task names some.
        backend: Who draws: ``"matplotlib"`` or ``"raster"``.

    Raises:
        IrsimGymError: The file's suffix is none of a film.
    """
    from irsim_gym.render import make_renderer
    from irsim_gym.render.film import EpisodeFilm

    if path.suffix.lower() not in SUFFIXES:
        raise IrsimGymError(f"a film's name ends in {' or '.join(SUFFIXES)}, got '{path.name}'")
    policies = [load_policy(source) for source in sources]
    episodes = make_episodes(scenario, task=task, n_worlds=len(policies), parameters=parameters, team=team)
    simulation = episodes.simulation
    parts = simulation.model, simulation.state, simulation.sensors
    learners = simulation.agents.tolist()
    renderer = make_renderer(backend, simulation.scenario, *parts, learners=learners, explored=simulation.explored)
    captions = policy_names(sources) if names is None else names
    film = EpisodeFilm(captions, fps=1.0 / float(simulation.model.step_time[0]))
    screen = console or Console(stderr=True)
    with Progress(console=screen, disable=not screen.is_terminal, transient=True) as bar:
        film.write(
            (
                [_episode(episodes, renderer, policy, w, level, split) for w, policy in enumerate(policies)]
                for level in bar.track(levels, description="filming")
            ),
            path,
        )
    renderer.close()
    return path


def _episode(
    episodes: Episodes, renderer: WorldRenderer, policy: Policy, world: int, level: int, split: str
) -> Iterator[Bytes]:
    """Drive one world through a level and yield its frames, that of the start first."""
    worlds, first = np.array([world]), np.array([level])
    episodes.begin(worlds, first, split)
    policy.begin(episodes, worlds, first)
    renderer.clear(world)
    yield renderer.frame(world, world_status(episodes, world))
    while (episodes.view.infos["outcome"][world] == Outcome.RUNNING).any():
        chosen = by_agent(policy.act(episodes, worlds), episodes, worlds)
        actions = np.zeros((episodes.n_worlds, *chosen.shape[1:]), chosen.dtype)
        actions[world] = chosen[0]
        episodes.step(actions, worlds)
        yield renderer.frame(world, world_status(episodes, world))
