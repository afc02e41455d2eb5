"""Charts of results: bars beside others, growth curves, and what the phases of a step take."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tables

PICTURES = Path(__file__).parent / "charts"
CASES, PEERS = "cases.json", "peers.json"
COLORS = ("#2563EB", "#F97316", "#16A34A", "#9333EA", "#DC2626", "#64748B", "#CA8A04", "#0891B2")
OURS, TWIN, OTHERS = COLORS[0], COLORS[3], COLORS[5]

WHO = {
    "ours": "irsim_gym",
    "ours_core": "irsim_gym, core",
    "ours_vec_env": "irsim_gym, VecEnv",
    "ours_single": "irsim_gym, one world",
    "ours_batch": "irsim_gym, 64 worlds",
    "ours_twin": "C twin",
    "irsim": "IR-SIM",
    "vmas": "VMAS",
    "jaxnav": "JaxNav",
}
PANELS = {"agents": "ORCA crowd in one world", "obstacles": "S1, 64 worlds", "beams": "S1, 64 worlds", "worlds": "S1"}

Figures = Mapping[str, Mapping[str, float]]
Found = dict[str, dict[str, Any]]


def draw(found: Found, folder: Path = PICTURES) -> list[Path]:
    """Write the charts for which there are figures, and return their files."""
    import matplotlib

    matplotlib.use("Agg")
    cases, beside = (found.get(name, {}).get("results", {}) for name in (CASES, PEERS))
    charts = {}
    if any(map(_medians, beside.values())):
        charts["peers.png"] = rates(beside)
    if CASES in found:
        charts |= {"growth.png": growth(cases, beside), "phases.png": phases(cases)}
    folder.mkdir(exist_ok=True)
    for name, chart in charts.items():
        chart.savefig(folder / name, dpi=110, metadata={"Software": None})
    return [folder / name for name in charts]


def rates(figures: Figures) -> Any:
    """Return bars of agent-steps per second, by medians, for each work and who played it."""
    from matplotlib.figure import Figure

    players = {work: medians for work, found in figures.items() if (medians := _medians(found))}
    heights = [len(found) for found in players.values()]
    chart = Figure(figsize=(8.0, 1.0 + 0.3 * sum(heights)), layout="constrained")
    panels = chart.subplots(len(players), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    for panel, (work, found) in zip(panels, players.items(), strict=True):
        names = list(reversed(found))
        colors = [TWIN if name == "ours_twin" else OURS if name.startswith("ours") else OTHERS for name in names]
        bars = panel.barh([WHO.get(name, name) for name in names], [1e6 / found[name] for name in names], color=colors)
        panel.bar_label(bars, [f"{1e6 / found[name]:,.0f}" for name in names], padding=3, fontsize=7)
        panel.set_title(work, fontsize=8, loc="left", pad=3)
        panel.set_xscale("log")
        panel.margins(x=0.15)
        panel.tick_params(labelsize=7)
    panels[-1].set_xlabel("agent-steps per CPU second of one thread, by medians; more is better")
    return chart


def _medians(found: Mapping[str, float]) -> dict[str, float]:
    ending = "_median_us"
    return {name.removesuffix(ending): us for name, us in found.items() if name.endswith(ending)}


def growth(figures: Figures, beside: Figures | None = None) -> Any:
    """Return one panel for each growth curve, microseconds per agent and step; navground's crowds beside ours."""
    from matplotlib.figure import Figure

    chart = Figure(figsize=(11.0, 6.0), layout="constrained")
    panels = chart.subplots(2, 3).ravel()
    for panel, (what, title) in zip(panels, PANELS.items(), strict=False):
        _curves(panel, _growth_of(what, figures, beside or {}))
        panel.set_title(title, fontsize=9)
        panel.set_xlabel(what)
        panel.set_ylabel("us of CPU per agent and step")
    _curves(panels[4], _threads(figures.get("growth/threads", {})))
    panels[4].set_title("threads", fontsize=9)
    panels[4].set_xlabel("threads")
    panels[4].set_ylabel("us (wall) per world and step")
    panels[5].set_axis_off()
    return chart


def _growth_of(what: str, figures: Figures, beside: Figures) -> dict[str, dict[int, float]]:
    if what == "worlds":
        names = {"core": "core", "vector_env": "VectorEnv", "vec_env": "VecEnv"}
        curves = {text: sized(figures.get("s1/faces", {}), what, name) for name, text in names.items()}
        return {**curves, "C twin": sized(figures.get("s1/twin", {}), what, "twin")}
    curves = {"irsim_gym": sized(figures.get(f"growth/{what}", {}), what, "")}
    if what == "agents":
        crowds = {work: found.get("navground_us") for work, found in beside.items() if work.startswith("orca_")}
        curves["navground"] = {int(work.removeprefix("orca_")): us for work, us in crowds.items() if us is not None}
    return curves


def _threads(found: Mapping[str, float]) -> dict[str, dict[int, float]]:
    curves: dict[str, dict[int, float]] = {}
    for name, value in found.items():
        match = re.match(r"(\w+)_(\d+)_worlds_(\d+)_threads_wall_us", name)
        if match:
            curves.setdefault(f"{match[1]}, {match[2]} worlds", {})[int(match[3])] = value
    return curves


def _curves(panel: Any, curves: Mapping[str, Mapping[int, float]]) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    drawn = {name: curve for name, curve in curves.items() if curve}
    for (name, curve), color in zip(drawn.items(), COLORS, strict=False):
        panel.loglog(list(curve), list(curve.values()), "o-", color=color, label=name)
    if len(drawn) > 1:
        panel.legend(fontsize=7)
    values = [value for curve in drawn.values() for value in curve.values()]
    if values:  # a narrow axis would make much of little
        panel.set_ylim(0.5 * min(values), 2.0 * max(values))
        sizes = sorted({size for curve in drawn.values() for size in curve})
        panel.set_xticks(sizes, [f"{size:,}" for size in sizes], fontsize=7, rotation=30)
        panel.set_xticks([], minor=True)
        panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        panel.yaxis.set_minor_formatter(NullFormatter())
    panel.grid(alpha=0.25)


def sized(figures: Mapping[str, float], unit: str, what: str) -> dict[int, float]:
    """Return microseconds by size, of the figures ``<what>_<size>_<unit>_us``."""
    found = {}
    for name, value in figures.items():
        match = tables.SIZED.match(name)
        if match and (match["unit"], match["what"], match["rest"]) == (unit, what, "us"):
            found[int(match["count"])] = value
    return found


def phases(figures: Figures) -> Any:
    """Return what share of a step each phase takes on the plain path, alone and in the largest batch."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    bars, wholes = _phases_of(figures)
    chart = Figure(figsize=(10.0, 1.7 + 0.35 * len(bars)), layout="constrained")
    panel = chart.subplots()
    names = list(dict.fromkeys(phase for found in bars.values() for phase in found))
    colors = colormaps["tab20"].colors  # type: ignore[attr-defined]
    totals = {label: sum(found.values()) or 1.0 for label, found in bars.items()}
    for k, phase in enumerate(names):
        left = [sum(found.get(one, 0.0) for one in names[:k]) / totals[label] for label, found in bars.items()]
        width = [found.get(phase, 0.0) / totals[label] for label, found in bars.items()]
        panel.barh(list(bars), width, left=left, label=phase, color=colors[k % len(colors)])
    for row, label in enumerate(bars):
        plain, fused = (wholes[label].get(name) for name in ("whole", "fused"))
        told = [f"{value:.3g} us {name}" for name, value in (("plain", plain), ("fused", fused)) if value is not None]
        panel.text(1.01, row, ", ".join(told), va="center", fontsize=7)
    panel.invert_yaxis()
    panel.set_xlim(0.0, 1.0)
    panel.set_xlabel("share of a step on the plain path; per agent and step: plain path, and fused into one call")
    if names:
        panel.legend(fontsize=7, ncols=6, loc="upper center", bbox_to_anchor=(0.5, -0.25 if len(bars) < 6 else -0.12))
    return chart


def _phases_of(figures: Figures) -> tuple[dict[str, dict[str, float]], dict[str, dict[str, float]]]:
    """Return microseconds of each phase, and of whole steps, by world and number of worlds."""
    bars: dict[str, dict[str, float]] = {}
    wholes: dict[str, dict[str, float]] = {}
    for case, found in figures.items():
        if not case.startswith("phases/"):
            continue
        for name, value in found.items():
            match = tables.SIZED.match(name)
            if match:
                count, phase = int(match["count"]), match["rest"].removesuffix("_us").replace("_", " ")
                label = f"{case.removeprefix('phases/')}, {count:,} world{'s' * (count > 1)}"
                kind = wholes if phase in ("whole", "fused") else bars
                wholes.setdefault(label, {})
                kind.setdefault(label, {})[phase] = value
    return bars, wholes
