"""Plays the suite: every method on every benchmark, with one file of rows per policy."""

import math
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress, TaskID

from irsim_gym.base.errors import IrsimGymError
from irsim_gym.base.outside_files import reading, remove
from irsim_gym.evaluation.comparison.evaluate import WORLDS
from irsim_gym.evaluation.curves.factors import disturbed
from irsim_gym.evaluation.curves.robustness import robustness
from irsim_gym.evaluation.levels.played import played_levels
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.policies.behavior_policies import UnfitBehaviorError
from irsim_gym.evaluation.policies.perception import Perceived, UnfitPerceptionError
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.protocol.tables import plain
from irsim_gym.evaluation.protocol.teams import evaluate_team
from irsim_gym.evaluation.requests.episode_setup import make_episodes, team_conditions
from irsim_gym.evaluation.requests.folders import as_name
from irsim_gym.evaluation.requests.methods import ComparedMethod, names_of_policies
from irsim_gym.evaluation.saved_policies.policies import UnfitPolicyError, load_policy
from irsim_gym.evaluation.suite.members import Member
from irsim_gym.evaluation.suite.row_files import write_rows
from irsim_gym.evaluation.suite.scores import score_suite
from irsim_gym.evaluation.suite.suite_record import RECORD, ROWS, SUMMARY, SuiteRecord, read_record
from irsim_gym.scenario.specs.library import configs_folder
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.episodes.levels import check_split

LATENCY = "latency"
"""Folder of the curves over the latency, one for each benchmark."""


def play_suite(
    members: Sequence[Member],
    methods: Sequence[ComparedMethod],
    folder: Path,
    *,
    levels: int = 1000,
    split: str = "test",
    latency: bool = False,
    overwrite: bool = False,
) -> SuiteRecord:
    """Play what has not been played yet, score all results, and return the folder's record.

    A policy that cannot drive a benchmark's robots, or observes what they do not have, skips that benchmark, and the
    record states the reason. Each policy perceives as in ``evaluate_policies``.

    Args:
        folder: Folder of rows and summary. Existing results are kept and not played again.
        levels: Number of levels of each benchmark, from level 0.
        latency: Also look for the latency that, with no other disturbance, costs 5 points of success.
        overwrite: Remove existing results first.

    Raises:
        IrsimGymError: If the folder holds rows with other levels, policies or scenarios.
    """
    check_split(split)
    screen = Console(stderr=True)
    record = _begin(folder, levels, split, overwrite)
    record.add(members, methods)
    with progress_bar(screen) as bar:
        for member in members:
            missing = [m for m in methods if len(record.done(member.name, m.name)) < len(m.sources)]
            if missing:
                _play_member(member, missing, record, folder, screen, bar)
    for member in members if latency else ():
        _play_latency(member, methods, record, folder)
    with reading(folder / SUMMARY, RECORD):
        score_suite(record, folder)
    record.write(folder)
    return record


def _begin(folder: Path, levels: int, split: str, overwrite: bool) -> SuiteRecord:
    """Return the record of the folder, or a new one."""
    if not (folder / SUMMARY).exists():
        if folder.exists() and any(folder.iterdir()):
            raise IrsimGymError(f"{folder} is not empty, and holds no run of the suite: choose another with --out")
        return SuiteRecord(split, levels)
    record = read_record(folder)
    if overwrite:
        remove(folder / ROWS)
        remove(folder / LATENCY)
        return SuiteRecord(split, levels)
    if (record.split, record.levels) != (split, levels):
        raise IrsimGymError(
            f"{folder} holds {record.levels:,} {record.split} levels of each benchmark, asked for: {levels:,} {split} "
            "levels; choose another folder with --out, or replace all with --overwrite"
        )
    return record


def _play_member(
    member: Member, methods: Sequence[ComparedMethod], record: SuiteRecord, folder: Path, screen: Console, bar: Progress
) -> None:
    """Play one benchmark with the given methods."""
    levels = member.levels_of(record.levels)
    episodes = _episodes(member, min(WORLDS, levels))
    conditions = team_conditions(episodes, record.split, levels)
    conditions |= played_levels(episodes.simulation, record.split, levels).conditions()
    record.members[member.name]["conditions"] = plain(conditions)
    optima, worlds = Optima(record.split), Perceived(episodes)
    for method in methods:
        done = record.done(member.name, method.name)
        for number in range(len(done), len(method.sources)):
            label = f"{member.name}: {method.name}" + (f" {number}" if len(method.sources) > 1 else "")
            line = bar.add_task(label, total=levels)
            file = f"{ROWS}/{member.name}/{as_name(method.name)}-{number}.csv"
            done.append(_play_policy(method.sources[number], worlds, levels, optima, folder / file, bar, line))
            record.write(folder)
            bar.remove_task(line)
            if not screen.is_terminal:
                said = done[-1].get("left_out") or f"{levels:,} levels in {done[-1]['seconds']:.1f} s"
                screen.print(f"{label}: {said}", markup=False, highlight=False, soft_wrap=True)


def _episodes(member: Member, n_worlds: int) -> Episodes:
    chosen: dict[str, Any] = {"n_worlds": n_worlds, "team": member.team}
    episodes = make_episodes(member.scenario, parameters=dict(member.parameters), **chosen)
    if not member.disturbed:
        return episodes
    scenario = disturbed(episodes.simulation.scenario, episodes.task.agents, *member.disturbances)
    return make_episodes(scenario, **chosen)


def _play_latency(member: Member, methods: Sequence[ComparedMethod], record: SuiteRecord, folder: Path) -> None:
    """Note for each policy which latency costs 5 points of success in a benchmark without other disturbances."""
    fit = {m.name: m.sources for m in methods if all("file" in entry for entry in record.done(member.name, m.name))}
    if not fit:
        return
    chosen: dict[str, Any] = {"factors": ["latency"], "split": record.split, "folder": folder / LATENCY / member.name}
    chosen |= {"parameters": member.parameters, "team": member.team, "levels": member.levels_of(record.levels)}
    curves = robustness(member.scenario, fit, **chosen)
    for method, names in names_of_policies(fit).items():
        for entry, name in zip(record.done(member.name, method), names, strict=True):
            if not math.isnan(lost := curves.lost_at("latency", name)):
                entry["latency_at_loss"] = {"value": lost, "played_to": curves.curve("latency", name)[-1].strength}


def _play_policy(
    source: str, worlds: Perceived, levels: int, optima: Optima, path: Path, bar: Progress, line: TaskID
) -> dict[str, object]:
    """Play one policy, write its rows, and return its entry in the record."""
    begun, policy = time.process_time(), load_policy(source)
    try:
        rows = evaluate_team(
            policy,
            worlds.of(policy),
            levels,
            optima.split,
            optima=optima,
            on_episodes=lambda count: bar.advance(line, count),
        )
    except (UnfitBehaviorError, UnfitPerceptionError, UnfitPolicyError) as problem:
        where = f"{configs_folder()}{os.sep}"  # a folder of this machine says nothing in a table
        return {"left_out": str(problem).replace(where, "")}
    write_rows(path, rows)
    entry = {"file": path.relative_to(path.parents[2]).as_posix(), "seconds": time.process_time() - begun}
    observes = worlds.observed_by(policy)
    return entry if observes is None else {**entry, "observes": observes}
