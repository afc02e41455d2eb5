"""Put the results of several training seeds into one JSON file, one picture and the table of README.md.

    python agents/studies/summarize.py cluttered_room runs/cluttered_room/seed_* --test runs/cluttered_room/test

writes results/cluttered_room.json and .png beside this file, copies the policies to policies/, and prints the table.
`irsim-gym train --seeds` writes the same in its folder. The runs may also have been evaluated as one method, in the
order in which they are given here (`ppo=RUN,RUN,...`). With `--json-only`, nothing but results/NAME.json is written.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

from irsim_gym.evaluation import write_json
from irsim_gym.training import (
    Figures,
    markdown_table,
    named_as_runs,
    said_of_seeds,
    seed_cells,
    summarize_seeds,
    write_seeds,
)

HERE = Path(__file__).parents[1]


def write(
    scenario: str, runs: Sequence[Path], tests: Sequence[Path], name: str | None, out: Path, *, json_only: bool = False
) -> Figures:
    """Sum up, write the results and copy the policies; return the sum.

    Args:
        scenario: The scenario.
        runs: Folders of the runs.
        tests: Folders of `irsim-gym evaluate`, each with all runs.
        name: Of the files; None for the scenario's.
        out: Where results/ and policies/ are.
        json_only: Draw no picture and copy no policies.
    """
    summary = summarize_seeds(scenario, runs, [_read(test, runs) for test in tests])
    name = name or scenario
    if json_only:
        write_json(out / "results" / f"{name}.json", summary)
        return summary
    write_seeds(out / "results", name, summary)
    (out / "policies").mkdir(parents=True, exist_ok=True)
    for run in runs:
        shutil.copyfile(run / "policy.zip", out / "policies" / f"{name}_{run.name}.zip")
    return summary


def _read(test: Path, runs: Sequence[Path]) -> Figures:
    """Return an evaluation, with the names of the runs."""
    found: Figures = json.loads((test / "summary.json").read_text(encoding="utf-8"))
    named = {row["policy"] for row in found["policies"]}
    return found if {run.name for run in runs} <= named else named_as_runs(found, runs)


def main() -> None:
    """Read the runs, and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--name", help="name of the results and policies, in place of the scenario's")
    parser.add_argument("--test", required=True, type=Path, help="folder of `irsim-gym evaluate` with all runs")
    parser.add_argument("--json-only", action="store_true", help="draw no picture and copy no policies")
    asked = parser.parse_args()
    summary = write(asked.scenario, asked.runs, [asked.test], asked.name, HERE, json_only=asked.json_only)
    shares = [seed["test"]["success"]["value"] for seed in summary["seeds"]]
    said = said_of_seeds(shares, summary["worst_of_method"])
    print(*markdown_table(*seed_cells(summary)), "", said, sep="\n")


if __name__ == "__main__":
    main()
