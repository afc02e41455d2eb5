"""The command ``irsim-gym levels show``: draw the starts of several levels into one picture."""

from functools import partial
from pathlib import Path

import numpy as np

from irsim_gym.base.arraytypes import Bytes, Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.envs.parts.pictures import make_renderer
from irsim_gym.evaluation.levels.certificate import Certificate
from irsim_gym.evaluation.levels.level_commands import WORLDS
from irsim_gym.evaluation.levels.played import played_levels
from irsim_gym.evaluation.protocol.protocol import check_count
from irsim_gym.evaluation.requests.inputs import check_inputs
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.simulator.engine import Simulation

SIDE = 320
"""Width to which frames are reduced [pixel]."""


def show_levels(request: ScenarioRequest, split: str, count: int, number: int, out: Path | None) -> Path:
    """Draw the starts of levels into one picture, and return its path.

    Args:
        count: Number of levels to choose from, limited to those of the certificate or the file of levels.
        number: Number of levels to show: evenly spaced by difficulty, or the first ones without a certificate.
        out: File to write, ``.png``; None for a default name in the current folder.

    Raises:
        IrsimGymError: If the file has another suffix.
    """
    check_inputs(request, partial(_check_suffix, out), split=split)
    simulation = request.simulation(min(WORLDS, count))
    _, n_levels = simulation.level_base(split)
    certificate = _certificate(simulation, split, min(count, n_levels) if n_levels else count)
    first = np.arange(min(number, n_levels or number))
    chosen = first if certificate is None else _by_difficulty(certificate, count, number)
    check_count(simulation, split, int(chosen.max()) + 1)
    path = out or Path(f"{simulation.scenario.name}-levels.png")
    _draw(simulation, split, chosen, certificate, path)
    return path


def _check_suffix(out: Path | None) -> None:
    if out is not None and out.suffix != ".png":
        raise IrsimGymError(f"a sheet of levels is a .png file, got '{out.name}'")


def _certificate(simulation: Simulation, split: str, count: int) -> Certificate | None:
    """Return the certificate of a split's levels, which may cover fewer levels than requested; None without one."""
    few = played_levels(simulation, split, 1).certificate
    return None if few is None else played_levels(simulation, split, min(count, few.count)).certificate


def _by_difficulty(certificate: Certificate, count: int, number: int) -> Ints:
    """Return levels that are evenly spaced in the order of difficulty."""
    ranked = certificate.ranked(min(count, certificate.count))
    return ranked[np.unique(np.rint(np.linspace(0, len(ranked) - 1, min(number, len(ranked)))).astype(np.int64))]


def _draw(simulation: Simulation, split: str, levels: Ints, certificate: Certificate | None, path: Path) -> None:
    """Draw the starts of levels, each with its number and, if certified, its difficulty and path length."""
    from irsim_gym.rendering.films.film import EpisodeFilm
    from irsim_gym.rendering.looks.images import reduced, save_picture

    renderer = make_renderer(simulation)
    frames: list[Bytes] = []
    for level in levels.tolist():
        simulation.reset(level, split)
        renderer.clear(0)
        frames.append(reduced(renderer.frame(0), SIDE))
    renderer.close()
    film = EpisodeFilm([_caption(level, certificate) for level in levels.tolist()], fps=1.0)
    save_picture(film.compose(frames), path)


def _caption(level: int, certificate: Certificate | None) -> str:
    if certificate is None:
        return f"level {level}"
    length = certificate.length[level].max()
    return f"{level}: {100.0 * certificate.difficulty[level]:.0f} % fail, {length:.1f} m"
