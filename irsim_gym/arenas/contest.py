"""The arena: policies play the same levels, and a page compares them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from irsim_gym.arenas.archive import PAGE, TABLE, Archive, holds_arena
from irsim_gym.arenas.board import Board
from irsim_gym.arenas.entrants import Entrant, load_entrants, place_of
from irsim_gym.arenas.page_data import page_data
from irsim_gym.arenas.page_file import write_page
from irsim_gym.arenas.shown_episodes import choose_episodes, record_episodes
from irsim_gym.arenas.standings import Standings, stand
from irsim_gym.envs.worlds import ScenarioSource, TaskSource
from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.perception import Perceived
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.progress_bars import progress_bar
from irsim_gym.evaluation.tables import table_text, write_text
from irsim_gym.levels.played import played_levels
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.levels import check_split
from irsim_gym.training.episode_setup import conditions, make_episodes, team_conditions
from irsim_gym.training.evaluate import WORLDS, play_policies
from irsim_gym.training.fitting import check_policies, report_perceptions
from irsim_gym.training.folders import has_results
from irsim_gym.training.machine import machine
from irsim_gym.training.policies import Source, policy_names
from irsim_gym.training.snapshot import snapshot_of
from irsim_gym.version import __version__

REPLAYS = 200


@dataclass(frozen=True)
class Arena:
    """Results of policies on the same levels, as the arena's folder holds them.

    Attributes:
        title: The scenario and the levels.
        rows: For each policy an ``EpisodeRow`` for each level; a ``TeamRow`` for teams.
        standings: The comparison of the policies.
        page: Path of the page for a browser.
    """

    title: str
    rows: dict[str, list[Any]]
    standings: Standings
    page: Path

    def __str__(self) -> str:
        return "\n".join(map(table_text, self.standings.tables(self.title)))


def arena(
    scenario: ScenarioSource,
    policies: Source | Sequence[Source] | Mapping[str, Source],
    folder: str | Path,
    *,
    levels: int = 1000,
    split: str = "test",
    task: TaskSource = None,
    team: bool = False,
    replays: int = REPLAYS,
    resume: bool = False,
    overwrite: bool = False,
    parameters: Mapping[str, object] | None = None,
    strict: bool = True,
    console: Console | None = None,
) -> Arena:
    """Play the same levels with all policies, and write the results and a page that compares them.

    The folder gets ``arena.html`` (a self-contained page), ``episodes.csv`` (a row for each episode; for teams, a row
    for each agent, and also ``levels.csv``), ``summary.json`` and ``table.txt``; see docs/arena.md.

    Args:
        scenario: Shipped name, id, path of a YAML file, plain data or a loaded scenario.
        policies: One policy, several, or several by their names in the results; each as ``evaluate`` takes it.
        folder: Folder of the results.
        levels: Number of levels of the split, from level 0.
        split: ``"test"``, which no training meets, ``"dev"`` or ``"train"``.
        task: Shipped name, path or plain data of a task; None for the scenario's own.
        team: Whether the policy drives all robots, each by its own observation.
        replays: Maximum number of episodes that the page can replay.
        resume: Continue the arena in the folder: finished policies do not play again, and new ones may join.
        overwrite: Replace the arena in the folder.
        parameters: Values for the scenario's parameters.
        strict: False ignores unused keys with an ``IgnoredKeyWarning``; True raises an error.
        console: Console of the progress bar, which is shown only on a terminal.

    Raises:
        ValueError: If there is no level to play.
        IrsimGymError: If policies do not exist or do not fit the task, or the folder holds another arena.
    """
    place = _place(Path(folder), levels, split, resume=resume, overwrite=overwrite)
    entrants = _entrants(policies, place if resume and holds_arena(place) else None)
    made: dict[str, Any] = {"task": task, "parameters": parameters, "team": team, "strict": strict}
    episodes = make_episodes(scenario, n_worlds=min(WORLDS, levels), **made)
    contest = Contest(entrants, episodes, place, levels, split, team=team)
    told = contest.told(scenario, task)
    return contest.run(told, max(replays, 0), console, resume=resume)


class Contest:
    """Policies, the worlds they play in, and the folder of the results.

    Args:
        folder: Folder of the results.
        levels: Number of levels of the split, from level 0.
        team: Whether the task's agents are a team.

    Raises:
        IrsimGymError: If some policies do not fit the task.
    """

    def __init__(
        self, entrants: Sequence[Entrant], episodes: Episodes, folder: Path, levels: int, split: str, *, team: bool
    ) -> None:
        self.entrants, self.episodes, self.levels, self.split = entrants, episodes, levels, split
        self.team, self.worlds = team, Perceived(episodes)
        self.players: dict[str, Policy] = {entrant.name: entrant.policy for entrant in entrants}
        check_policies(self.players, self.worlds)
        report_perceptions(self.players, self.worlds)
        self.level_set = played_levels(episodes.simulation, split, levels)
        limit = episodes.task.max_steps * float(episodes.simulation.model.step_time[0])
        self.archive = Archive(folder, team, limit, levels)

    def told(self, source: ScenarioSource, task: TaskSource) -> dict[str, Any]:
        """Return the description of the arena, as plain data.

        Args:
            source: The scenario, as ``arena`` takes it.
            task: The task; None for the scenario's own.
        """
        scenario = self.episodes.simulation.scenario
        return {
            "scenario": scenario.label,
            "source": place_of(source),
            "task": place_of(task),
            "scenario_sha256": snapshot_of(scenario, task).digest,
            "split": self.split,
            "levels": self.levels,
            **self.level_set.conditions(),
            "team": self.team,
            "irsim_gym": __version__,
            "policies": [entrant.told(self.worlds) for entrant in self.entrants],
        }

    def run(self, told: Mapping[str, object], replays: int, console: Console | None, *, resume: bool) -> Arena:
        """Play the levels that have not been played, and write the results."""
        if resume and holds_arena(self.archive.folder):
            self.archive.go_on(told)
        else:
            self.archive.begin(told)
        self._play(console)
        rows = {name: self.archive.rows[name] for name in self.players}
        standings = stand(rows, team=self.team, level_set=self.level_set)
        whose = f" {self.episodes.n_agents} robots," if self.team else ""
        title = f"{told['scenario']}:{whose} {self.levels:,} {self.split} levels, {self.level_set}"
        found = Arena(title, rows, standings, self.archive.folder / PAGE)
        named = (team_conditions if self.team else conditions)(self.episodes, self.split, self.levels)
        summary = {"arena": told, "conditions": named, "machine": machine(), **standings.figures()}
        self.archive.finish(list(self.players), summary)
        write_text(self.archive.folder / TABLE, str(found))
        self._write_page(found, summary, replays, console)
        return found

    def _play(self, console: Console | None) -> None:
        """Play all policies that have not finished, one after another."""
        waiting = {name: policy for name, policy in self.players.items() if name not in self.archive.rows}
        played = play_policies(waiting, self.worlds, self.levels, self.split, team=self.team, console=console)
        for name, rows in played:
            self.archive.keep(name, rows)

    def _write_page(self, found: Arena, summary: Mapping[str, object], replays: int, console: Console | None) -> None:
        """Record some episodes again, and write the page."""
        board = Board.of(found.rows)
        chosen = choose_episodes(board, replays)
        recorded = record_episodes(board, list(self.players.values()), self.worlds, self.split, chosen)
        data = page_data(found.title, board, found.standings, summary)
        with progress_bar(console) as bar:
            track = bar.track(recorded, total=len(chosen), description="recording")
            write_page(found.page, data, board, track, chosen)


def _place(folder: Path, levels: int, split: str, *, resume: bool, overwrite: bool) -> Path:
    """Return the folder, after checking that an arena may write there.

    Raises:
        ValueError: If there is no level to play.
        IrsimGymError: If the folder holds results, and neither ``resume`` nor ``overwrite`` is set, or both are.
    """
    if levels < 1:
        raise ValueError(f"levels must be >= 1, got {levels}")
    check_split(split)
    if resume and overwrite:
        raise IrsimGymError("--resume continues an arena and --overwrite replaces it: pass only one of them")
    if resume and has_results(folder) and not holds_arena(folder):
        raise IrsimGymError(f"{folder} holds no arena that could be resumed, but other results")
    if has_results(folder) and not (resume or overwrite):
        raise IrsimGymError(
            f"{folder} holds results: choose another folder with --out, continue them with --resume, or replace them "
            "with --overwrite"
        )
    return folder


def _entrants(policies: Source | Sequence[Source] | Mapping[str, Source], resumed: Path | None) -> list[Entrant]:
    """Load policies, after those of an arena that is resumed."""
    known: dict[str, Any] = {}
    if resumed is not None:
        told = Archive(resumed, False, 0.0).told()["policies"]
        known = {policy["name"]: policy["source"] for policy in told if policy["source"] is not None}
    if isinstance(policies, Mapping):
        return load_entrants({**known, **policies})
    sources: Any = policies
    if not isinstance(sources, Sequence) or isinstance(sources, str):
        sources = [sources]
    new = [source for source in sources if not isinstance(source, str | Path) or str(source) not in known.values()]
    return load_entrants({**known, **dict(zip(policy_names(new), new, strict=True))})
