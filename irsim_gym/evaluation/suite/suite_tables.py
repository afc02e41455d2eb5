"""The tables of a run of the suite, in Markdown."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from irsim_gym.base import families
from irsim_gym.base.families import OBSERVATIONS
from irsim_gym.evaluation.levels.played import QUARTER_NAMES
from irsim_gym.evaluation.measures.worst_levels import WORST
from irsim_gym.evaluation.suite.suite_record import SuiteRecord
from irsim_gym.tasks.terms.term import needs_of

DASH = "-"
ENDS = ("timeout", "left_world", "deadlock")
"""Outcomes other than success and collision; a table shows those that occur."""

Figures = Mapping[str, Any]
"""Figures of a method as ``scores`` computes them, as plain data with None in place of NaN."""
Reader = Callable[[Figures], str]


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
        f"scenario {member['sha256'][:12]}, level set {of['level_hash']}",
    ]
    given = ", ".join(f"{name} = {value}" for name, value in member["parameters"].items())
    return "; ".join([*([given] if given else []), *words]) + "."


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
    return _markdown("Benchmarks", [note], ["benchmark", *methods], rows)


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
    return _markdown("Overall", [note], heads, rows)


def member_markdown(record: SuiteRecord, name: str) -> str:
    """Return the table of one benchmark as Markdown."""
    scores = record.figures[name]
    is_team = len(record.members[name]["conditions"]["agents"]) > 1
    read = _columns(list(scores.values()), is_team)
    shown = {head: [cell(score) for score in scores.values()] for head, cell in read.items()}
    shown["needs"] = [_needs(record, name, method) for method in scores]
    shown = {head: cells for head, cells in shown.items() if any(cell != DASH for cell in cells)}
    rows = [[method, *(cells[row] for cells in shown.values())] for row, method in enumerate(scores)]
    return _markdown(name, _notes(record, name), ["method", *shown], rows)


def _needs(record: SuiteRecord, member: str, method: str) -> str:
    """Return what a robot must have for the observations of a method."""
    entries = record.runs.get(member, {}).get(method, [])
    names = dict.fromkeys(name for entry in entries for name in entry.get("observes") or ())
    families.load()
    return ", ".join(needs_of(OBSERVATIONS.entry(name).kind() for name in names if name in OBSERVATIONS)) or DASH


def _columns(scores: Sequence[Figures], is_team: bool) -> dict[str, Reader]:
    """Return the function that reads each column's cell from the figures of a method."""
    hits = [hit for hit in (scores[0]["hits"] if scores else ()) if any(score["hits"][hit] for score in scores)]
    ends = [end for end in ENDS if any(score["outcomes"][end] for score in scores)]
    columns: dict[str, Reader] = {"success [%]": _percents("success", "value")}
    columns["95 % interval"] = lambda score: _interval(score["success"])
    if is_team:
        columns["robots that arrive [%]"] = _percents("individual")
    columns["collision [%]"] = _percents("outcomes", "collision")
    columns |= {f"with {hit} [%]": _percents("hits", hit) for hit in hits}
    columns |= {f"{end.replace('_', ' ')} [%]": _percents("outcomes", end) for end in ends}
    if is_team:
        columns["deadlocked [%]"] = _percents("deadlocked")
    columns |= {f"{quarter} [%]": _percents("quarters", quarter) for quarter in QUARTER_NAMES}
    columns |= {f"worst {share} [%]": _percents("worst", share) for share in WORST}
    columns |= {f"shared worst {share} [%]": _percents("worst_shared", share) for share in WORST}
    columns |= {"SPL": _numbers("spl", 3), "SCT": _numbers("sct", 3)}
    if is_team:
        columns["makespan [s]"] = _numbers("makespan", 1)
    return columns | {
        "goals per minute": _numbers("throughput", 2),
        "time [s]": _numbers("time", 2),
        "common time [s]": _numbers("common_time", 2),
        "common path [m]": _numbers("common_path", 2),
        "clearance [m]": _numbers("clearance", 3),
        "steps within 0.25 m [%]": _percents("intrusion_025"),
        "within 0.45 m [%]": _percents("intrusion_045"),
        "time to collision [s]": _numbers("time_to_collision", 2),
        "acceleration [m/s2]": _numbers("acceleration", 2),
        "jerk [m/s3]": _numbers("jerk", 1),
    }


def _percents(*keys: str) -> Reader:
    """Return a reader of the share at nested keys, in percent; figures of earlier versions may lack it."""

    def read(score: Figures) -> str:
        found: Any = score
        for key in keys:
            found = (found or {}).get(key)
        return _percent(found)

    return read


def _numbers(key: str, digits: int) -> Reader:
    """Return a reader of a number with so many decimals."""
    return lambda score: _number(score.get(key), digits)


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
    left = {
        method: entry["left_out"]
        for method, entries in record.runs[name].items()
        for entry in entries
        if "left_out" in entry
    }
    notes += [f"Without {method}: {reason}." for method, reason in left.items()]
    return [note for note in notes if note]


def _markdown(title: str, notes: Sequence[str], heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table with its heading and notes; the first column holds text."""
    lines = [f"### {title}", "", *(line for note in notes for line in (note, ""))]
    if rows:
        lines += [_line(heads), "|---" + "|---:" * (len(heads) - 1) + "|"]
    return "\n".join([*lines, *map(_line, rows), ""])


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


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


def _number(value: float | None, digits: int) -> str:
    return DASH if value is None else f"{value:.{digits}f}"
