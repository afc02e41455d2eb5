"""Draw charts and write the tables of README.md, both from results/*.json: python benchmarks/charts.py [--check].

``cases.json`` is a result of run.py, ``peers.json`` one of peers.py; every other file is shown as it is.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import pictures
import results
import tables
from pictures import CASES, PEERS, Found

HERE = Path(__file__).parent
README = HERE / "README.md"
BEGIN, END = "<!-- written by charts.py from here -->", "<!-- to here -->"


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
    for file in pictures.draw(found):
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
