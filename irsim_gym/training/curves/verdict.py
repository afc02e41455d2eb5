"""Diagnosis of a training whose policy hardly ever reaches the goal, with advice.

It uses the episodes with which checkpoints are scored. The shares that it needs are stored in the learning curve.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from irsim_gym.evaluation.measures.metrics import EpisodeRow
from irsim_gym.scenario.specs.spec import Scenario
from irsim_gym.tasks import Task
from irsim_gym.tasks.definition.sight import all_of, idle_robots, unseen

RARELY = 0.1
"""Success below which a training gets a diagnosis."""
HARDLY = 0.25
"""Share of the path: an episode that reaches its time limit with less than this counts as standing still."""
SOME, MOST = 0.05, 0.5
"""Shares of episodes that count as some of them, and as most of them."""
SHORT = 500_000
"""Number of steps below which a training counts as short."""
HITS = ("obstacle", "moving obstacle", "robot", "map")
COLUMNS = ("stood_still", "hit_at_once", "no_way", "too_far", *(f"hit_{hit.replace(' ', '_')}" for hit in HITS))
"""Scores that ``failures`` adds to a point of the learning curve."""


def failures(rows: Sequence[EpisodeRow], speeds: Sequence[float], limit: float) -> dict[str, float]:
    """Return the kinds of failures, as shares of all episodes.

    Args:
        speeds: Maximum linear speed of the robot in each episode [m/s].
        limit: Time limit of the episodes [s].

    Returns:
        The shares of episodes by kind:

        - ``stood_still``: the time limit ended the episode before a quarter of the shortest path was driven;
        - ``hit_at_once``: the robot collided in the first step;
        - ``no_way``: no collision-free path was found;
        - ``too_far``: the shortest path takes longer than the time limit at full speed;
        - ``hit_obstacle`` and so on: the robot collided with this kind of body.
    """
    ways = [row.optimum for row in rows]
    slow = [row.outcome == "timeout" and row.path_length < HARDLY * row.optimum < math.inf for row in rows]
    late = [limit * speed < way < math.inf for way, speed in zip(ways, speeds, strict=True)]
    counts = {
        "stood_still": sum(slow),
        "hit_at_once": sum(row.outcome == "collision" and row.steps <= 1 for row in rows),
        "no_way": sum(not math.isfinite(way) for way in ways),
        "too_far": sum(late),
        **{f"hit_{hit.replace(' ', '_')}": sum(row.hit == hit for row in rows) for hit in HITS},
    }
    return {name: count / max(len(rows), 1) for name, count in counts.items()}


def verdict(point: Mapping[str, float], scenario: Scenario, task: Task, look: str) -> list[str]:
    """Return lines with the diagnosis of a training that ended near 0 % success; an empty list for other trainings.

    Args:
        point: Last point of the learning curve.
        look: Command that shows what the policy does.
    """
    arrived = point.get("individual_success", point["success"])
    if arrived >= RARELY or "stood_still" not in point:
        return []
    who = "robots" if "individual_success" in point else "episodes"
    lines = [f"{arrived:.1%} of {who} arrive. Of all {who} {_ends(point)}."]
    return [*lines, "what to try:", *(f"  - {hint}" for hint in _hints(point, scenario, task)), f"  - look: {look}"]


def look_command(scenario: str, folder: Path, *, team: bool, task: str | None = None) -> str:
    """Return the command that shows a run's policy on some ``dev`` levels."""
    levels = " ".join(f"--level {level}" for level in range(3))
    options = f"{' --team' if team else ''}{'' if task is None else f' --task {task}'}"
    return f"irsim-gym record {scenario} {folder} --split dev {levels}{options} --html"


def _ends(point: Mapping[str, float]) -> str:
    """Return a text about how episodes end, the most frequent end first."""
    still, late = point["stood_still"], point["timeout"] - point["stood_still"]
    ends = [(still, f"stand still (the time ends before {HARDLY:.0%} of the way is driven)"), (late, "run out of time")]
    ends += [(point["left_world"], "leave the world"), (point.get("deadlocked", 0.0), "are stuck")]
    ends += [(point[f"hit_{hit.replace(' ', '_')}"], f"collide with {_one(hit)}") for hit in HITS]
    return ", ".join(f"{share:.0%} {words}" for share, words in sorted(ends, reverse=True) if share >= 0.005)


def _one(hit: str) -> str:
    return {"obstacle": "an obstacle", "map": "the map"}.get(hit, f"a {hit}")


def _hints(point: Mapping[str, float], scenario: Scenario, task: Task) -> list[str]:
    """Return advice, the most reliable first."""
    hints = []
    idle = idle_robots(scenario, task)
    if idle:
        hints.append(f"{idle}: --team trains {all_of(scenario)}")
    hidden = unseen(scenario, task)
    if hidden:
        hints.append(
            f"the learner observes nothing of {hidden}: a sensor and the observation scan, "
            "or nearest_bodies, would show it"
        )
    if point["no_way"] >= SOME:
        hints.append(
            f"in {point['no_way']:.0%} of the levels, no path wide enough for the robot was found: "
            "`reachable: true` in its distribution, or fewer and smaller obstacles"
        )
    if point["too_far"] >= SOME:
        hints.append(
            f"in {point['too_far']:.0%} of the levels, the path takes longer than max_steps "
            f"({task.max_steps}) at full speed: raise it"
        )
    if point["hit_at_once"] >= SOME:
        hints.append(
            f"{point['hit_at_once']:.0%} collide in their first step: "
            "a larger `clearance` where robots and obstacles begin"
        )
    if point["steps"] < SHORT:
        hints.append(f"more --steps: {point['steps']:,.0f} are few")
    hints += _hints_by_end(point, task)
    return hints


def _hints_by_end(point: Mapping[str, float], task: Task) -> list[str]:
    """Return advice against the most frequent end of episodes."""
    weights = {type(reward).__name__: reward.weight for reward in task.rewards}
    if point["stood_still"] >= MOST:
        fine = f" (now {weights['Collision']:g})" if "Collision" in weights else ""
        return [
            "moving costs more than standing still: start with nearer goals or fewer obstacles, "
            f"a smaller weight of the reward collision{fine}, and more --steps"
        ]
    if point["collision"] >= MOST:
        moving = point["hit_moving_obstacle"] + point["hit_robot"] >= 0.5 * point["collision"]
        speeds = ", or past_scans, which shows moving obstacles" if moving else ""
        return [f"more --steps; more beams or range of the sensor{speeds}; a larger weight of the reward clearance"]
    if point["left_world"] >= MOST:
        return ["a wall around the world (a linestring), which a sensor sees; or a larger weight of left_world"]
    return [
        "a larger max_steps; `potential: geodesic` of the reward progress, which leads around obstacles; "
        "a goal_threshold that a step does not jump over"
    ]
