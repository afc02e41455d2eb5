"""Computes the figures of tables from rows."""

import math
from collections.abc import Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from statistics import fmean, median
from typing import Any

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import IrsimGymError
from irsim_gym.evaluation.levels.certificate import find_certificate
from irsim_gym.evaluation.levels.played import QUARTER_NAMES, PlayedLevels
from irsim_gym.evaluation.measures import statistics
from irsim_gym.evaluation.measures.metrics import OUTCOMES, EpisodeRow, mean
from irsim_gym.evaluation.measures.statistics import Estimate, probability_of_improvement, stratified_mean
from irsim_gym.evaluation.measures.team_metrics import COMPARED, TEAM_HITS, TeamRow, TeamSummary, summarize_team
from irsim_gym.evaluation.measures.worst_levels import worst_shares
from irsim_gym.evaluation.protocol.tables import plain
from irsim_gym.evaluation.suite.row_files import read_rows
from irsim_gym.evaluation.suite.suite_record import SuiteRecord
from irsim_gym.scenario import load_scenario

OF_SUMMARIES = (
    *("spl", "sct", "makespan", "acceleration", "jerk", "intrusion_025", "intrusion_045"),
    *("time_to_collision", "throughput"),
)
"""Figures of a score that are means of those of summaries with the same name."""
Repetitions = Sequence[Sequence[TeamRow]]
"""The levels that the policies of one method played, one list per policy."""
Figures = dict[str, Any]
"""The figures of one method on one benchmark, see ``score_method``."""


def score_suite(record: SuiteRecord, folder: Path) -> None:
    """Read all rows, and write the figures of all methods into the record."""
    played: dict[str, dict[str, Repetitions]] = {}
    for member, methods in record.runs.items():
        files = {method: [entry["file"] for entry in entries if "file" in entry] for method, entries in methods.items()}
        played[member] = {
            method: [read_rows(folder / file, record.played(member)) for file in paths]
            for method, paths in files.items()
            if paths
        }
    scores: dict[str, dict[str, Figures]] = {}
    success: dict[str, dict[str, list[float]]] = {}
    for member, repetitions in played.items():
        levels = _certified_levels(record.members[member])
        record.members[member]["conditions"] |= levels.conditions()
        scores[member] = score_member(repetitions, levels.quarters)
        for method, figures in scores[member].items():
            figures["latency_at_loss"] = _median_latency(record.runs[member][method])
            shares = [fmean(row.is_success for row in rows) for rows in repetitions[method]]
            success.setdefault(member, {})[method] = shares
    record.figures = plain(scores)
    record.overall = plain(overall(success, list(record.methods)))


def _certified_levels(member: Mapping[str, Any]) -> PlayedLevels:
    """Return the levels of a benchmark with their certificate, which may be newer than the rows.

    Args:
        member: The benchmark's entry in the record of a run.
    """
    of = member["conditions"]
    count, digest = of["levels"], of["level_hash"]
    try:
        scenario = load_scenario(member["scenario"], member["parameters"], warn=False)
    except IrsimGymError:  # rows of an earlier version whose scenario had other parameters
        return PlayedLevels(count, digest, of["level_file"] or "", None)
    certificate = find_certificate(scenario, of["agents"], of["split"], digest, count)
    return PlayedLevels(count, digest, of["level_file"] or "", certificate)


def score_member(methods: Mapping[str, Repetitions], quarters: Ints | None = None) -> dict[str, Figures]:
    """Return the figures of several methods on the same levels.

    Args:
        methods: Levels that the policies of each method played.
        quarters: Quarter of difficulty of each level, from 0; None if it is not known.
    """
    solved = {name: _solved(repetitions) for name, repetitions in methods.items()}
    n_levels = {name: len(repetitions[0]) for name, repetitions in methods.items()}
    compared = [name for name, levels in solved.items() if len(levels) >= max(COMPARED * n_levels[name], 1)]
    common = set.intersection(*(solved[name] for name in compared)) if len(compared) > 1 else set()
    return {name: score_method(runs, common if name in compared else set(), quarters) for name, runs in methods.items()}


def score_method(repetitions: Repetitions, common: set[int], quarters: Ints | None = None) -> Figures:
    """Return the figures of one method.

    Args:
        repetitions: Levels that its policies played.
        common: Levels that all compared methods solved.
        quarters: Quarter of difficulty of each level, from 0; None if it is not known.

    Returns:
        Means over its policies; NaN if there are no values.

        - ``repetitions``: Number of its policies.
        - ``success``: Share of levels in which all robots arrive. Its interval is Wilson's for one policy, and a
          bootstrap interval over policies for several.
        - ``individual``: Share of robots that arrive.
        - ``outcomes``: Share of episodes by outcome.
        - ``hits``: Share of episodes that ended in a collision, by what was hit.
        - ``deadlocked``: Share of robots whose episode ended while they stood still.
        - ``spl``, ``sct``: Success weighted by path length, and by completion time.
        - ``worst``: Success of each policy on its own worst 5 % and 1 % of levels.
        - ``worst_shared``: The same on levels that are chosen by half of the policies and scored by the other half.
        - ``quarters``: Success by quarter of difficulty; empty if the levels have no certificate.
        - ``time``, ``path``: Mean time [s] and path length [m] of successful episodes.
        - ``common_levels``: Number of levels that all compared methods solved.
        - ``common_time``, ``common_path``: Mean time [s] and path length [m] on these levels.
        - ``makespan``: Mean time until the last robot arrives [s]; the time limit if one never arrives.
        - ``clearance``: Mean of the smallest ones [m]; ``acceleration``, ``jerk``: mean sizes [m/s2], [m/s3].
        - ``intrusion_025``, ``intrusion_045``: Share of steps nearer than 0.25 m and 0.45 m to a person; NaN if there
          are no people.
        - ``time_to_collision``: Mean of the minimum times to collision with a person [s], over episodes that met one.
        - ``throughput``: Mean over levels of the goals that all robots reach per minute; NaN if each has one goal.
    """
    summaries = [summarize_team("", rows) for rows in repetitions]
    success = np.array([[row.is_success for row in rows] for rows in repetitions], np.float64)
    worst = [worst_shares([levels]) for levels in success]
    episodes = [agent.episode for rows in repetitions for row in rows for agent in row.agents]
    there = [episode for episode in episodes if episode.level in common]
    known = enumerate(QUARTER_NAMES if quarters is not None else ())

    def over(name: str) -> float:
        return mean([attrgetter(name)(summary) for summary in summaries])

    return {
        "repetitions": len(summaries),
        "success": _success(summaries),
        "individual": over("individual_success.value"),
        "outcomes": {name: fmean(episode.outcome == name for episode in episodes) for name in OUTCOMES},
        "hits": {hit: mean([summary.collision_with[hit].value for summary in summaries]) for hit in TEAM_HITS},
        "deadlocked": over("deadlocked.value"),
        "worst": {share: mean([shares[share] for shares in worst]) for share in worst[0]},
        "worst_shared": worst_shares(success) if len(success) > 1 else {},
        "quarters": {name: float(success[:, quarters == k].mean()) for k, name in known},
        "time": _of_successes(episodes, "time"),
        "path": over("path_length"),
        "common_levels": len(common),
        "common_time": _of_successes(there, "time"),
        "common_path": _of_successes(there, "path_length"),
        "clearance": over("min_clearance"),
        **{name: over(name) for name in OF_SUMMARIES},
    }


def overall(success: Mapping[str, Mapping[str, Sequence[float]]], methods: Sequence[str]) -> dict[str, object]:
    """Return figures over the benchmarks that all methods played.

    Args:
        success: By benchmark and method, the success of each policy.

    Returns:
        ``benchmarks``: their names. ``success``: the interquartile mean over benchmarks and policies of each method,
        with its stratified bootstrap interval. ``improvement``: by two methods, the probability that a policy of the
        first beats one of the second.
    """
    common = [member for member, rates in success.items() if all(method in rates for method in methods)]
    if not common or not methods:
        return {"benchmarks": [], "success": {}, "improvement": {}}
    scores = {method: [success[member][method] for member in common] for method in methods}
    better = {
        first: {
            second: probability_of_improvement(scores[first], scores[second]) for second in methods if second != first
        }
        for first in methods
    }
    means = {method: statistics.interquartile_mean(scores[method]) for method in methods}
    return {"benchmarks": common, "success": means, "improvement": better}


def _median_latency(policies: Sequence[Mapping[str, Any]]) -> dict[str, float] | None:
    """Return the median of the latencies that cost 5 points, infinite beyond the greatest one played; None if none is.

    Args:
        policies: Entries of the policies in the record, which hold None where all latencies cost less.
    """
    lost = [policy["latency_at_loss"] for policy in policies if "latency_at_loss" in policy]
    return {**lost[0], "value": median(row["value"] or math.inf for row in lost)} if lost else None


def _success(summaries: Sequence[TeamSummary]) -> Estimate:
    if len(summaries) == 1:
        estimate = summaries[0].cooperative_success
        return Estimate(estimate.value, estimate.low, estimate.high)
    return stratified_mean([[summary.cooperative_success.value for summary in summaries]])


def _solved(repetitions: Repetitions) -> set[int]:
    """Return the levels that every policy of a method solved."""
    return set.intersection(*({row.level for row in rows if row.is_success} for rows in repetitions))


def _of_successes(episodes: Sequence[EpisodeRow], name: str) -> float:
    return mean([getattr(episode, name) for episode in episodes if episode.outcome == "success"])
