"""Figures of teams, worked out by hand from rows made by hand."""

import math

import pytest

from irsim_gym.evaluation.measures.metrics import EpisodeRow, wilson
from irsim_gym.evaluation.measures.team_metrics import (
    AgentRow,
    TeamRow,
    rate_of_agents,
    summarize_team,
    summarize_teams,
)

LIMIT = 20.0


def agent(
    outcome: str, time: float, *, hit: str = "", deadlocked: bool = False, level: int = 0, path: float = 5.0
) -> AgentRow:
    """An agent whose straight way of 4 m takes 4 s at 1 m/s."""
    episode = EpisodeRow(level, outcome, hit, round(10 * time), time, path, 4.0, 0.5)
    return AgentRow("robot", episode, 4.0, 1.0, deadlocked)


def level(index: int, *agents: AgentRow) -> TeamRow:
    return TeamRow(index, LIMIT, agents)


ALL_ARRIVE = level(0, agent("success", 5.0), agent("success", 9.0, path=8.0))
ONE_WAITS = level(1, agent("success", 6.0), agent("timeout", LIMIT, deadlocked=True))
BOTH_CRASH = level(2, agent("collision", 2.0, hit="robot"), agent("collision", 3.0, hit="map"))
STRAYED = level(3, agent("left_world", 7.0), agent("timeout", LIMIT))
GAVE_UP = level(4, agent("deadlock", 8.0, deadlocked=True), agent("success", 4.5))
ROWS = [ALL_ARRIVE, ONE_WAITS, BOTH_CRASH, STRAYED, GAVE_UP]


def test_an_agent_that_arrives_and_one_that_does_not() -> None:
    first, late = ONE_WAITS.agents
    assert (first.arrival_time, first.extra_time) == (6.0, 2.0)
    assert math.isnan(late.arrival_time)
    assert math.isnan(late.extra_time)


def test_levels() -> None:
    assert [row.arrived for row in ROWS] == [2, 1, 0, 0, 1]
    assert [row.is_success for row in ROWS] == [True, False, False, False, False]
    assert [row.makespan for row in ROWS] == [9.0, LIMIT, LIMIT, LIMIT, LIMIT]
    assert [row.flowtime for row in ROWS] == [14.0, 26.0, 40.0, 40.0, 24.5]
    assert [row.deadlocked for row in ROWS] == [0, 1, 0, 0, 1]


def test_summary_of_a_handful() -> None:
    found = summarize_team("some", ROWS)
    assert (found.levels, found.agents) == (5, 2)
    assert (found.cooperative_success.count, found.cooperative_success.value) == (1, 0.2)
    assert (found.cooperative_success.low, found.cooperative_success.high) == wilson(1, 5)
    assert (found.individual_success.count, found.individual_success.value) == (4, 0.4)
    assert found.collision.value == pytest.approx(0.2)
    hits = {name: share.count for name, share in found.collision_with.items()}
    assert hits == {"robot": 1, "obstacle": 0, "moving obstacle": 0, "map": 1}
    assert (found.timeout.count, found.left_world.count, found.deadlock.count) == (2, 1, 1)
    assert found.deadlocked.value == pytest.approx(0.2)
    assert found.makespan == pytest.approx((9.0 + 4 * LIMIT) / 5)
    assert found.flowtime == pytest.approx((14.0 + 26.0 + 40.0 + 40.0 + 24.5) / 5)
    # Extra times 1, 5, 2 and 0.5 s, sorted 0.5, 1, 2, 5; the place of percentile p is 3 p / 100, between neighbours.
    extra = found.extra_time
    assert (extra.levels, extra.arrivals) == (5, 4)
    assert (extra.p50, extra.p75) == (pytest.approx(1.5), pytest.approx(2.75))
    assert extra.p90 == pytest.approx(2.0 + 0.7 * 3.0)
    # Success by path length: 4/5 three times and 4/8, over ten agents.
    assert found.spl == pytest.approx((3 * 0.8 + 0.5) / 10)
    assert found.path_length == pytest.approx((3 * 5.0 + 8.0) / 4)
    assert found.common_extra_time is None


def test_outcomes_of_agents_add_up() -> None:
    with pytest.raises(AssertionError, match="those of all agents"):
        summarize_team("some", [level(0, agent("running", 1.0), agent("success", 1.0))])
    with pytest.raises(AssertionError, match="must have a kind"):
        summarize_team("some", [level(0, agent("collision", 1.0, hit="ghost"))])
    with pytest.raises(AssertionError, match="same number of agents"):
        summarize_team("some", [ALL_ARRIVE, level(1, agent("success", 1.0))])


def test_extra_time_on_the_levels_that_all_solved() -> None:
    def solved(index: int, time: float) -> TeamRow:
        return level(index, agent("success", time), agent("success", time))

    quick = [solved(0, 5.0), solved(1, 6.0), ONE_WAITS]
    slow = [solved(0, 9.0), BOTH_CRASH, solved(2, 4.0)]
    hopeless = [solved(0, 19.0), BOTH_CRASH, BOTH_CRASH]
    results = {"quick": quick, "slow": slow, "hopeless": hopeless}
    first, second, third = summarize_teams(results)
    # Level 0 alone was solved by both; who solves less than half is not compared.
    assert first.common_extra_time is not None
    assert second.common_extra_time is not None
    assert (first.common_extra_time.levels, first.common_extra_time.arrivals) == (1, 2)
    assert (first.common_extra_time.p50, second.common_extra_time.p50) == (1.0, 5.0)
    assert third.common_extra_time is None
    assert summarize_teams({"quick": quick})[0].common_extra_time is None


def test_interval_of_agents_that_fare_alike_is_that_of_levels() -> None:
    # 8 levels of 10 in which all 4 arrive: levels vary by 0.8 * 0.2, so there are as good as 10 agents, not 40.
    found = rate_of_agents([4] * 8 + [0] * 2, 4)
    assert (found.count, found.value) == (32, 0.8)
    assert (found.low, found.high) == pytest.approx(wilson(8, 10))
    one = rate_of_agents([1, 1, 0, 1], 1)
    assert (one.low, one.high) == pytest.approx(wilson(3, 4))
    single = rate_of_agents([2], 4)
    assert (single.low, single.high) == pytest.approx(wilson(0.5, 1))


def test_interval_of_agents_that_fare_as_different_as_can_be_is_that_of_agents() -> None:
    found = rate_of_agents([3] * 10, 4)
    assert (found.low, found.high) == pytest.approx(wilson(30, 40))


def test_interval_of_nobody_and_everybody_is_that_of_levels() -> None:
    none, everybody = rate_of_agents([0] * 10, 4), rate_of_agents([4] * 10, 4)
    assert (none.value, none.low, none.high) == (0.0, *wilson(0, 10))
    assert (everybody.value, everybody.low, everybody.high) == (1.0, *wilson(10, 10))
    assert (rate_of_agents([], 4).low, rate_of_agents([], 4).high) == (0.0, 1.0)


def test_interval_of_independent_agents_is_that_of_agents() -> None:
    # Independent agents: 2 of 2 in nine levels of 36, 1 of 2 in eighteen, 0 of 2 in nine, as tossed coins fall.
    found = rate_of_agents([2] * 9 + [1] * 18 + [0] * 9, 2)
    # Levels vary by 18 * 0.25 / 36 = 0.125, their mean by 0.125 / 36; 0.25 / (0.125 / 36) = 72, all agents.
    assert (found.low, found.high) == pytest.approx(wilson(36, 72))
