"""Run the benchmarks: python benchmarks/run.py [-f REGEX] [--json FILE] [--tiny] [--list]."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import results
from catalogue import CASES
from effort import FULL, TINY, flatten
from machine import describe
from rich.table import Table


def main() -> int:
    """Run the chosen cases, show their figures and write them down; return 1 when a case failed."""
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
        return 0
    console, table = results.console(), Table("case", "figure", "value", "noise")
    found: dict[str, dict[str, float]] = {}
    noises: dict[str, dict[str, float]] = {}
    took: dict[str, float] = {}
    failed: list[str] = []
    machine = describe()
    for name, case in chosen.items():
        begin = time.perf_counter()
        try:
            with console.status(name):
                figures = case(TINY if asked.tiny else FULL)
        except Exception:  # the others are worth their minutes all the same
            console.print_exception()
            failed.append(name)
            continue
        took[name] = round(time.perf_counter() - begin, 1)
        for figure, value, noise in flatten(figures):
            found.setdefault(name, {})[figure] = value
            if noise is not None:
                noises.setdefault(name, {})[figure] = noise
            table.add_row(name, figure, f"{value:.4g}", "" if noise is None else f"{100.0 * noise:.0f} %")
        if asked.json:
            results.write(asked.json, {"machine": machine, "results": found, "noise": noises, "took_s": took})
    console.print(table)
    console.print(f"{sum(took.values()):.0f} s; most of it: {', '.join(most(took))}")
    if failed:
        console.print(f"[red]failed: {', '.join(failed)}")
    return int(bool(failed))


def most(took: Mapping[str, float], count: int = 5) -> list[str]:
    """Return what took longest: ``startup 60 s``."""
    return [f"{name} {s:.0f} s" for name, s in sorted(took.items(), key=lambda one: -one[1])[:count]]


if __name__ == "__main__":
    sys.exit(main())
