"""What an arena's page knows, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from irsim_gym.arenas.board import Board
from irsim_gym.arenas.standings import Standings
from irsim_gym.evaluation.metrics import HITS, OUTCOMES, Rate, Summary
from irsim_gym.evaluation.tables import plain
from irsim_gym.evaluation.team_metrics import TEAM_HITS, TeamSummary

SCHEMA, VERSION = "irsim_gym arena", 1

Column = tuple[str, str, Any]


def page_data(title: str, board: Board, alone: int, standings: Standings, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the page's data without its replays.

    Args:
        title: Heading.
        board: Results of the policies, and behind them those of arrangements of two.
        alone: Number of the policies.
        standings: What is compared.
        summary: What ``summary.json`` holds.

    Returns:
        ``policies`` (names), ``alone``, ``agents``; ``table``: columns with ``head``, ``unit``, ``about`` and a cell
        for each policy, a number or a share with its interval; ``pairs``, ``strata`` and ``meetings`` as in
        `Standings`; ``levels`` (their numbers), and for each policy the ``outcomes`` (a digit for each level),
        ``arrived``, ``steps`` and ``times`` [s]; ``facts``: what a published figure has to name.
    """
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "title": title,
        "policies": list(board.policies),
        "alone": alone,
        "agents": board.agents,
        "team": bool(summary["arena"]["team"]),
        "outcome_names": list(OUTCOMES),
        "table": [_column(column, standings.summaries) for column in _columns(standings.summaries)],
        "pairs": plain(standings.pairs),
        "strata": {"by": standings.strata_by, "rows": plain(standings.strata)},
        "meetings": plain(standings.meetings),
        "levels": board.levels.tolist(),
        "outcomes": ["".join(map(str, row)) for row in board.outcome.tolist()],
        "arrived": board.arrived.tolist(),
        "steps": board.steps.tolist(),
        "times": board.time.round(3).tolist(),
        "facts": plain({name: summary[name] for name in ("arena", "conditions", "machine")}),
    }


def _columns(summaries: Sequence[Summary] | Sequence[TeamSummary]) -> list[Column]:
    """Return head, meaning and reader of each column; outcomes that never came are left out."""
    first = summaries[0]
    columns = _team_columns(first) if isinstance(first, TeamSummary) else _single_columns()
    hits = TEAM_HITS if isinstance(first, TeamSummary) else HITS
    seen = [hit for hit in hits if any(each.collision_with[hit].count for each in summaries)]
    split: list[Column] = [
        (f"with {hit}", f"Collisions with: {hit}", lambda each, hit=hit: each.collision_with[hit]) for hit in seen
    ]
    at = next(i for i, column in enumerate(columns) if column[0] == "collision") + 1
    columns[at:at] = split if len(seen) > 1 else []
    never = ("left world", "gave up", "deadlocked")
    return [column for column in columns if column[0] not in never or any(column[2](each).count for each in summaries)]


def _single_columns() -> list[Column]:
    return [
        (
            "success",
            "Share of levels in which the robot arrived, with Wilson's 95 % interval",
            lambda each: each.success,
        ),
        ("collision", "Share that ended in a collision", lambda each: each.collision),
        ("timeout", "Share cut by the time limit", lambda each: each.timeout),
        ("left world", "Share that left the world's rectangle", lambda each: each.left_world),
        ("gave up", "Share that the task's ending `deadlocked` ended", lambda each: each.deadlock),
        ("SPL", "Mean of success weighted by path length", lambda each: each.spl),
        ("time [s]", "Mean duration of the successes", lambda each: each.time),
        ("path ratio", "Mean of path length / shortest path over the successes", lambda each: each.path_ratio),
        ("clearance [m]", "Mean of the smallest clearance", lambda each: each.min_clearance),
    ]


def _team_columns(first: TeamSummary) -> list[Column]:
    return [
        (
            "all arrive",
            "Share of levels in which all robots arrived (CSR), with Wilson's 95 % interval",
            lambda each: each.cooperative_success,
        ),
        (
            "arrive",
            "Share of robots that arrived (ISR); its interval counts levels",
            lambda each: each.individual_success,
        ),
        ("collision", "Share of robots that collided", lambda each: each.collision),
        ("timeout", "Share of robots cut by the time limit", lambda each: each.timeout),
        ("left world", "Share of robots that left the world's rectangle", lambda each: each.left_world),
        ("gave up", "Share of robots that the task's ending `deadlocked` ended", lambda each: each.deadlock),
        ("deadlocked", "Share of robots that stood still at the end", lambda each: each.deadlocked),
        ("SPL", "Mean over robots of success weighted by path length", lambda each: each.spl),
        (
            "makespan [s]",
            "Mean time of the last arrival, the limit if a robot never arrives",
            lambda each: each.makespan,
        ),
        (
            "flowtime [s]",
            "Mean of the sum of arrival times, the limit for each robot that never arrives",
            lambda each: each.flowtime,
        ),
        ("clearance [m]", "Mean of the smallest clearance", lambda each: each.min_clearance),
    ]


def _column(column: Column, summaries: Sequence[Any]) -> dict[str, Any]:
    head, about, read = column
    values = [read(each) for each in summaries]
    cells = [plain(value) if isinstance(value, Rate) else {"value": plain(float(value))} for value in values]
    return {"head": head, "about": about, "share": isinstance(values[0], Rate), "cells": cells}
