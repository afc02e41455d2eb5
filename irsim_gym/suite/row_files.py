"""The rows of one policy on one benchmark, as a CSV file: one per episode, so one per agent and level."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import groupby
from pathlib import Path
from typing import Any

from irsim_gym.errors import IrsimGymError
from irsim_gym.evaluation.metrics import EpisodeRow
from irsim_gym.evaluation.tables import write_csv
from irsim_gym.evaluation.team_metrics import AgentRow, TeamRow

EPISODE = {field.name: str(field.type) for field in fields(EpisodeRow)}
AGENT = {field.name: str(field.type) for field in fields(AgentRow) if field.name != "episode"}
COLUMNS = {**EPISODE, **AGENT, "limit": "float"}
"""Names of the columns and types of their values."""


def write_rows(path: Path, levels: Sequence[TeamRow]) -> None:
    """Write the rows of levels."""
    write_csv(path, tuple(COLUMNS), (_cells(level, agent) for level in levels for agent in level.agents))


def read_rows(path: Path) -> list[TeamRow]:
    """Return the levels whose rows a file holds.

    Raises:
        IrsimGymError: A column is missing, or a value is none of its column; the message names the line.
    """
    with path.open(newline="", encoding="utf-8") as file:
        cells = list(_values(path, csv.DictReader(file)))
    return [_level(list(rows)) for _, rows in groupby(cells, key=lambda row: row["level"])]


def _cells(level: TeamRow, agent: AgentRow) -> dict[str, Any]:
    own = {name: getattr(agent.episode, name) for name in EPISODE}
    return {**own, **{name: getattr(agent, name) for name in AGENT}, "limit": level.limit}


def _values(path: Path, reader: csv.DictReader[str]) -> Iterator[dict[str, Any]]:
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise IrsimGymError(f"{path}:1: no column {', '.join(missing)}: it is not a file of rows of this version")
    for row in reader:
        try:
            yield {name: _value(row[name], kind) for name, kind in COLUMNS.items()}
        except (TypeError, ValueError) as error:
            raise IrsimGymError(f"{path}:{reader.line_num}: {error}") from None


def _value(text: str, kind: str) -> Any:
    if kind == "str":
        return text
    if kind == "bool":
        return {"True": True, "False": False}[text]
    if kind == "int":
        return int(text)
    return float(text) if text else math.nan


def _level(rows: Sequence[Mapping[str, Any]]) -> TeamRow:
    agents = tuple(
        AgentRow(episode=EpisodeRow(**{name: row[name] for name in EPISODE}), **{name: row[name] for name in AGENT})
        for row in rows
    )
    return TeamRow(rows[0]["level"], rows[0]["limit"], agents)
