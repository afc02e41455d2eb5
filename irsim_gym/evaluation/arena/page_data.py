"""The data of an arena's page."""

from collections.abc import Mapping, Sequence
from typing import Any

from irsim_gym.evaluation.arena.board import Board
from irsim_gym.evaluation.arena.standings import Standings
from irsim_gym.evaluation.measures.metrics import OUTCOMES, Rate
from irsim_gym.evaluation.protocol.figure_columns import FigureColumn, figure_columns
from irsim_gym.evaluation.protocol.tables import plain

SCHEMA, VERSION = "irsim_gym arena", 1


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
        "table": [_column(column, standings.summaries) for column in figure_columns("page", standings.summaries)],
        "pairs": plain(standings.pairs),
        "strata": {"by": standings.strata_by, "rows": plain(standings.strata)},
        "levels": board.levels.tolist(),
        "outcomes": ["".join(map(str, row)) for row in board.outcome.tolist()],
        "arrived": board.arrived.tolist(),
        "steps": board.steps.tolist(),
        "times": board.time.round(3).tolist(),
        "facts": plain({name: summary[name] for name in ("arena", "conditions", "machine")}),
    }


def _column(column: FigureColumn, summaries: Sequence[object]) -> dict[str, Any]:
    values = [column.value(each) for each in summaries]
    cells = [plain(value) if isinstance(value, Rate) else {"value": plain(float(value))} for value in values]
    return {"head": column.head, "about": column.about, "digits": column.digits, "cells": cells}
