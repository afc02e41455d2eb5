"""The learning curve of a run: scores of its checkpoints on ``dev`` levels, computed after the training."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from rich.console import Console

from irsim_gym.base.errors import UnreadableFileError
from irsim_gym.base.outside_files import json_object, reading
from irsim_gym.evaluation.comparison.evaluate import WORLDS
from irsim_gym.evaluation.measures.metrics import summarize, wilson
from irsim_gym.evaluation.measures.optimum import Optima
from irsim_gym.evaluation.measures.team_metrics import summarize_team
from irsim_gym.evaluation.policies.policy import Policy
from irsim_gym.evaluation.protocol.progress_bars import progress_bar
from irsim_gym.evaluation.protocol.protocol import evaluate
from irsim_gym.evaluation.protocol.tables import plain, write_csv, write_json
from irsim_gym.evaluation.protocol.teams import evaluate_team, top_speed
from irsim_gym.evaluation.saved_policies.checkpoint_files import list_checkpoints, load_progress
from irsim_gym.evaluation.saved_policies.policies import load_policy
from irsim_gym.scenario.text.messages import with_parameters
from irsim_gym.tasks import Episodes
from irsim_gym.training.curves.learning_curve import draw_curve
from irsim_gym.training.curves.verdict import COLUMNS, failures
from irsim_gym.training.settings.run import Run, Settings

DEV_LEVELS = 1000
MARKS = (0.90, 0.95, 0.98, 0.99)
"""Success rates for which the training time is reported."""
PROGRESS = ("steps", "training_seconds", "cpu_seconds")
"""Progress of the run at a point of its curve."""
_NEEDED = (*PROGRESS, "levels", "success")

Point = dict[str, float]
"""A point of a learning curve: progress and scores by name."""


def score_run(
    run: Run, *, levels: int = DEV_LEVELS, console: Console | None = None, picture: bool = True
) -> list[Point]:
    """Score all checkpoints that have no score yet, and write ``curve.csv``, ``curve.json`` and ``curve.png``.

    The data files are updated after each checkpoint, so an interrupted scoring continues where it stopped.

    Args:
        run: The run, finished or not.
        levels: Number of ``dev`` levels in each scenario.
        console: Console for the progress; None for standard error.
        picture: Whether to draw ``curve.png``.

    Returns:
        A point for each checkpoint, in the order of steps.
    """
    settings = run.settings()
    n_levels = levels * len(settings.parts())
    whole = [point for point in read_curve(run) if point["levels"] == n_levels and set(COLUMNS) <= set(point)]
    points = {int(point["steps"]): point for point in whole}
    waiting = [path for path in list_checkpoints(run.checkpoints) if int(path.name) not in points]
    if waiting:
        places = [
            (name, part.request().episodes(max(1, min(WORLDS, levels))), Optima("dev"))
            for name, part in zip(settings.names, run.own_settings().parts(), strict=True)
        ]
        screen = console or Console(stderr=True)
        if not screen.is_terminal:
            count = f"{len(waiting)} checkpoint{'' if len(waiting) == 1 else 's'}"
            screen.print(f"scoring {count} on {levels:,} dev levels", highlight=False)
        with progress_bar(screen) as bar:
            for path in bar.track(waiting, description="scoring checkpoints"):
                policy, figures = load_policy(path / "policy.zip"), partial(_figures, team=settings.is_team)
                scores = {name: figures(policy, episodes, levels, optima) for name, episodes, optima in places}
                progress = load_progress(path)
                point = {**{name: getattr(progress, name) for name in PROGRESS}, **combined(scores)}
                points[int(point["steps"])] = point
                _write(run, _sorted(points))
    curve = _sorted(points)
    if curve and picture:
        named = scenario_title(settings)
        team = "a team by " if settings.is_team else ""
        title = f"{named}, {team}{settings.algorithm.upper()}, seed {settings.seed}, scored on {levels:,} dev levels"
        draw_curve(run.folder / "curve.png", curve, title)
    return curve


def read_curve(run: Run) -> list[Point]:
    """Return the scores on disk; none if there are none yet, or they cannot be read."""
    try:
        with reading(run.curve, "learning curve"):
            points = [{name: point[name] for name in (*_NEEDED, *point)} for point in json_object(run.curve)["points"]]
            return points if all(isinstance(point[name], int | float) for point in points for name in _NEEDED) else []
    except UnreadableFileError:
        return []


def reached(points: Sequence[Point], mark: float) -> Point | None:
    """Return the first point from which on the success never falls below ``mark``; None if there is none."""
    held: Point | None = None
    for point in reversed(points):
        if point["success"] < mark:
            break
        held = point
    return held


def seconds_to(points: Sequence[Point]) -> dict[str, float | None]:
    """Return the training time [s] until the success stays above each mark, by mark; None where it never does."""
    marks = {f"{mark:.0%}": reached(points, mark) for mark in MARKS}
    return {name: None if point is None else point["training_seconds"] for name, point in marks.items()}


def scenario_title(settings: Settings) -> str:
    """Return the name of a run's scenario with its parameters, or the names of the scenarios of a mixture."""
    if settings.mixture:
        return " and ".join(settings.names)
    return with_parameters(settings.scenario, settings.parameters)


def combined(points: Mapping[str, Point]) -> Point:
    """Return the scores of a single scenario, or the overall scores of several with those of each as ``NAME/SCORE``.

    Overall, ``levels`` is the sum, and all other scores are means, because each scenario has the same number of levels.
    The confidence interval is computed for all levels together.
    """
    if len(points) == 1:
        return next(iter(points.values()))
    parts = list(points.values())
    point = {name: sum(part[name] for part in parts) / len(parts) for name in parts[0]}
    point["levels"] = sum(part["levels"] for part in parts)
    low, high = wilson(round(point["success"] * point["levels"]), point["levels"])
    point |= {"success_low": low, "success_high": high}
    return point | {f"{name}/{key}": value for name, part in points.items() for key, value in part.items()}


def scenario_point(point: Point, name: str) -> Point:
    """Return the scores in one scenario from a point of a mixture's curve."""
    values = {key.removeprefix(f"{name}/"): value for key, value in point.items() if key.startswith(f"{name}/")}
    return {**{key: point[key] for key in PROGRESS}, **values}


def _sorted(points: dict[int, Point]) -> list[Point]:
    return [points[steps] for steps in sorted(points)]


def _figures(policy: Policy, episodes: Episodes, levels: int, optima: Optima, *, team: bool) -> Point:
    """Return the scores of a checkpoint. Of a team, ``success`` is that of whole teams, other rates are per robot."""
    summary: Any
    if team:
        levels_played = evaluate_team(policy, episodes, levels, "dev", optima=optima)
        summary = summarize_team("", levels_played)
        agents = [agent for level in levels_played for agent in level.agents]
        rows, speeds = [agent.episode for agent in agents], [agent.top_speed for agent in agents]
        success, each = summary.cooperative_success, {"individual_success": summary.individual_success.value}
        waits = {"deadlocked": summary.deadlocked.value, "makespan": summary.makespan}
    else:
        rows = evaluate(policy, episodes, levels, "dev", optima=optima)
        summary, speeds = summarize("", rows), [top_speed(episodes, 0, 0)] * len(rows)
        success, each, waits = summary.success, {}, {}
    return {
        "levels": levels,
        **{"success": success.value, "success_low": success.low, "success_high": success.high},
        **each,
        **{name: getattr(summary, name).value for name in ("collision", "timeout", "left_world")},
        **waits,
        "spl": summary.spl,
        **failures(rows, speeds, episodes.task.max_steps * float(episodes.simulation.model.step_time[0])),
    }


def _write(run: Run, points: list[Point]) -> None:
    write_json(run.curve, {"seconds_to": plain(seconds_to(points)), "points": points})
    write_csv(run.folder / "curve.csv", list(points[0]), points)
