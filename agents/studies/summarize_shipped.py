"""Put what `irsim-gym train NAME` makes of each shipped scenario into one JSON file and one table of README.md.

    for name in quick_start crossing; do
      irsim-gym train $name --out runs/shipped/$name --dev-levels 0
      irsim-gym evaluate $name runs/shipped/$name --split dev --no-references --out runs/shipped/$name/dev
    done
    python agents/studies/summarize_shipped.py runs/shipped/*

Each run's row takes the place of an earlier one of the same scenario and seed in results/shipped.json; the others stay.
Teams are evaluated with `--team`. Without runs the table is written anew from the JSON file.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from summarize import HERE

from irsim_gym.training import percent

RESULTS, PAGE = HERE / "results" / "shipped.json", HERE / "README.md"
BEGIN, END = "<!-- shipped: begin -->", "<!-- shipped: end -->"
MARK = 0.95
MARKS = {"irsim_quick": 0.9, "like_irsims_quick_start": 0.9, "door_queue": 0.75}
"""Those with a mark of their own: no sensor, large boxes anywhere and a goal as small as a step is long; and one door
for six robots, of which all have to arrive."""
ELSEWHERE = ("cluttered_room", "dense_room", "circle_swap", "random_swap")
"""Scenarios with five seeds in tables of their own."""
HEAD = (
    "| scenario | seed | success % [95 % interval] | collision % | timeout % | left % | SPL | steps | training CPU s |",
    "|---|---|---|---|---|---|---|---|---|",
)


def read_run(run: Path) -> dict[str, Any]:
    """Return what one run came to on the `dev` levels.

    Raises:
        SystemExit: The run was evaluated elsewhere, on other levels, or its evaluation holds another policy.
    """
    config = json.loads((run / "config.json").read_text(encoding="utf-8"))
    last = json.loads((max((run / "checkpoints").iterdir()) / "progress.json").read_text(encoding="utf-8"))
    test = json.loads((run / "dev" / "summary.json").read_text(encoding="utf-8"))
    if test["conditions"]["split"] != "dev" or [row["policy"] for row in test["policies"]] != [run.name]:
        raise SystemExit(f"{run}/dev is to hold this run alone, on `dev` levels")
    figures = test["policies"][0]
    settings = config["settings"]
    return {
        "scenario": Path(settings["scenario"]).stem,
        "seed": settings["seed"],
        "team": settings["hyperparameters"]["team"],
        "algorithm": settings["algorithm"],
        "success": figures.get("cooperative_success") or figures["success"],
        "individual_success": figures.get("individual_success"),
        **{name: figures[name]["value"] for name in ("collision", "timeout", "left_world")},
        "spl": figures["spl"],
        **{name: last[name] for name in ("steps", "training_seconds", "cpu_seconds")},
        "conditions": test["conditions"],
        "machine": config["machine"],
    }


def merged(old: list[dict[str, Any]], new: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows by scenario and seed, newer ones in place of older ones."""
    rows = {(row["scenario"], row["seed"]): row for row in [*old, *new]}
    return [rows[key] for key in sorted(rows)]


def table(rows: list[dict[str, Any]]) -> str:
    """Return the table of the page."""
    return "\n".join([*HEAD, *map(line, rows)])


def line(row: dict[str, Any]) -> str:
    """Return a run's line; of a team the success is that of whole teams."""
    failed = " | ".join(f"{100 * row[name]:.1f}" for name in ("collision", "timeout", "left_world"))
    team = "" if row["individual_success"] is None else f"; robots {100 * row['individual_success']['value']:.1f}"
    return (
        f"| `{row['scenario']}`{' (team)' if team else ''} | {row['seed']} | {percent(row['success'])}{team} "
        f"| {failed} | {row['spl']:.3f} | {row['steps']:,} | {row['cpu_seconds']:.0f} |"
    )


def rewritten(page: str, rows: list[dict[str, Any]]) -> str:
    """Return the page with a new table between its marks."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{table(rows)}\n{END}{after}"


def main() -> None:
    """Read the runs, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", type=Path)
    asked = parser.parse_args()
    old = json.loads(RESULTS.read_text(encoding="utf-8"))["runs"] if RESULTS.exists() else []
    rows = merged(old, [read_run(run) for run in asked.runs])
    RESULTS.write_text(json.dumps({"runs": rows}, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(rewritten(PAGE.read_text(encoding="utf-8"), rows), encoding="utf-8")
    print(table(rows))


if __name__ == "__main__":
    main()
