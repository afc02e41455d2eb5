"""CSV files with the rows of one policy on one benchmark: one row per agent and level."""

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow
from irsim_gym.evaluation.protocol import tables

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
    teams: dict[int, TeamRow] = {}
    for place, row in tables.read_rows(path, EpisodeRow, AgentRow, TeamRow):
        episode = tables.read_cells(place, EpisodeRow, row)
        agent, number = tables.read_cells(place, AgentRow, row, episode=episode), episode.level
        if levels is not None and number not in (*list(teams)[-1:], len(teams)):
            reason = f"level must be {len(teams)}, got {number}: a row before it is missing, or this one is there twice"
            raise UnreadableFileError(place, tables.ROW, reason)
        level = teams.get(number) or tables.read_cells(place, TeamRow, row, agents=())
        if agent.agent in [other.agent for other in level.agents]:
            raise UnreadableFileError(place, tables.ROW, f"'{agent.agent}' has two rows in level {number}")
        teams[number] = replace(level, agents=(*level.agents, agent))
    rows = list(teams.values())
    if levels is not None:
        _check_levels(path, rows, levels)
    return rows


def _check_levels(path: Path, rows: Sequence[TeamRow], levels: int) -> None:
    """Check that rows are those of all levels, and of all agents in each."""
    if len(rows) != levels:
        reason = f"its rows must be those of {levels:,} levels, got {len(rows):,}"
        raise UnreadableFileError(str(path), tables.ROWS, reason)
    teams = [{agent.agent for agent in row.agents} for row in rows]
    for number, team in enumerate(teams):
        if missing := sorted(set.union(*teams) - team):
            raise UnreadableFileError(str(path), tables.ROWS, f"level {number} has no row of {', '.join(missing)}")


def _cells(level: TeamRow, agent: AgentRow) -> dict[str, object]:
    fields = {name: getattr(agent.episode, name) for name in EPISODE}
    return {**fields, **{name: getattr(agent, name) for name in AGENT}, "limit": level.limit}
