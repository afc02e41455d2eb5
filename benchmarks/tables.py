"""Results as Markdown: nothing here knows a number, all come from committed JSON."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from targets import TARGETS
from targets import table as target_rows

SIZED = re.compile(r"^(?P<what>.*?)_?(?P<count>\d+)_(?P<unit>worlds|agents|obstacles|beams)_(?P<rest>.+)$")
"""A figure that depends on a size: ``core_64_worlds_us``."""

VERDICTS = {"aim": "aim reached", "reached": "reached", "missed": "**missed**", "not measured": "not measured"}


def number(value: float | None) -> str:
    """Return a value with three digits that count."""
    if value is None:
        return ""
    if abs(value) >= 999.5:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def wrapped(text: str, indent: str = "") -> str:
    """Return text in lines of at most 120 characters, those after the first with ``indent``."""
    return textwrap.fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def provenance(name: str, result: Mapping[str, Any]) -> str:
    """Return where a result comes from: file, machine, versions, load, commit, date."""
    machine = result["machine"]
    versions = {"Python": machine["python"], **machine["versions"]}
    named = ", ".join(f"{one} {versions[one]}" for one in ("Python", "numpy", "numba", "torch") if versions.get(one))
    return wrapped(
        f"[results/{name}](results/{name}): {machine['processor']}, {machine['cores']} cores, {named}; "
        f"load {machine['load']:.2f} at the start; commit {machine['commit'][:10]}, {machine['date'][:10]}."
    )


def pivot(figures: Mapping[str, float]) -> str:
    """Return the figures of a case: those that depend on a size as a table of sizes, then the others by name."""
    cells: dict[str, dict[str, float]] = {}
    plain: dict[str, float] = {}
    for figure, value in figures.items():
        found = SIZED.match(figure)
        if found is None:
            plain[figure] = value
            continue
        count = int(found["count"])
        row = f"{count:,} {found['unit'] if count != 1 else found['unit'].removesuffix('s')}"
        column = "_".join(part for part in (found["what"], found["rest"]) if part)
        cells.setdefault(row, {})[column] = value
    parts = []
    if cells:
        columns = list(dict.fromkeys(column for row in cells.values() for column in row))
        table = [[row, *(number(values.get(column)) for column in columns)] for row, values in cells.items()]
        head = ["", *columns]
        if len(columns) > len(cells):
            head, *table = [list(line) for line in zip(head, *table, strict=True)]
        parts.append(markdown(head, table))
    if plain:
        parts.append(markdown(["figure", "value"], [[name, number(value)] for name, value in plain.items()]))
    return "\n\n".join(parts)


def cases(name: str, result: Mapping[str, Any]) -> str:
    """Return all cases of a result of ``run.py``."""
    parts = [provenance(name, result)]
    for case, figures in result["results"].items():
        parts.append(f"`{case}`\n\n{pivot(figures)}")
    return "\n\n".join(parts)


PAINTERS = {"raster": "irsim_gym", "naive": "matplotlib, everything drawn anew", "irsim": "IR-SIM"}


def drawing(figures: Mapping[str, float]) -> str:
    """Return what a picture with everything on takes, and how many times as long as ours."""
    times = {name: figures[f"{name}_frame_ms"] for name in PAINTERS if f"{name}_frame_ms" in figures}
    ours = times.get("raster")
    rows = [[PAINTERS[name], number(ms), number(None if ours is None else ms / ours)] for name, ms in times.items()]
    return markdown(["a picture of 600 x 600 with everything on", "ms", "times as long"], rows)


def beside_others(name: str, result: Mapping[str, Any]) -> str:
    """Return a result of ``peers.py``: a table, the differences of each work, and missing simulators."""
    rows, who = [], result["peers"]
    for work, figures in result["results"].items():
        for figure, least in figures.items():
            player = figure.removesuffix("_us")
            if figure.endswith("_median_us") or player == figure:
                continue
            others = [figures.get(f"{player}_{key}") for key in ("median_us", "times_slower")]
            rows.append([work, player, *map(number, (least, *others))])
    parts = [provenance(name, result), markdown(["work", "who", "least [us]", "median [us]", "times slower"], rows)]
    if rounds := [counts for players in result.get("rounds", {}).values() for counts in players.values()]:
        parts.append(rounds_text(rounds))
    parts += [
        f"`{work}`: {figure.removesuffix('_apart_m')}'s robots end at most {value:.2g} m from ours."
        for work, figures in result["results"].items()
        for figure, value in figures.items()
        if figure.endswith("_apart_m")
    ]
    parts.append("Differences between the works:")
    lines = []
    for said in who.values():
        title = f"{said['package']} {said['version'] or ''}".strip()
        lines += [f"- {title}, `{work}`: {'; '.join(notes)}." for work, notes in said["works"].items() if notes]
        lines += [f"- {title} is missing: {said['missing']}." for _ in range("missing" in said)]
        lines += [f"- {title}, `{work}`: {why}." for work, why in said.get("failures", {}).items()]
    parts.append("\n".join(wrapped(line, "  ") for line in lines))
    return "\n\n".join(parts)


WORKS = {
    "s1_single": "one robot, 180 beams, 10 obstacles, as a `gymnasium.Env`",
    "s1_batch": "the same, 1,024 worlds in a `VectorEnv`",
    "s3_cave": "one robot in the map of a cave, 64 worlds",
    "s3_floor_plan": "one robot in the map of a flat, 64 worlds",
    "s4": "10 robots with 100 beams among 10 moving discs, 1,024 worlds, each robot",
    "s5": "one robot that pushes 10 boxes and discs, 180 beams, 1,024 worlds",
    "s2_rvo": "10 robots that avoid each other by RVO, each robot",
    "orca_100": "100 discs that avoid each other by ORCA, each disc",
    "orca_1000": "1,000 discs, each disc",
}
"""The works in the table of the first page."""

OTHERS = {"irsim": "IR-SIM", "vmas": "VMAS", "jaxnav": "JaxNav", "navground": "navground"}


def front(result: Mapping[str, Any]) -> str:
    """Return the first page's table: the time of a step here, and how many times longer it takes elsewhere."""
    rows = []
    for work, text in WORKS.items():
        figures = result["results"].get(work, {})
        if (ours := figures.get("ours_median_us")) is None:
            continue
        slower = [figures.get(f"{other}_median_us") for other in OTHERS]
        rows.append([text, number(ours), *(number(None if other is None else other / ours) for other in slower)])
    return markdown(["a step of", "us", *(f"{name}, times" for name in OTHERS.values())], rows)


def rounds_text(rounds: Sequence[Mapping[str, float]]) -> str:
    """Return the numbers of rounds, and the range of the processor's pace."""
    played, rejected, kept = (int(sum(one[name] for one in rounds)) for name in ("played", "rejected", "disturbed"))
    loops = [one["calibration_us"] for one in rounds if "calibration_us" in one] or [0.0]
    return wrapped(
        f"{played} rounds were run; {rejected} were rejected as disturbed, {kept} kept although disturbed. "
        f"The median of the calibrating loop was {min(loops):.0f} to {max(loops):.0f} us, depending on the process."
    )


def targets(results: Mapping[str, Mapping[str, float]]) -> str:
    """Return the targets, and whether the results reach them."""
    rows = [
        [row["text"], number(row["value"]), number(row["least"]), number(row["aim"]), VERDICTS[row["verdict"]]]
        for row in target_rows(results)
    ]
    assert len(rows) == len(TARGETS)
    return markdown(["figure", "measured", "at least / at most", "aim", ""], rows)
