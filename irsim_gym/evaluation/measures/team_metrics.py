"""Metrics of teams: a row per agent and level, a row per level, and summaries of many levels.

The terms are those of Stern et al. 2019 (Multi-agent pathfinding, arXiv:1906.08291) and POGEMA (Skrynnik et al. 2024,
arXiv:2407.14931): individual and cooperative success, makespan, flowtime ("sum of costs"). Extra time to goal is that
of Everett, Chen, How 2018 (arXiv:1805.01956).
"""

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from irsim_gym.evaluation.measures import metrics
from irsim_gym.evaluation.measures.metrics import OUTCOMES, EpisodeRow, Rate, SharedFigures, mean, rate, wilson

TEAM_HITS = ("robot", "obstacle", "moving obstacle", "map")
PERCENTILES = (50, 75, 90)
COMPARED = 0.5
"""Least share of levels that a policy must solve to be compared. Extra times are compared on the levels that all
compared policies solved, of which hardly any would be left otherwise."""


@dataclass(frozen=True)
class AgentRow:
    """The result of one agent in one level.

    Attributes:
        agent: Name of the agent.
        episode: Its own episode; the time [s] ends when it arrives, collides or gives up.
        straight_distance: Length of the straight lines from its start through its goals [m].
        top_speed: Its maximum linear speed [m/s].
        deadlocked: Whether its episode ended by the time limit or as a deadlock while it stood still away from its
            goal.
    """

    agent: str
    episode: EpisodeRow
    straight_distance: float
    top_speed: float
    deadlocked: bool

    @property
    def arrival_time(self) -> float:
        """Time of arrival [s]; NaN if it never arrived."""
        return self.episode.time if self.episode.outcome == "success" else math.nan

    @property
    def extra_time(self) -> float:
        """Arrival time minus the time of the straight path at maximum speed [s]; NaN if it never arrived.

        It can be slightly below 0, because an agent arrives within the goal's tolerance.
        """
        return self.arrival_time - self.straight_distance / self.top_speed


@dataclass(frozen=True)
class TeamRow:
    """One level, played by a team.

    Attributes:
        level: Index of the level in its split.
        limit: The time limit [s].
        agents: The result of each agent, in the order of the task.
    """

    level: int
    limit: float
    agents: tuple[AgentRow, ...]

    @property
    def arrived(self) -> int:
        """Number of agents that arrived."""
        return sum(row.episode.outcome == "success" for row in self.agents)

    @property
    def is_success(self) -> bool:
        """Whether all agents arrived."""
        return self.arrived == len(self.agents)

    @property
    def makespan(self) -> float:
        """Time at which the last agent arrived [s]; the time limit if any never arrived."""
        return max(self._costs())

    @property
    def flowtime(self) -> float:
        """Sum of the arrival times [s], with the time limit for each agent that never arrived."""
        return math.fsum(self._costs())

    @property
    def throughput(self) -> float:
        """Rate of reached goals, summed over the agents [1/min]; NaN if none has several goals."""
        rates = [row.episode.goals_per_minute for row in self.agents]
        return math.nan if all(map(math.isnan, rates)) else math.fsum(rate for rate in rates if not math.isnan(rate))

    @property
    def deadlocked(self) -> int:
        """Number of agents whose episode ended while they stood still."""
        return sum(row.deadlocked for row in self.agents)

    def _costs(self) -> list[float]:
        return [row.arrival_time if row.episode.outcome == "success" else self.limit for row in self.agents]


@dataclass(frozen=True)
class ExtraTime:
    """Extra times to the goal of agents that arrived [s].

    Attributes:
        levels: Number of levels considered.
        arrivals: Number of arrivals in them.
        p50: Median; NaN without arrivals, like the other percentiles.
        p75: 75th percentile.
        p90: 90th percentile.
    """

    levels: int
    arrivals: int
    p50: float
    p75: float
    p90: float


@dataclass(frozen=True, kw_only=True)
class TeamSummary(SharedFigures):
    """The figures of one policy that drives teams through one set of levels.

    Shares of agents have a different interval, see ``rate_of_agents``.

    Attributes:
        levels: Number of levels.
        agents: Number of agents in each.
        cooperative_success: CSR, the share of levels in which every agent arrived, with Wilson's interval.
        individual_success: ISR, the share of agents that arrived.
        deadlocked: Share of agents that stood still when the time limit or the ending ``deadlocked`` ended their
            episode.
        makespan: Mean over levels of the time of the last arrival, the limit if any agent never arrives [s].
        flowtime: Mean over levels of the sum of arrival times, the limit for each that never arrives [s].
        extra_time: Extra times over all levels.
        common_extra_time: Extra times over the levels that all compared policies solved; None if this policy is not
            compared.
    """

    levels: int
    agents: int
    cooperative_success: Rate
    individual_success: Rate
    deadlocked: Rate
    makespan: float
    flowtime: float
    extra_time: ExtraTime
    common_extra_time: ExtraTime | None


def rate_of_agents(counts: Sequence[int], team: int) -> Rate:
    """Return a share of agents with an interval that accounts for shared levels.

    The agents of one level are not independent, so the interval is not Wilson's for all agents. It is Wilson's for the
    effective sample size of a cluster sample (Kish 1965, Survey Sampling): the number of independent agents whose mean
    would vary as the mean over levels does. If no or all agents are counted, the variance is 0, and the sample size is
    the number of levels, as if the agents of a level always fared alike.

    Args:
        counts: Number of counted agents in each level.
        team: Number of agents in each level.
    """
    levels, total = len(counts), sum(counts)
    if total in (0, team * levels):
        return Rate(total, float(total > 0), *wilson(total / team, levels))
    shares = np.array(counts) / team
    value = total / (team * levels)
    spread = float(shares.var()) / levels
    alone = float(team * levels) if levels > 1 else 1.0
    size = min(value * (1.0 - value) / spread, alone) if spread > 0.0 else alone
    return Rate(total, value, *wilson(value * size, size))


def summarize_teams(results: Mapping[str, Sequence[TeamRow]]) -> list[TeamSummary]:
    """Summarise several policies that all played the same levels."""
    solved = {policy: {row.level for row in rows if row.is_success} for policy, rows in results.items()}
    compared = [policy for policy, levels in solved.items() if len(levels) >= max(COMPARED * len(results[policy]), 1)]
    common = set.intersection(*(solved[policy] for policy in compared)) if len(compared) > 1 else None
    return [summarize_team(policy, rows, common if policy in compared else None) for policy, rows in results.items()]


def summarize_team(policy: str, rows: Sequence[TeamRow], common: Container[int] | None = None) -> TeamSummary:
    """Summarise the levels of one policy.

    Args:
        rows: The levels that it played, all with the same number of agents.
        common: Levels that all compared policies solved, including this one; None if it is not compared.
    """
    agents = [agent for row in rows for agent in row.agents]
    team = len(rows[0].agents) if rows else 1
    assert all(len(row.agents) == team for row in rows), "every level must have the same number of agents"
    shares: dict[str, Any] = _rates(rows, OUTCOMES, lambda agent: agent.episode.outcome)
    hits = _rates(rows, TEAM_HITS, lambda agent: agent.episode.hit)
    assert sum(share.count for share in shares.values()) == len(agents), "the outcomes must be those of all agents"
    assert sum(hit.count for hit in hits.values()) == shares["collision"].count, "every collision must have a kind"
    cooperative = rate(sum(row.is_success for row in rows), len(rows))
    if all(metrics.are_copies([row.agents[a].episode for row in rows]) for a in range(team)):
        cooperative, shares = cooperative.exact(), {name: share.exact() for name, share in shares.items()}
    return TeamSummary(
        policy=policy,
        levels=len(rows),
        agents=team,
        cooperative_success=cooperative,
        individual_success=shares.pop("success"),
        collision_with=hits,
        deadlocked=rate_of_agents([row.deadlocked for row in rows], team),
        makespan=mean([row.makespan for row in rows]),
        flowtime=mean([row.flowtime for row in rows]),
        extra_time=_extra_time(rows),
        common_extra_time=None if common is None else _extra_time([row for row in rows if row.level in common]),
        throughput=mean([row.throughput for row in rows]),
        **shares,
        **metrics.means([agent.episode for agent in agents]),
    )


def _rates(rows: Sequence[TeamRow], names: Sequence[str], read: Callable[[AgentRow], str]) -> dict[str, Rate]:
    """Return the share of agents for each of ``names``, the values of ``read``."""
    team = len(rows[0].agents) if rows else 1
    counts = {name: [sum(read(agent) == name for agent in row.agents) for row in rows] for name in names}
    return {name: rate_of_agents(count, team) for name, count in counts.items()}


def _extra_time(rows: Sequence[TeamRow]) -> ExtraTime:
    times = [agent.extra_time for row in rows for agent in row.agents if agent.episode.outcome == "success"]
    points = np.percentile(times, PERCENTILES).tolist() if times else [math.nan] * len(PERCENTILES)
    return ExtraTime(len(rows), len(times), *points)
