"""Results of teams on the terminal and in files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from irsim_gym.evaluation.measures.metrics import Summary
from irsim_gym.evaluation.measures.team_metrics import TEAM_HITS, AgentRow, ExtraTime, TeamRow, TeamSummary
from irsim_gym.evaluation.protocol import tables
from irsim_gym.evaluation.protocol.tables import EPISODE_COLUMNS, number, percent

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
    if isinstance(summaries[0], Summary):
        return [tables.summary_table(summaries, title)]
    compared = compared_table(summaries)
    return [team_table(summaries, title), *([] if compared is None else [compared])]


def team_table(summaries: Sequence[TeamSummary], title: str) -> Table:
    """Lay out the figures of several policies, one row each."""
    columns: list[tables.Column] = [
        ("CSR\n[%]", lambda row: percent(row.cooperative_success)),
        ("95 %\ninterval\n[%]", lambda row: tables.interval(row.cooperative_success)),
        ("ISR\n[%]", lambda row: percent(row.individual_success)),
        ("95 %\ninterval\n[%]", lambda row: tables.interval(row.individual_success)),
        ("collided\n[%]", lambda row: percent(row.collision)),
        *tables.hit_columns(summaries, TEAM_HITS),
        ("timeout\n[%]", lambda row: percent(row.timeout)),
        ("left\n[%]", lambda row: percent(row.left_world)),
    ]
    if any(summary.deadlock.count for summary in summaries):
        columns.append(("given\nup\n[%]", lambda row: percent(row.deadlock)))
    if any(summary.misplaced.count for summary in summaries):
        columns.append(("mis-\nplaced\n[%]", lambda row: percent(row.misplaced)))
    columns += [
        ("dead-\nlocked\n[%]", lambda row: percent(row.deadlocked)),
        ("SPL", lambda row: number(row.spl, 3)),
        ("make-\nspan\n[s]", lambda row: number(row.makespan, 1)),
        ("flow-\ntime\n[s]", lambda row: number(row.flowtime, 1)),
        ("extra time\n50/75/90 %\n[s]", lambda row: _percentiles(row.extra_time)),
        ("clear.\n[m]", lambda row: number(row.min_clearance, 3)),
    ]
    return tables.columns_table(title, [*columns, *tables.goal_columns(summaries)], summaries)


def compared_table(summaries: Sequence[TeamSummary]) -> Table | None:
    """Lay out the extra times on the levels that all compared policies solved; None if no policies are compared."""
    compared = [(summary.policy, summary.common_extra_time) for summary in summaries]
    times = [(policy, time) for policy, time in compared if time is not None]
    if not times:
        return None
    heads = ("policy", "levels", "extra time, 50/75/90 % [s]")
    rows = [(policy, f"{time.levels:,}", _percentiles(time)) for policy, time in times]
    return tables.figure_table("levels that all of these solved", heads, rows, **tables.COMPACT)


def _agent_cells(agent: AgentRow) -> dict[str, object]:
    own = {name: getattr(agent.episode, name) for name in EPISODE_COLUMNS}
    return {**own, "agent": agent.agent, **{name: getattr(agent, name) for name in AGENT_COLUMNS}}


def _level_cells(level: TeamRow) -> dict[str, object]:
    return {
        "level": level.level,
        "agents": len(level.agents),
        "arrived": level.arrived,
        "success": level.is_success,
        "makespan": level.makespan,
        "flowtime": level.flowtime,
        "collided": sum(agent.episode.outcome == "collision" for agent in level.agents),
        "deadlocked": level.deadlocked,
        "throughput": level.throughput,
    }


def _percentiles(time: ExtraTime) -> str:
    return "/".join(number(value, 1) for value in (time.p50, time.p75, time.p90)) if time.arrivals else "-"
