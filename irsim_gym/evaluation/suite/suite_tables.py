"""The tables of a run of the suite, in Markdown."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.families import OBSERVATIONS
from irsim_gym.base.outside_files import json_object
from irsim_gym.evaluation.protocol.tables import markdown_table
from irsim_gym.evaluation.suite.suite_record import SuiteRecord
from irsim_gym.tasks.terms.term import needs_of

DASH = "-"
COLUMNS = Path(__file__).with_name("columns.json")
"""Columns of the table of a benchmark: ``head``, ``place`` of the figure (nested keys), ``digits`` (none for a share).

Some hold the ``interval`` of an estimate or a strength that was ``played_to`` some greatest one, are for a ``team``
alone, or are left out if nothing is ``occurring``."""

Figures = Mapping[str, Any]
"""Figures of a method as ``scores`` computes them, as plain data with None in place of NaN."""


def markdown(record: SuiteRecord) -> str:
    """Return the tables over all benchmarks, and one for each benchmark, as Markdown."""
    members = [member_markdown(record, name) for name in record.figures]
    return "\n".join(filter(None, [overview(record), _overall(record), *members]))


def conditions_line(member: Mapping[str, Any]) -> str:
    """Return the conditions to name with published figures: robot, goal, speeds, step, limit, sensor, noise."""
    of = member["conditions"]
    limit = of["max_steps"]
    seconds = _each_value(of["step_time"], lambda step: f"{limit * step:g} s") if not isinstance(limit, list) else DASH
    words = [
        f"{of['levels']:,} {of['split']} level{'s' * (of['levels'] != 1)}",
        f"{len(of['agents'])} learners" if len(of["agents"]) > 1 else "1 learner",
        f"footprint {_each_value(of['footprint'], str)}",
        f"goal tolerance {_each_value(of['goal_tolerance'], lambda value: f'{value:g} m')}",
        f"velocities {_bounds(of['velocity_min'], of['velocity_max'])}",
        f"accelerations {_vector(of['acceleration_limit'])}",
        f"step {_each_value(of['step_time'], lambda value: f'{value:g} s')}",
        f"time limit {_each_value(limit, str)} steps ({seconds})",
        _sensor(of),
        *([f"{_each_value(of['goals'], str)} goals each, one after another"] if of.get("goals", 1) != 1 else []),
        *(["noisy motion"] if of["motion_noise"] not in (False, None) else []),
        *([f"disturbed by `{member['disturbed']}`"] if "disturbed" in member else []),
        f"scenario {member['sha256'][:12]}, level set {of['level_hash']}",
    ]
    parameters = ", ".join(f"{name} = {value}" for name, value in member["parameters"].items())
    return "; ".join([*([parameters] if parameters else []), *words]) + "."


def overview(record: SuiteRecord) -> str:
    """Return the success of all methods on all benchmarks as Markdown; "" for a single benchmark."""
    methods = [name for name in record.methods if any(name in scores for scores in record.figures.values())]
    if len(record.figures) < 2 or not methods:
        return ""
    rows = [
        [name, *(_with_interval(scores[method]["success"]) if method in scores else DASH for method in methods)]
        for name, scores in record.figures.items()
    ]
    note = "Success [%], of whole teams where several robots learn, with its 95 % interval."
    return markdown_table("Benchmarks", [note], ["benchmark", *methods], rows)


def _overall(record: SuiteRecord) -> str:
    names = record.overall.get("benchmarks") or []
    if len(names) < 2:
        return ""
    success, better = record.overall["success"], record.overall["improvement"]
    methods = list(success)
    heads = ["method", "success [%]", "95 % interval", *(f"beats {method} [%]" for method in methods)]
    rows = []
    for method in methods:
        beats = [DASH if other == method else _percent(better[method][other]["value"]) for other in methods]
        rows.append([method, _percent(success[method]["value"]), _interval(success[method]), *beats])
    note = (
        "Interquartile mean over benchmarks and policies with a stratified bootstrap interval, and the probability "
        f"that a policy does better than one of another method, over: {', '.join(names)}."
    )
    return markdown_table("Overall", [note], heads, rows)


def member_markdown(record: SuiteRecord, name: str) -> str:
    """Return the table of one benchmark as Markdown."""
    scores = record.figures[name]
    is_team = len(record.members[name]["conditions"]["agents"]) > 1
    columns = [column for column in json_object(COLUMNS)["columns"] if is_team or "team" not in column]
    shown = {column["head"]: _cells(column, list(scores.values())) for column in columns}
    shown["needs"] = [_needs(record, name, method) for method in scores]
    shown = {head: cells for head, cells in shown.items() if any(cell != DASH for cell in cells)}
    rows = [[method, *(cells[row] for cells in shown.values())] for row, method in enumerate(scores)]
    return markdown_table(name, _notes(record, name), ["method", *shown], rows)


def _needs(record: SuiteRecord, member: str, method: str) -> str:
    """Return what a robot must have for the observations of a method."""
    entries = record.runs.get(member, {}).get(method, [])
    names = dict.fromkeys(name for entry in entries for name in entry.get("observes") or ())
    families.load()
    return ", ".join(needs_of(OBSERVATIONS.entry(name).kind() for name in names if name in OBSERVATIONS)) or DASH


def _cells(column: Mapping[str, Any], scores: Sequence[Figures]) -> list[str]:
    """Return the cells of a column, one for each method; figures of earlier versions may lack it."""
    values: list[Any] = list(scores)
    for key in column["place"]:
        values = [(value or {}).get(key) for value in values]
    if "occurring" in column and not any(values):
        return [DASH] * len(values)
    if "played_to" in column:
        return [_up_to(value, column["digits"]) for value in values]
    if "interval" in column:
        return [_interval(value) for value in values]
    return [_number(value, column["digits"]) if "digits" in column else _percent(value) for value in values]


def _notes(record: SuiteRecord, name: str) -> list[str]:
    member, scores = record.members[name], record.figures[name]
    notes = [conditions_line(member)]
    if member["differs"]:
        notes.append(f"Differs from the original: {member['differs']}")
    of = member["conditions"]
    if of.get("certified_by"):
        notes.append(
            f"Difficulty: by how many of {', '.join(of['certified_by'])} fail, the policies of the certificate. "
            f"Levels that none of them solves: {of['unsolved']:,} of {of['levels']:,}."
        )
    common = max((score["common_levels"] for score in scores.values()), default=0)
    if common:
        notes.append(f"Common: the {common:,} levels that all methods with at least half of the levels solved.")
    seeds = {method: score["repetitions"] for method, score in scores.items() if score["repetitions"] > 1}
    if seeds:
        notes.append("Policies: " + ", ".join(f"{method} {count}" for method, count in seeds.items()) + ".")
    left = {method: run["left_out"] for method, runs in record.runs[name].items() for run in runs if "left_out" in run}
    notes += [f"Without {method}: {reason}." for method, reason in left.items()]
    return [note for note in notes if note]


def _sensor(of: Mapping[str, object]) -> str:
    """Return the range sensor in words."""
    if of["beams"] is None:
        return "no range sensor"
    noise = _each_value(of["noise"], lambda std: f"noise of {std:g} m" if std else "without noise")
    beams = _each_value(of["beams"], lambda count: f"{count} beams")
    return f"{beams} up to {_each_value(of['range_max'], lambda value: f'{value:g} m')} {noise}"


def _bounds(low: Any, high: Any) -> str:
    if low and isinstance(low[0], list):
        return ", ".join(dict.fromkeys(_bounds(*pair) for pair in zip(low, high, strict=True)))
    return " and ".join(f"{a:g} to {b:g}" for a, b in zip(low, high, strict=True)) + " m/s, rad/s"


def _vector(values: Any) -> str:
    if values and isinstance(values[0], list):
        return ", ".join(dict.fromkeys(map(_vector, values)))
    if all(value is None for value in values):
        return "unlimited"
    return ", ".join("unlimited" if value is None else f"{value:g}" for value in values)


def _each_value(value: Any, said: Any) -> str:
    """Return a value as text, or the distinct values of several robots."""
    return ", ".join(dict.fromkeys(map(said, value))) if isinstance(value, list) else str(said(value))


def _interval(estimate: Mapping[str, float | None]) -> str:
    low, high = estimate["low"], estimate["high"]
    return DASH if low is None or high is None else f"{100.0 * low:.1f}-{100.0 * high:.1f}"


def _with_interval(estimate: Mapping[str, float | None]) -> str:
    interval = _interval(estimate)
    return _percent(estimate["value"]) + ("" if interval == DASH else f" ({interval})")


def _percent(value: float | None) -> str:
    return DASH if value is None else f"{100.0 * value:.1f}"


def _up_to(found: Mapping[str, float | None] | None, digits: int) -> str:
    """Return a strength that was looked for: ``> 0.8`` if it is beyond the greatest one played."""
    value = found["value"] if found else None
    return f"> {found['played_to']:g}" if found and value is None else _number(value, digits)


def _number(value: float | None, digits: int) -> str:
    return DASH if value is None else f"{value:.{digits}f}"
