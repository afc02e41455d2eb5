"""Run the benchmarks: python benchmarks/run.py [-f REGEX] [--json FILE]."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from cases import CASES
from machine import describe
from rich.console import Console
from rich.table import Table


def main() -> None:
    """Run the chosen cases, show their figures and write them down."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-f", "--filter", default="", help="run only the cases whose names match")
    parser.add_argument("--json", type=Path, help="write the figures, with machine and versions, to this file")
    asked = parser.parse_args()
    chosen = {name: case for name, case in CASES.items() if re.search(asked.filter, name)}
    if not chosen:
        parser.error(f"no case matches '{asked.filter}'; there are: {', '.join(CASES)}")
    console, table, results = Console(), Table("case", "figure", "value"), {}
    machine = describe()
    for name, case in chosen.items():
        with console.status(name):
            results[name] = case()
        for figure, value in results[name].items():
            table.add_row(name, figure, f"{value:.4g}")
    console.print(table)
    if asked.json:
        draft = asked.json.with_suffix(".tmp")
        draft.write_text(json.dumps({"machine": machine, "results": results}, indent=1) + "\n")
        draft.replace(asked.json)


if __name__ == "__main__":
    main()
