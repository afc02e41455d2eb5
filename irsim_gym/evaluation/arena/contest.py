"""The arena: an evaluation with a page that compares its policies level by level."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from irsim_gym.base.version import __version__
from irsim_gym.envs.gymnasium.worlds import ScenarioSource, TaskSource
from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.arena.page_data import page_data
from irsim_gym.evaluation.arena.page_file import write_page
from irsim_gym.evaluation.arena.shown_episodes import choose_episodes, record_episodes
from irsim_gym.evaluation.arena.standings import Standings, stand
from irsim_gym.evaluation.comparison.comparison import sources_of
from irsim_gym.evaluation.comparison.evaluate import WORLDS, Evaluation, play, prepare, write_results
from irsim_gym.evaluation.policies.perception import Perceived
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.requests.folders import check_no_results
from irsim_gym.evaluation.requests.methods import Sources, by_method, names_of_policies
from irsim_gym.evaluation.requests.scenario_request import ScenarioRequest
from irsim_gym.evaluation.saved_policies.policies import Source, policy_digest
from irsim_gym.evaluation.saved_policies.snapshot import snapshot_of
from irsim_gym.tasks.episodes.levels import check_split

REPLAYS = 200
PAGE = "arena.html"


@dataclass(frozen=True)
class Arena:
    """Results of policies on the same levels, as the arena's folder holds them.

    Attributes:
        evaluation: The results of each policy.
        standings: The comparison of the policies.
        page: Path of the page for a browser.
    """

    evaluation: Evaluation
    standings: Standings
    page: Path

    @property
    def rows(self) -> dict[str, list[Any]]:
        """For each policy an ``EpisodeRow`` for each level; a ``TeamRow`` for teams."""
        return self.evaluation.rows

    def __str__(self) -> str:
        return str(self.evaluation)


def arena(
    scenario: ScenarioSource,
    policies: Source | Sources,
    folder: str | Path,
    *,
    levels: int = 1000,
    split: str = "test",
    task: TaskSource = None,
    team: bool = False,
    replays: int = REPLAYS,
    overwrite: bool = False,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
    console: Console | None = None,
) -> Arena:
    """Play the same levels with all policies, and write the results and a page that compares them.

    The folder gets ``arena.html`` (a self-contained page), and ``episodes.csv``, ``summary.json``, ``table.txt`` and,
    for teams, ``levels.csv`` as ``irsim_gym.evaluate`` writes them; see docs/arena.md.

    Args:
        scenario: Shipped name, id, path of a YAML file, plain data or a loaded scenario.
        policies: One policy, several, or several by their names in the results; each as ``evaluate`` takes it.
        folder: Folder of the results.
        levels: Number of levels of the split, from level 0.
        split: ``"test"``, which no training meets, ``"dev"`` or ``"train"``.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        team: Whether the policy drives all robots, each by its own observation.
        replays: Maximum number of episodes that the page can replay.
        overwrite: Replace the results in the folder.
        parameters: Values for the scenario's parameters.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        console: Console of the progress bar, which is shown only on a terminal.

    Raises:
        ValueError: If there is no level to play.
        IrsimGymError: If policies do not exist or do not fit the task, or the folder holds results.
    """
    place, sources = Path(folder), sources_of(policies, levels)
    check_split(split)
    check_no_results(place, overwrite)
    request = ScenarioRequest(scenario, task, team, parameters, strict)
    players, seeds, worlds = prepare(request, sources, min(WORLDS, levels))
    evaluation = play(players, seeds, worlds, levels, split, team=team, console=console)
    standings, board = stand(evaluation), Board.of(evaluation.rows)
    told = {**_told(request, evaluation, worlds), "policies": _entrants(sources, evaluation.observes)}
    summary = write_results(place, evaluation, worlds.episodes, arena=told, **standings.figures())
    chosen = choose_episodes(board, max(replays, 0))
    recorded = record_episodes(board, list(players.values()), worlds, split, chosen)
    data = page_data(evaluation.title, board, standings, summary)
    with progress_bar(console) as bar:
        track = bar.track(recorded, total=len(chosen), description="recording")
        write_page(place / PAGE, data, board, track, chosen)
    return Arena(evaluation, standings, place / PAGE)


def _told(request: ScenarioRequest, evaluation: Evaluation, worlds: Perceived) -> dict[str, Any]:
    """Return a description of what is played, as plain data."""
    digest = snapshot_of(worlds.episodes.simulation.scenario, request.task).digest
    places = {"source": _place_of(request.scenario), "task": _place_of(request.task), "scenario_sha256": digest}
    levels = {"levels": evaluation.level_set.count, **evaluation.level_set.conditions()}
    about = {"scenario": evaluation.scenario, **places, "split": evaluation.split, **levels}
    return {**about, "team": request.team, "irsim_gym": __version__}


def _entrants(sources: Sources, observes: Mapping[str, Sequence[str]]) -> list[dict[str, Any]]:
    """Return the name, the source and the hash of each policy, and what it observes."""
    methods, told = by_method(sources), []
    for method, names in names_of_policies(methods).items():
        for name, source in zip(names, methods[method], strict=True):
            place = _place_of(source)
            entry = {"name": name, "source": place, "sha256": None if place is None else policy_digest(place)}
            told.append(entry | ({"observes": observes[name]} if name in observes else {}))
    return told


def _place_of(source: object) -> str | None:
    return str(source) if isinstance(source, str | Path) else None
