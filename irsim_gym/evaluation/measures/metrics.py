"""Metrics: one row per episode, and summaries of many rows."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any, Self

OUTCOMES = ("success", "collision", "timeout", "left_world", "deadlock", "misplaced")
ARRIVALS = ("success", "misplaced")
"""Outcomes of episodes that end because the robot believes that it has arrived."""
HITS = ("obstacle", "moving obstacle", "robot")
HIT_OF_KIND = ("", *HITS, "obstacle")
"""The word for each ``HitKind``; a map counts as an obstacle."""
CONFIDENCE = 0.95
MEANS = (
    *("spl", "sct", "min_clearance", "acceleration", "jerk", "intrusion_025", "intrusion_045", "time_to_collision"),
    *("shield", "delivered", "effort"),
)
MEANS_OF_SUCCESSES = ("path_length", "path_ratio")


@dataclass(frozen=True)
class EpisodeRow:
    """One finished episode.

    Attributes:
        level: Index of the level in its split.
        outcome: One of ``OUTCOMES``.
        hit: What the robot collided with, one of ``HITS``; empty without a collision.
        steps: Number of steps.
        time: Duration [s].
        path_length: Distance driven [m].
        optimum: Length of the shortest collision-free path from start to goal among standing obstacles [m]; infinite
            if none was found.
        min_clearance: Minimum distance between the robot's outline and another body's [m].
        least_time: Lower bound of the time for the robot's limits of speed and acceleration [s]; NaN if not measured.
        acceleration: Mean size of the derivative of the velocity vector [m/s2]; NaN if not measured.
        jerk: Mean size of its second derivative [m/s3], likewise.
        intrusion_025: Share of steps with less than 0.25 m to a person; NaN if there are no people.
        intrusion_045: Share of steps with less than 0.45 m to a person, likewise.
        time_to_collision: Minimum time to collision with a person [s], see ``people``; infinite if it met none, NaN if
            there are no people.
        goals_reached: Number of its successive goals that it reached, without unit; NaN if it has only one.
        goals_per_minute: ``goals_reached`` by duration, or by the time limit if it did not reach all [1/min]; likewise.
        goal_distance: True distance from the goal at the end [m], whatever the robot believes; NaN if not measured.
        shield: Share of steps in which the shield changed the command; NaN without one.
        delivered: Share of bodies to be pushed that lie in their targets at the end; NaN unless the task asks for it.
        effort: Work against what the agent pushes [J]; NaN where bodies do not push each other.
    """

    level: int
    outcome: str
    hit: str
    steps: int
    time: float
    path_length: float
    optimum: float
    min_clearance: float
    least_time: float = math.nan
    acceleration: float = math.nan
    jerk: float = math.nan
    intrusion_025: float = math.nan
    intrusion_045: float = math.nan
    time_to_collision: float = math.nan
    goals_reached: float = math.nan
    goals_per_minute: float = math.nan
    goal_distance: float = math.nan
    shield: float = math.nan
    delivered: float = math.nan
    effort: float = math.nan

    @property
    def is_success(self) -> bool:
        """Whether the agent arrived."""
        return self.outcome == "success"

    @property
    def spl(self) -> float:
        """Success by path length, a share: optimum / max(optimum, path length).

        Source: Anderson et al. 2018, arXiv:1807.06757.

        A success counts as optimal if no optimum was found, or if it started at its goal.
        """
        if self.outcome != "success":
            return 0.0
        if not math.isfinite(self.optimum) or self.path_length <= self.optimum:
            return 1.0
        return self.optimum / self.path_length

    @property
    def sct(self) -> float:
        """Success by completion time, a share: least time / time. NaN if the least time is not known.

        Source: Yokoyama et al. 2021, arXiv:2103.08022.
        """
        if math.isnan(self.least_time):
            return math.nan
        if self.outcome != "success":
            return 0.0
        return 1.0 if self.time <= self.least_time else self.least_time / self.time

    @property
    def path_ratio(self) -> float:
        """Ratio of path length to optimum of a success, else NaN.

        It can be slightly below 1: an episode ends within the goal's tolerance, the optimum at the goal itself.
        """
        if self.outcome != "success" or not 0.0 < self.optimum < math.inf:
            return math.nan
        return self.path_length / self.optimum


@dataclass(frozen=True)
class Rate:
    """A share with its 95 % interval, which is Wilson's unless stated otherwise.

    Attributes:
        count: Number of counted items.
        value: Their share of all items.
        low: Lower end of the interval, a share; ``value`` if all episodes are copies of one, see ``are_copies``.
        high: Upper end of the interval, likewise.
    """

    count: int
    value: float
    low: float
    high: float

    @property
    def is_exact(self) -> bool:
        """Whether there is no interval, because all episodes are copies of one."""
        return self.low == self.high

    def exact(self) -> Self:
        """Return the share without an interval."""
        return replace(self, low=self.value, high=self.value)


def wilson(count: float, total: float) -> tuple[float, float]:
    """Return the score interval of a share (Wilson 1927), which stays inside [0, 1] and is accurate near its ends."""
    if total == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2.0)
    share = count / total
    centre = share + z * z / (2.0 * total)
    spread = z * math.sqrt(share * (1.0 - share) / total + z * z / (4.0 * total * total))
    scale = 1.0 + z * z / total
    low = 0.0 if count == 0 else (centre - spread) / scale
    high = 1.0 if count == total else (centre + spread) / scale
    return low, high


def rate(count: int, total: int) -> Rate:
    """Return ``count`` of ``total`` as a rate; 0 of 0 is 0 with the interval [0, 1]."""
    return Rate(count, count / total if total else 0.0, *wilson(count, total))


def are_copies(rows: Sequence[EpisodeRow]) -> bool:
    """Return whether several episodes are copies of one, as where nothing is drawn for a level."""
    kinds = {(row.outcome, row.steps, row.path_length, row.optimum, row.min_clearance) for row in rows}
    return len(rows) > 1 and len(kinds) == 1


@dataclass(frozen=True, kw_only=True)
class SharedFigures:
    """The figures of one policy that those of single robots and of teams share; of a team, over all its robots.

    Attributes:
        policy: Name of the policy.
        collision: Share of episodes that ended in a collision; ``collision_with`` splits it by what was hit.
        timeout: Share ended by the time limit.
        left_world: Share that left the world's rectangle.
        deadlock: Share ended by the task's ending ``deadlocked``.
        misplaced: Share that believed to have arrived and was elsewhere, where odometry is disturbed.
        spl: Mean of success weighted by path length over all episodes, a share.
        sct: Mean of success weighted by completion time over all episodes, a share.
        path_length: Mean distance driven in the successes [m]; NaN without any.
        path_ratio: Mean ratio of path length to optimum over the successes; NaN without any.
        min_clearance: Mean over all episodes of the minimum clearance [m].
        acceleration: Mean of the mean sizes of acceleration [m/s2], over all episodes.
        jerk: Mean of the mean sizes of jerk [m/s3], over all episodes.
        intrusion_025: Mean share of steps nearer than 0.25 m to a person; NaN if there are no people.
        intrusion_045: Mean share of steps nearer than 0.45 m, likewise.
        time_to_collision: Mean of the minimum times to collision with a person [s], over episodes that met one.
        throughput: Mean over levels of the rate of reached goals, of a team all its goals [1/min]; NaN if a robot has
            only one goal.
        end_distance: Mean true distance from the goal at the end [m], over successes and misplaced ones.
        shield: Mean share of steps in which the shield changed the command; NaN without one.
        delivered: Mean share of bodies to be pushed that lie in their targets at the end; NaN unless asked for.
        effort: Mean work against what is pushed [J]; NaN where bodies do not push each other.
        goals_per_collision: Number of reached goals for each collision, without unit; infinite without any.
    """

    policy: str
    collision: Rate
    collision_with: dict[str, Rate]
    timeout: Rate
    left_world: Rate
    deadlock: Rate
    misplaced: Rate
    spl: float
    sct: float
    path_length: float
    path_ratio: float
    min_clearance: float
    acceleration: float
    jerk: float
    intrusion_025: float = math.nan
    intrusion_045: float = math.nan
    time_to_collision: float = math.nan
    throughput: float = math.nan
    end_distance: float = math.nan
    shield: float = math.nan
    delivered: float = math.nan
    effort: float = math.nan
    goals_per_collision: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Summary(SharedFigures):
    """The figures of one policy on one set of levels.

    Attributes:
        episodes: Number of episodes.
        success: Share that reached the goal.
        time: Mean duration of the successes [s]; NaN without any.
    """

    episodes: int
    success: Rate
    time: float


def summarize(policy: str, rows: Sequence[EpisodeRow]) -> Summary:
    """Summarise the episodes of one policy."""
    total = len(rows)
    counts = {outcome: sum(row.outcome == outcome for row in rows) for outcome in OUTCOMES}
    hits = {hit: sum(row.outcome == "collision" and row.hit == hit for row in rows) for hit in HITS}
    assert sum(counts.values()) == total, "the outcomes must equal the number of episodes"
    assert sum(hits.values()) == counts["collision"], "every collision must have a kind"
    shares: dict[str, Any] = {outcome: rate(count, total) for outcome, count in counts.items()}
    if are_copies(rows):
        shares = {outcome: share.exact() for outcome, share in shares.items()}
    return Summary(
        policy=policy,
        episodes=total,
        **shares,
        collision_with={hit: rate(count, total) for hit, count in hits.items()},
        time=mean([row.time for row in rows if row.outcome == "success"]),
        throughput=mean([row.goals_per_minute for row in rows]),
        **means(rows),
    )


def means(rows: Sequence[EpisodeRow]) -> dict[str, Any]:
    """Return the means that the figures of single robots and of teams share."""
    successes = [row for row in rows if row.outcome == "success"]
    of_all = {name: mean([getattr(row, name) for row in rows]) for name in MEANS}
    of_all["end_distance"] = mean([row.goal_distance for row in rows if row.outcome in ARRIVALS])
    goals = math.fsum(row.is_success if math.isnan(row.goals_reached) else row.goals_reached for row in rows)
    collisions = sum(row.outcome == "collision" for row in rows)
    of_all["goals_per_collision"] = goals / collisions if collisions else math.inf
    return of_all | {name: mean([getattr(row, name) for row in successes]) for name in MEANS_OF_SUCCESSES}


def mean(values: Sequence[float]) -> float:
    """Return the mean of the finite values; NaN if there are none."""
    finite = [value for value in values if math.isfinite(value)]
    return math.fsum(finite) / len(finite) if finite else math.nan
