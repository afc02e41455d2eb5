"""Run the benchmarks: python benchmarks/run.py [-f REGEX] [--json FILE] [--tiny] [--list]."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import results
from catalogue import CASES
from effort import FULL, TINY, flatten
from machine import describe
from rich.console import Console
from rich.table import Table


def main() -> None:
    """Run the chosen cases, show their figures and write them down."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-f", "--filter", default="", help="run only the cases whose names match")
    parser.add_argument("--json", type=Path, help="write the figures, with machine and versions, to this file")
    parser.add_argument("--tiny", action="store_true", help="smallest sizes, one step: to see that a case runs")
    parser.add_argument("--list", action="store_true", help="show the names of the cases and stop")
    asked = parser.parse_args()
    chosen = {name: case for name, case in CASES.items() if re.search(asked.filter, name)}
    if not chosen:
        parser.error(f"no case matches '{asked.filter}'; there are: {', '.join(CASES)}")
    if asked.list:
        print("\n".join(chosen))
        return
    console, table = Console(), Table("case", "figure", "value", "noise")
    found: dict[str, dict[str, float]] = {}
    noises: dict[str, dict[str, float]] = {}
    machine = describe()
    for name, case in chosen.items():
        with console.status(name):
            figures = case(TINY if asked.tiny else FULL)
        for figure, value, noise in flatten(figures):
            found.setdefault(name, {})[figure] = value
            if noise is not None:
                noises.setdefault(name, {})[figure] = noise
            table.add_row(name, figure, f"{value:.4g}", "" if noise is None else f"{100.0 * noise:.0f} %")
        if asked.json:
            results.write(asked.json, {"machine": machine, "results": found, "noise": noises})
    console.print(table)


if __name__ == "__main__":
    main()
