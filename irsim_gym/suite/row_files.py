"""CSV files with the rows of one policy on one benchmark: one row per agent and level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from irsim_gym.evaluation import tables
from irsim_gym.evaluation.metrics import EpisodeRow
from irsim_gym.evaluation.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.team_tables import read_levels

EPISODE = tuple(field.name for field in fields(EpisodeRow))
AGENT = tuple(field.name for field in fields(AgentRow) if field.name != "episode")
COLUMNS = (*EPISODE, *AGENT, "limit")


def write_rows(path: Path, levels: Sequence[TeamRow]) -> None:
    """Write the rows of levels."""
    tables.write_csv(path, COLUMNS, (_cells(level, agent) for level in levels for agent in level.agents))


def read_rows(path: Path, levels: int | None = None) -> list[TeamRow]:
    """Return the levels in a file of rows.

    Args:
        levels: Number of levels, whose rows must all be there; None not to check that.

    Raises:
        UnreadableFileError: If a column or a row is missing or a value is invalid; the message names the line.
    """
    rows = read_levels(tables.read_rows(path, EpisodeRow, AgentRow, TeamRow), in_order=levels is not None)
    if levels is not None:
        tables.check_levels(path, {"": rows}, levels)
    return rows


def _cells(level: TeamRow, agent: AgentRow) -> dict[str, object]:
    own = {name: getattr(agent.episode, name) for name in EPISODE}
    return {**own, **{name: getattr(agent, name) for name in AGENT}, "limit": level.limit}
