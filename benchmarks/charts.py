"""Draw charts and write the tables of README.md, both from results/*.json: python benchmarks/charts.py [--check].

``cases.json`` is a result of run.py, ``peers.json`` one of peers.py; every other file is shown as it is.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import results
import tables

HERE = Path(__file__).parent
README = HERE / "README.md"
PICTURES = HERE / "charts"
BEGIN, END = "<!-- written by charts.py from here -->", "<!-- to here -->"
CASES, PEERS = "cases.json", "peers.json"
COLORS = ("#2563EB", "#F97316", "#16A34A", "#9333EA", "#DC2626", "#64748B", "#CA8A04", "#0891B2")

Found = dict[str, dict[str, Any]]


def load(folder: Path = results.FOLDER) -> Found:
    """Return all committed results by the names of their files."""
    return {file.name: results.read(file) for file in sorted(folder.glob("*.json"))}


def text(found: Found) -> str:
    """Return what README.md says of the results."""
    parts = []
    if PEERS in found or CASES in found:
        figures = {**found.get(CASES, {}).get("results", {}), **found.get(PEERS, {}).get("results", {})}
        parts += ["## Targets and figures", tables.targets(figures)]
    if PEERS in found:
        parts += ["## Figures beside others", "![agent-steps per second](charts/peers.png)"]
        parts.append(tables.beside_others(PEERS, found[PEERS]))
    if CASES in found:
        parts += ["## Figures of all cases", "![growth](charts/growth.png)", "![phases](charts/phases.png)"]
        parts.append(tables.cases(CASES, found[CASES]))
    for name, result in found.items():
        if name not in (CASES, PEERS):
            parts += [f"## {name.removesuffix('.json').capitalize()}", tables.cases(name, result)]
    return "\n\n".join(parts)


def page(found: Found, before: str) -> str:
    """Return README.md with what is between the marks written anew."""
    head, _, rest = before.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return f"{head}{BEGIN}\n\n{text(found)}\n\n{END}{tail}"


def draw(found: Found, folder: Path = PICTURES) -> list[Path]:
    """Write the charts for which there are figures, and return their files."""
    import matplotlib

    matplotlib.use("Agg")
    made = []
    wanted: list[tuple[str, str, Callable[[Any], Any]]] = [
        ("peers.png", PEERS, rates),
        ("growth.png", CASES, growth),
        ("phases.png", CASES, phases),
    ]
    for name, source, chart in wanted:
        if source in found:
            folder.mkdir(exist_ok=True)
            figure = chart(found[source]["results"])
            figure.savefig(folder / name, dpi=110, metadata={"Software": None})
            made.append(folder / name)
    return made


def rates(figures: Mapping[str, Mapping[str, float]]) -> Any:
    """Return bars of agent-steps per second, by medians, for each work and who played it."""
    from matplotlib.figure import Figure

    players = {work: _medians(found) for work, found in figures.items()}
    heights = [max(1, len(found)) for found in players.values()]
    chart = Figure(figsize=(8.0, 1.0 + 0.3 * sum(heights)), layout="constrained")
    panels = chart.subplots(len(players), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for panel, (work, found) in zip(panels, players.items(), strict=True):
        names = list(reversed(found))
        colors = [COLORS[0] if name.startswith("ours") else COLORS[5] for name in names]
        bars = panel.barh(names, [1e6 / found[name] for name in names], color=colors)
        panel.bar_label(bars, [f"{1e6 / found[name]:,.0f}" for name in names], padding=3, fontsize=7)
        panel.set_ylabel(work, rotation=0, ha="right", va="center")
        panel.set_xscale("log")
        panel.margins(x=0.15)
        panel.tick_params(labelsize=7)
    panels[-1].set_xlabel("agent-steps per CPU second of one thread")
    return chart


def _medians(found: Mapping[str, float]) -> dict[str, float]:
    ending = "_median_us"
    return {name.removesuffix(ending): us for name, us in found.items() if name.endswith(ending)}


def growth(figures: Mapping[str, Mapping[str, float]]) -> Any:
    """Return one panel for each growth curve, microseconds per agent and step."""
    from matplotlib.figure import Figure

    chart = Figure(figsize=(9.0, 6.0), layout="constrained")
    for panel, what in zip(chart.subplots(2, 2).ravel(), ("agents", "obstacles", "beams", "worlds"), strict=True):
        curves = {"": sized(figures.get(f"growth/{what}", {}), what, "")}
        if what == "worlds":
            curves = {
                name: sized(figures.get("s1/faces", {}), what, name) for name in ("core", "vector_env", "vec_env")
            }
            curves["C twin"] = sized(figures.get("s1/twin", {}), what, "twin")
        for (name, curve), color in zip(curves.items(), COLORS, strict=False):
            if curve:
                panel.loglog(list(curve), list(curve.values()), "o-", color=color, label=name)
        if any(name and curve for name, curve in curves.items()):
            panel.legend(fontsize=8)
        values = [value for curve in curves.values() for value in curve.values()]
        if values:  # a narrow axis would make much of little
            panel.set_ylim(0.5 * min(values), 2.0 * max(values))
        panel.set_xlabel(what)
        panel.set_ylabel("us per agent and step")
        panel.grid(which="both", alpha=0.25)
    return chart


def sized(figures: Mapping[str, float], unit: str, what: str) -> dict[int, float]:
    """Return microseconds by size, of the figures ``<what>_<size>_<unit>_us``."""
    found = {}
    for name, value in figures.items():
        match = tables.SIZED.match(name)
        if match and (match["unit"], match["what"], match["rest"]) == (unit, what, "us"):
            found[int(match["count"])] = value
    return found


def phases(figures: Mapping[str, Mapping[str, float]]) -> Any:
    """Return what share of a step each phase takes, alone and in the largest batch."""
    from matplotlib.figure import Figure

    bars: dict[str, dict[str, float]] = {}
    for case, found in figures.items():
        if not case.startswith("phases/"):
            continue
        for name, value in found.items():
            match = tables.SIZED.match(name)
            if match and match["rest"] != "whole_us":
                label = f"{case.removeprefix('phases/')}, {match['count']}"
                bars.setdefault(label, {})[match["rest"].removesuffix("_us").replace("_", " ")] = value
    chart = Figure(figsize=(9.0, 1.5 + 0.35 * len(bars)), layout="constrained")
    panel = chart.subplots()
    names = list(dict.fromkeys(phase for found in bars.values() for phase in found))
    for k, phase in enumerate(names):
        totals = {label: sum(found.values()) or 1.0 for label, found in bars.items()}
        left = [sum(found.get(one, 0.0) for one in names[:k]) / totals[label] for label, found in bars.items()]
        width = [found.get(phase, 0.0) / totals[label] for label, found in bars.items()]
        hatch = "" if k < len(COLORS) else "///"
        panel.barh(list(bars), width, left=left, label=phase, color=COLORS[k % len(COLORS)], hatch=hatch, alpha=0.85)
    panel.invert_yaxis()
    panel.set_xlabel("share of a step (world, number of worlds)")
    if names:
        panel.legend(fontsize=7, ncols=6, loc="upper center", bbox_to_anchor=(0.5, -0.25 if len(bars) < 6 else -0.12))
    return chart


def main() -> int:
    """Write README.md and the charts, or say whether README.md is as it should be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if README.md is out of date")
    asked = parser.parse_args()
    found = load()
    before = README.read_text(encoding="utf-8")
    after = page(found, before)
    if asked.check:
        return int(before != after)
    README.write_text(after, encoding="utf-8")
    for file in draw(found):
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
