"""The data of an arena's page."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.arena.standings import Standings
from irsim_gym.evaluation.measures.metrics import HITS, OUTCOMES, Rate
from irsim_gym.evaluation.measures.team_metrics import TEAM_HITS, TeamSummary
from irsim_gym.evaluation.protocol.tables import plain

SCHEMA, VERSION = "irsim_gym arena", 1


class FigureColumn(NamedTuple):
    """A column of the table of figures.

    Attributes:
        head: Its heading.
        field: Name in ``Summary`` or ``TeamSummary``.
        about: Explanation of the column.
        digits: Number of decimals; 0 for a share with its interval.
        hit: Key of the share in ``collision_with``; empty for other fields.
    """

    head: str
    field: str
    about: str
    digits: int = 0
    hit: str = ""


ALWAYS = ("success", "cooperative_success", "individual_success", "collision", "timeout")
"""Shares that are shown even if all of them are 0."""

SINGLE_COLUMNS = (
    FigureColumn("success", "success", "Share of levels in which the robot arrived, with Wilson's 95 % interval"),
    FigureColumn("collision", "collision", "Share that ended in a collision"),
    FigureColumn("timeout", "timeout", "Share cut by the time limit"),
    FigureColumn("left world", "left_world", "Share that left the world's rectangle"),
    FigureColumn("gave up", "deadlock", "Share that the task's ending `deadlocked` ended"),
    FigureColumn("SPL", "spl", "Mean of success weighted by path length", 3),
    FigureColumn("SCT", "sct", "Mean of success weighted by completion time: least possible time / time", 3),
    FigureColumn("time [s]", "time", "Mean duration of the successes", 2),
    FigureColumn("path ratio", "path_ratio", "Mean of path length / shortest path over the successes", 3),
    FigureColumn("clearance [m]", "min_clearance", "Mean of the smallest clearance", 3),
    FigureColumn("jerk [m/s\u00b3]", "jerk", "Mean size of the second derivative of the velocity", 1),
)
TEAM_COLUMNS = (
    FigureColumn(
        "all arrive", "cooperative_success", "Share of levels in which all robots arrived, with Wilson's interval"
    ),
    FigureColumn("arrive", "individual_success", "Share of robots that arrived; its interval counts levels"),
    FigureColumn("collision", "collision", "Share of robots that collided"),
    FigureColumn("timeout", "timeout", "Share of robots cut by the time limit"),
    FigureColumn("left world", "left_world", "Share of robots that left the world's rectangle"),
    FigureColumn("gave up", "deadlock", "Share of robots that the task's ending `deadlocked` ended"),
    FigureColumn("deadlocked", "deadlocked", "Share of robots that stood still at the end"),
    FigureColumn("SPL", "spl", "Mean over robots of success weighted by path length", 3),
    FigureColumn("SCT", "sct", "Mean over robots of success weighted by completion time", 3),
    FigureColumn("makespan [s]", "makespan", "Mean time of the last arrival, the limit if a robot never arrives", 1),
    FigureColumn(
        "flowtime [s]", "flowtime", "Mean of the sum of arrival times, the limit where a robot never arrives", 1
    ),
    FigureColumn("clearance [m]", "min_clearance", "Mean of the smallest clearance", 3),
    FigureColumn("jerk [m/s\u00b3]", "jerk", "Mean size of the second derivative of the velocity", 1),
)


def page_data(title: str, board: Board, standings: Standings, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the page's data without its replays.

    Args:
        board: Results of the policies.
        summary: The content of ``summary.json``.

    Returns:
        ``policies`` (names), ``agents``; ``table``: columns with ``head``, ``about``, ``digits`` and a cell
        for each policy, a number or a share with its interval; ``pairs`` and ``strata`` as in
        `Standings`; ``levels`` (their numbers), and for each policy the ``outcomes`` (a digit for each level),
        ``arrived``, ``steps`` and ``times`` [s]; ``facts``: the conditions to name with published figures.
    """
    return {
        "schema": SCHEMA,
        "version": VERSION,
        "title": title,
        "policies": list(board.policies),
        "agents": board.agents,
        "team": bool(summary["arena"]["team"]),
        "outcome_names": list(OUTCOMES),
        "table": [_column(column, standings.summaries) for column in _columns(standings.summaries)],
        "pairs": plain(standings.pairs),
        "strata": {"by": standings.strata_by, "rows": plain(standings.strata)},
        "levels": board.levels.tolist(),
        "outcomes": ["".join(map(str, row)) for row in board.outcome.tolist()],
        "arrived": board.arrived.tolist(),
        "steps": board.steps.tolist(),
        "times": board.time.round(3).tolist(),
        "facts": plain({name: summary[name] for name in ("arena", "conditions", "machine")}),
    }


def _columns(summaries: Sequence[Any]) -> list[FigureColumn]:
    """Return the columns of the table of figures, without outcomes that never occurred."""
    is_team = isinstance(summaries[0], TeamSummary)
    seen = [
        hit for hit in (TEAM_HITS if is_team else HITS) if any(each.collision_with[hit].count for each in summaries)
    ]
    split = [FigureColumn(f"with {hit}", "collision_with", f"Share that collided with: {hit}", hit=hit) for hit in seen]
    shown: list[FigureColumn] = []
    for column in TEAM_COLUMNS if is_team else SINGLE_COLUMNS:
        if column.field in ALWAYS or column.digits or any(getattr(each, column.field).count for each in summaries):
            shown.append(column)
        if column.field == "collision" and len(split) > 1:
            shown += split
    return shown


def _column(column: FigureColumn, summaries: Sequence[object]) -> dict[str, Any]:
    values = [getattr(each, column.field) for each in summaries]
    if column.hit:
        values = [shares[column.hit] for shares in values]
    cells = [plain(value) if isinstance(value, Rate) else {"value": plain(float(value))} for value in values]
    return {"head": column.head, "about": column.about, "digits": column.digits, "cells": cells}
