"""Put the results of several training seeds into one JSON file, one picture and the table of README.md.

    python agents/summarize.py cluttered_room runs/cluttered_room/seed_* --test runs/cluttered_room/test

writes results/cluttered_room.json and .png beside this file, copies the policies to policies/, and prints the table.
"""

from __future__ import annotations

import argparse
import json
import shutil
from pathlib import Path
from statistics import median
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

HERE = Path(__file__).parent
MARKS = ("95%", "98%", "99%")


def read_seed(run: Path, test: dict[str, Any]) -> dict[str, Any]:
    """Return what one run came to: its curve, the seconds to each mark and its row on the test levels."""
    config = json.loads((run / "config.json").read_text())
    curve = json.loads((run / "curve.json").read_text())
    return {
        "run": run.name,
        "settings": config["settings"],
        "machine": config["machine"],
        "training_seconds": curve["points"][-1]["training_seconds"],
        "cpu_seconds": curve["points"][-1]["cpu_seconds"],
        "steps": curve["points"][-1]["steps"],
        "seconds_to": curve["seconds_to"],
        "dev_success": curve["points"][-1]["success"],
        "test": next(row for row in test["policies"] if row["policy"] == run.name),
        "curve": curve["points"],
    }


def draw(path: Path, title: str, seeds: list[dict[str, Any]], success: str = "success", low: float = 60.0) -> None:
    """Draw the learning curves of all seeds over training seconds."""
    figure = Figure(figsize=(7.2, 4.0), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for seed in seeds:
        seconds = [point["training_seconds"] for point in seed["curve"]]
        axes.plot(seconds, [100 * point["success"] for point in seed["curve"]], lw=1.4, label=seed["run"])
    for mark in (95, 98):
        axes.axhline(mark, color="#d9dee3", lw=1, zorder=0)
    levels = seeds[0]["curve"][-1]["levels"]
    axes.set(xlabel="training time [s]", ylabel=f"{success} on {levels:,} dev levels [%]")
    axes.set(ylim=(low, 100.5), xlim=(0, None))
    axes.set_title(title, loc="left", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    figure.savefig(path)


def percent(rate: dict[str, float]) -> str:
    """Return a rate with its interval."""
    return f"{100 * rate['value']:.1f} [{100 * rate['low']:.1f}, {100 * rate['high']:.1f}]"


def rows(seeds: list[dict[str, Any]], references: list[dict[str, Any]]) -> list[str]:
    """Return the lines of the table."""
    lines = [
        "| policy | success % [95 % interval] | collision % | timeout % | SPL "
        "| s to 95 % | s to 98 % | training s | steps |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for seed in seeds:
        marks = [seed["seconds_to"][mark] for mark in MARKS[:2]]
        times = " | ".join("-" if value is None else f"{value:.1f}" for value in marks)
        lines.append(f"{_figures(seed['test'])} | {times} | {seed['training_seconds']:.0f} | {seed['steps']:,} |")
    lines += [f"{_figures(row)} | | | | |" for row in references]
    return lines


def _figures(row: dict[str, Any]) -> str:
    collision, timeout = (100 * row[name]["value"] for name in ("collision", "timeout"))
    return f"| {row['policy']} | {percent(row['success'])} | {collision:.1f} | {timeout:.1f} | {row['spl']:.3f}"


def main() -> None:
    """Read the runs, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("--name", help="name of the results and policies, in place of the scenario's")
    parser.add_argument("--low", type=float, default=60.0, help="lowest success on the picture [%%]")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--test", required=True, type=Path, help="folder of `irsim-gym evaluate` with all runs")
    asked = parser.parse_args()
    test = json.loads((asked.test / "summary.json").read_text())
    seeds = [read_seed(run, test) for run in asked.runs]
    references = [row for row in test["policies"] if row["policy"] not in {run.name for run in asked.runs}]
    (HERE / "results").mkdir(exist_ok=True)
    (HERE / "policies").mkdir(exist_ok=True)
    result = {
        "scenario": asked.scenario,
        "conditions": test["conditions"],
        "median_test_success": median(seed["test"]["success"]["value"] for seed in seeds),
        "seeds": seeds,
        "references": references,
    }
    name = asked.name or asked.scenario
    (HERE / "results" / f"{name}.json").write_text(json.dumps(result, indent=1) + "\n")
    draw(
        HERE / "results" / f"{name}.png",
        f"{name}: PPO, {len(seeds)} seed{'s' * (len(seeds) > 1)}",
        seeds,
        low=asked.low,
    )
    for run in asked.runs:
        shutil.copyfile(run / "policy.zip", HERE / "policies" / f"{name}_{run.name}.zip")
    print("\n".join(rows(seeds, references)))


if __name__ == "__main__":
    main()
