"""Results of teams on the terminal and in files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from irsim_gym.evaluation.measures.metrics import Summary
from irsim_gym.evaluation.measures.team_metrics import AgentRow, TeamRow, TeamSummary
from irsim_gym.evaluation.protocol import tables
from irsim_gym.evaluation.protocol.figure_columns import percentiles, summary_table
from irsim_gym.evaluation.protocol.tables import EPISODE_COLUMNS

AGENT_COLUMNS = ("arrival_time", "straight_distance", "top_speed", "extra_time", "deadlocked")
LEVEL_COLUMNS = (
    *("policy", "level", "agents", "arrived", "success", "makespan", "flowtime", "collided", "deadlocked"),
    "throughput",
)


def write_agents(path: Path, results: Mapping[str, Sequence[TeamRow]]) -> None:
    """Write one CSV row per policy, level and agent.

    Args:
        results: Levels by policy.
    """
    rows = (
        {"policy": policy, **_agent_cells(agent)}
        for policy, levels in results.items()
        for level in levels
        for agent in level.agents
    )
    tables.write_csv(path, ("policy", "level", "agent", *EPISODE_COLUMNS[1:], *AGENT_COLUMNS), rows)


def write_levels(path: Path, results: Mapping[str, Sequence[TeamRow]]) -> None:
    """Write one CSV row per policy and level."""
    rows = ({"policy": policy, **_level_cells(level)} for policy, levels in results.items() for level in levels)
    tables.write_csv(path, LEVEL_COLUMNS, rows)


def write_rows(path: Path, results: Mapping[str, Sequence[Any]]) -> None:
    """Write the rows of policies: one per episode; of teams, one per level and agent."""
    is_team = any(isinstance(row, TeamRow) for rows in results.values() for row in rows[:1])
    (write_agents if is_team else tables.write_episodes)(path, results)


def figure_tables(summaries: Sequence[Any], title: str) -> list[Table]:
    """Lay out the figures of several policies; of teams, also the extra times that can be compared."""
    compared = None if isinstance(summaries[0], Summary) else compared_table(summaries)
    return [summary_table(summaries, title), *([] if compared is None else [compared])]


def compared_table(summaries: Sequence[TeamSummary]) -> Table | None:
    """Lay out the extra times on the levels that all compared policies solved; None if no policies are compared."""
    compared = [(summary.policy, summary.common_extra_time) for summary in summaries]
    times = [(policy, time) for policy, time in compared if time is not None]
    if not times:
        return None
    heads = ("policy", "levels", "extra time, 50/75/90 % [s]")
    rows = [(policy, f"{time.levels:,}", percentiles(time)) for policy, time in times]
    return tables.figure_table("levels that all of these solved", heads, rows, **tables.COMPACT)


def _agent_cells(agent: AgentRow) -> dict[str, object]:
    cells = {name: getattr(agent.episode, name) for name in EPISODE_COLUMNS}
    return {**cells, "agent": agent.agent, **{name: getattr(agent, name) for name in AGENT_COLUMNS}}


def _level_cells(level: TeamRow) -> dict[str, object]:
    collided = sum(agent.episode.outcome == "collision" for agent in level.agents)
    said: dict[str, Any] = {"level": level.level, "agents": len(level.agents), "arrived": level.arrived}
    said |= {"success": level.is_success, "makespan": level.makespan, "flowtime": level.flowtime}
    return {**said, "collided": collided, "deadlocked": level.deadlocked, "throughput": level.throughput}
